"""The settings of the process that drives Ray: its arguments say them all."""

from dataclasses import replace
from pathlib import Path

import pytest

from workers.driver.settings import BINDS_ITSELF, DriverSettings

SETTINGS = DriverSettings(
    socket=Path("/tmp/d3pg-ray-x/pool.sock"),  # noqa: S108
    logs=Path("/data/logs of mine"),
    spool=Path("/data/spool/a.jsonl"),
    scratch="/tmp/d3pg-ray-x",  # noqa: S108
    listener=7,
)


@pytest.mark.parametrize("listener", [7, BINDS_ITSELF])
def test_settings_are_read_as_they_were_written(listener: int) -> None:
    settings = replace(SETTINGS, listener=listener)
    assert DriverSettings.from_arguments(settings.arguments()) == settings


def test_one_that_is_given_no_listener_stands_alone() -> None:
    assert DriverSettings.from_arguments(SETTINGS.arguments()[:-1]).stands_alone
    assert not SETTINGS.stands_alone


def test_a_process_is_known_by_its_scratch_folder() -> None:
    assert f"--scratch={SETTINGS.scratch}" in SETTINGS.arguments()


def test_one_that_lacks_a_setting_does_not_start(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        DriverSettings.from_arguments(SETTINGS.arguments()[1:])
    assert "--socket" in capsys.readouterr().err
