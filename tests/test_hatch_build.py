"""uPlot is brought in byte for byte, from whichever source has it, or not at all."""

from pathlib import Path
from typing import NoReturn

import pytest

import hatch_build

WEB_VENDOR = Path(__file__).parent.parent / hatch_build.VENDOR


@pytest.fixture
def genuine() -> dict[str, bytes]:
    """The files that this checkout's installation brought in, or brings in now."""
    hatch_build.bring_in(WEB_VENDOR)
    return {file.name: (WEB_VENDOR / file.name).read_bytes() for file in hatch_build.FILES}


def absent() -> NoReturn:
    raise FileNotFoundError("npm is not installed")


def test_the_second_source_steps_in_for_altered_files(genuine: dict[str, bytes]) -> None:
    altered = genuine | {"uplot.min.css": genuine["uplot.min.css"] + b" "}
    sources = {"first": lambda: altered, "second": lambda: genuine}
    assert hatch_build.first_genuine(sources) == genuine


def test_a_missing_source_is_passed_over(genuine: dict[str, bytes]) -> None:
    assert hatch_build.first_genuine({"npm": absent, "wheel": lambda: genuine}) == genuine


def test_without_a_genuine_source_the_build_ends_and_says_why(genuine: dict[str, bytes]) -> None:
    altered = genuine | {"uplot.iife.min.js": b"alert(1)"}
    with pytest.raises(RuntimeError, match="not what uPlot") as refusal:
        hatch_build.first_genuine({"wheel": lambda: altered, "npm": absent})
    assert "npm is not installed" in str(refusal.value)


def test_files_in_place_are_kept_and_damaged_ones_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, genuine: dict[str, bytes]
) -> None:
    reads = []

    def wheel() -> dict[str, bytes]:
        reads.append("wheel")
        return genuine

    monkeypatch.setattr(hatch_build, "from_wheel", wheel)
    vendor = tmp_path / "vendor"
    hatch_build.bring_in(vendor)
    hatch_build.bring_in(vendor)
    assert reads == ["wheel"]
    assert (vendor / hatch_build.LICENCE_NAME).read_text() == hatch_build.LICENCE
    (vendor / "uplot.min.css").write_bytes(b"damaged")
    assert not hatch_build.is_complete(vendor)
    hatch_build.bring_in(vendor)
    assert hatch_build.is_complete(vendor)
