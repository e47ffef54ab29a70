from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from pirate_sm.cli.entry import only_run
from pirate_sm.running.recording.read.reader import read_recording
from pirate_sm.views.report.contents import Report
from pirate_sm.views.report.recording_report import report_of

ROOT = Path(__file__).resolve().parents[4]
PATROL = ROOT / "tests" / "robots" / "newt" / "patrol.yaml"


def recorded(folder: Path, name: str, *arguments: str) -> Path:
    """The file with the recording of a run that was made for it."""
    path = folder / f"{name}.mcap"
    CliRunner().invoke(only_run(), [*arguments, "--quiet", "--record", str(path)])
    assert path.exists()
    return path


RUNS = {
    "bend": ("mitre_bend",),
    "dead": ("mitre_bend", "--defect", "wheels_3_4_dead", "--defect", "gamma_2_stiff"),
    "twice": ("mitre_bend", "--defect", "gamma_2_sticks_at_zero"),
    "trace": ("mitre_bend", "--backend", "trace"),
    "patrol": (str(PATROL),),
}


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Gives the recording of one of ``RUNS``, which is made once."""
    folder = tmp_path_factory.mktemp("runs")
    made: dict[str, Path] = {}

    def get(name: str) -> Path:
        if name not in made:
            made[name] = recorded(folder, name, *RUNS[name])
        return made[name]

    return get


@pytest.fixture(scope="session")
def report(recording: Callable[[str], Path]) -> Callable[[str], Report]:
    """Gives the report of one of ``RUNS``."""
    made: dict[str, Report] = {}

    def get(name: str) -> Report:
        if name not in made:
            made[name] = report_of(read_recording(recording(name)))
        return made[name]

    return get
