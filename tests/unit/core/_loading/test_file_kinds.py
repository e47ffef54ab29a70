"""What a file is, told by its content."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._loading.mission.loader import load_mission
from pirate_sm.core._loading.pipe import load_pipe
from pirate_sm.core._loading.problems import LoadError
from pirate_sm.core._loading.references import FileKind, kind_of, kind_of_text
from pirate_sm.core._loading.robot.twin import load_twin

ROOT = Path(__file__).resolve().parents[4]
PIRATE = ROOT / "hardware_profiles" / "pirate_ii"
NEWT = ROOT / "tests" / "robots" / "newt"


@pytest.mark.parametrize(
    ("files", "kind"),
    [
        (sorted((ROOT / "sequences").glob("*.yaml")), FileKind.MISSION),
        (sorted((ROOT / "docs" / "examples").glob("*.yaml")), FileKind.MISSION),
        (sorted((ROOT / "sequences" / "pipes").glob("*.yaml")), FileKind.PIPE),
        ([NEWT / "profile.yaml", PIRATE / "profile.yaml"], FileKind.ROBOT),
        ([NEWT / "chart.yaml", PIRATE / "chart.yaml"], FileKind.CHART),
        (sorted((PIRATE / "experiments").glob("*.yaml")), FileKind.EXPERIMENT),
        (sorted((ROOT / "campaigns").glob("*.yaml")), FileKind.CAMPAIGN),
        (sorted((ROOT / "demos").glob("*.yaml")), FileKind.SCENE),
        ([*(ROOT / "panels").glob("*.yaml"), NEWT / "pedals.yaml"], FileKind.PANEL),
        (sorted((ROOT / "cameras").glob("*.yaml")), FileKind.CAMERA),
        ([ROOT / "pyproject.toml", ROOT / ".pre-commit-config.yaml"], FileKind.OTHER),
        ([ROOT, ROOT / "no_such_file.yaml"], FileKind.UNREADABLE),
    ],
    ids=[
        "missions",
        "examples",
        "pipes",
        "robots",
        "charts",
        "experiments",
        "campaigns",
        "scenes",
        "panels",
        "cameras",
        "others",
        "none",
    ],
)
def test_every_file_of_the_project_is_known(files: list[Path], kind: FileKind) -> None:
    assert {kind_of(file) for file in files} == {kind}


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("format: 1\nmission: m\nrobot: [unclosed\nphasess: {}\n", FileKind.MISSION),
        ("--- \nmission: m\nends: {}\n", FileKind.MISSION),
        ("---\n  mission: m\n  ends: {}\n", FileKind.MISSION),
        ("format: 1\rmission: m\rphases: {}\r", FileKind.MISSION),  # as old Macs end a line
        ("# a pipe\r\npipe: p\r\ndiameter: 1 m\r\n", FileKind.PIPE),
        ('{"mission": "m", "phases": {}}', FileKind.MISSION),
        ('"pipe": p\n"diameter": 1 m\n', FileKind.PIPE),
        ("{diameter: 1 m, segments: []}", FileKind.PIPE),
        ("pipe: p\nruns: {}\n", FileKind.PIPE),
        ("diameter: 1 m\nruns: {}\n", FileKind.PIPE),
        ("runs: {}\njunctions: {}\n", FileKind.PIPE),
        ("robot: r\nzeros: {a: 1 deg}\n", FileKind.CALIBRATION),
        ("robot: r\nmotors: {wheel: {hold_torque: 1 Nm}}\n", FileKind.TWIN),
        ("robot: r\nfriction: {static: 1, kinetic: 1}\n", FileKind.TWIN),
        ("experiment: 1\nmisions: {}\n", FileKind.EXPERIMENT),
        ("campaign: c\nmisions: []\n", FileKind.CAMPAIGN),
        ("scene: s\ntitle: t\nstepps: []\n", FileKind.SCENE),
        ("- {phase: a, trigger: b}\n", FileKind.SCRIPT),
        ("[{phase: a, trigger: b}]\n", FileKind.SCRIPT),
        ("- {phase: a, tigger: b, after: 1 s}\n", FileKind.SCRIPT),
        ("{trigger: a}\n", FileKind.SCRIPT),
        ("trigger: a\nafter: 1 s\n", FileKind.SCRIPT),
        ("format: 1\ncourse:\n- {happens: start}\n", FileKind.SCRIPT),
        ("course: [{happens: start}]\n", FileKind.SCRIPT),
        ("trigger: a\njobs: []\n", FileKind.OTHER),
        ("course: Latin\nteacher: x\n", FileKind.OTHER),
        ("- {phase: one}\n- {phase: two}\n", FileKind.OTHER),
        ("- one\n- two\n", FileKind.OTHER),
        ("# mission: m\n# phases: {}\n", FileKind.OTHER),
        ("jobs:\n  mission: m\n  phases: {}\n", FileKind.OTHER),
        ("", FileKind.OTHER),
    ],
)
def test_a_broken_file_is_known_by_what_is_left(text: str, kind: FileKind) -> None:
    assert kind_of_text(text) is kind


def test_a_file_in_another_encoding_is_known(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text("mission: m\nphases: {}\n", encoding="utf-16")

    assert kind_of(file) is FileKind.MISSION


@given(st.text())
def test_no_text_is_too_strange(text: str) -> None:
    assert isinstance(kind_of_text(text), FileKind)


@pytest.mark.parametrize(
    ("file", "load", "message"),
    [
        ("pipes/house.yaml", load_mission, "expected a mission, and this is a pipe"),
        (
            "climb.yaml",
            partial(load_twin, profile=None),
            "expected a twin, and this is a mission",
        ),
        ("climb.yaml", load_pipe, "expected a pipe, and this is a mission"),
    ],
)
def test_a_file_of_another_kind_is_refused_in_one_sentence(file, load, message) -> None:
    with pytest.raises(LoadError) as caught:
        load(ROOT / "sequences" / file)

    (problem,) = caught.value.problems
    assert problem.message == message
