"""The settings of the process that drives Ray: its arguments say them all."""

from dataclasses import replace
from pathlib import Path

import pytest

from workers.driver.placement import Bounds
from workers.driver.settings import DriverSettings

SETTINGS = DriverSettings(
    listener=7,
    address="",
    least=1,
    most=16,
    worker_bytes=0,
    logs=Path("/data/logs of mine"),
    checkpoints="s3://bucket/prefix",
    spool=Path("/data/spool/a.jsonl"),
    scratch="/tmp/d3pg-ray-x",  # noqa: S108
)


@pytest.mark.parametrize("address", ["", "10.0.0.7:6379"])
def test_settings_are_read_as_they_were_written(address: str) -> None:
    settings = replace(SETTINGS, address=address)
    assert DriverSettings.from_arguments(settings.arguments()) == settings
    assert settings.bounds == Bounds(1, 16)


def test_a_process_is_known_by_its_scratch_folder() -> None:
    assert f"--scratch={SETTINGS.scratch}" in SETTINGS.arguments()


def test_one_that_lacks_a_setting_does_not_start(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        DriverSettings.from_arguments(SETTINGS.arguments()[1:])
    assert "--listener" in capsys.readouterr().err
