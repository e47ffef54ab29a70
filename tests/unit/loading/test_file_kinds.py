"""What a file is, told by its content."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.loading.file_kinds import Kind, kind_of, kind_of_text
from pirate_sm.loading.mission import load_mission
from pirate_sm.loading.pipe_file import load_pipe
from pirate_sm.loading.problems import LoadError
from pirate_sm.loading.robot.twin_file import load_twin

ROOT = Path(__file__).resolve().parents[3]
PIRATE = ROOT / "hardware_profiles" / "pirate_ii"
NEWT = ROOT / "tests" / "robots" / "newt"


@pytest.mark.parametrize(
    ("files", "kind"),
    [
        (sorted((ROOT / "sequences").glob("*.yaml")), Kind.MISSION),
        (sorted((ROOT / "docs" / "examples").glob("*.yaml")), Kind.MISSION),
        (sorted((ROOT / "sequences" / "pipes").glob("*.yaml")), Kind.PIPE),
        ([NEWT / "profile.yaml", PIRATE / "profile.yaml"], Kind.ROBOT),
        ([NEWT / "chart.yaml", PIRATE / "chart.yaml"], Kind.CHART),
        (sorted((PIRATE / "experiments").glob("*.yaml")), Kind.EXPERIMENT),
        (sorted((ROOT / "campaigns").glob("*.yaml")), Kind.CAMPAIGN),
        (sorted((ROOT / "demos").glob("*.yaml")), Kind.SCENE),
        ([*(ROOT / "panels").glob("*.yaml"), NEWT / "pedals.yaml"], Kind.PANEL),
        (sorted((ROOT / "cameras").glob("*.yaml")), Kind.CAMERA),
        ([ROOT / "pyproject.toml", ROOT / ".pre-commit-config.yaml"], Kind.OTHER),
        ([ROOT, ROOT / "no_such_file.yaml"], Kind.UNREADABLE),
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
def test_every_file_of_the_project_is_known(files: list[Path], kind: Kind) -> None:
    assert {kind_of(file) for file in files} == {kind}


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("format: 1\nmission: m\nrobot: [unclosed\nphasess: {}\n", Kind.MISSION),
        ("--- \nmission: m\nends: {}\n", Kind.MISSION),
        ("---\n  mission: m\n  ends: {}\n", Kind.MISSION),
        ("format: 1\rmission: m\rphases: {}\r", Kind.MISSION),  # as old Macs end a line
        ("# a pipe\r\npipe: p\r\ndiameter: 1 m\r\n", Kind.PIPE),
        ('{"mission": "m", "phases": {}}', Kind.MISSION),
        ('"pipe": p\n"diameter": 1 m\n', Kind.PIPE),
        ("{diameter: 1 m, segments: []}", Kind.PIPE),
        ("pipe: p\nruns: {}\n", Kind.PIPE),
        ("diameter: 1 m\nruns: {}\n", Kind.PIPE),
        ("runs: {}\njunctions: {}\n", Kind.PIPE),
        ("robot: r\nzeros: {a: 1 deg}\n", Kind.CALIBRATION),
        ("robot: r\nmotors: {wheel: {hold_torque: 1 Nm}}\n", Kind.TWIN),
        ("robot: r\nfriction: {static: 1, kinetic: 1}\n", Kind.TWIN),
        ("experiment: 1\nmisions: {}\n", Kind.EXPERIMENT),
        ("campaign: c\nmisions: []\n", Kind.CAMPAIGN),
        ("scene: s\ntitle: t\nstepps: []\n", Kind.SCENE),
        ("- {phase: a, trigger: b}\n", Kind.SCRIPT),
        ("[{phase: a, trigger: b}]\n", Kind.SCRIPT),
        ("- {phase: a, tigger: b, after: 1 s}\n", Kind.SCRIPT),
        ("{trigger: a}\n", Kind.SCRIPT),
        ("trigger: a\nafter: 1 s\n", Kind.SCRIPT),
        ("format: 1\ncourse:\n- {happens: start}\n", Kind.SCRIPT),
        ("course: [{happens: start}]\n", Kind.SCRIPT),
        ("trigger: a\njobs: []\n", Kind.OTHER),
        ("course: Latin\nteacher: x\n", Kind.OTHER),
        ("- {phase: one}\n- {phase: two}\n", Kind.OTHER),
        ("- one\n- two\n", Kind.OTHER),
        ("# mission: m\n# phases: {}\n", Kind.OTHER),
        ("jobs:\n  mission: m\n  phases: {}\n", Kind.OTHER),
        ("", Kind.OTHER),
    ],
)
def test_a_broken_file_is_known_by_what_is_left(text: str, kind: Kind) -> None:
    assert kind_of_text(text) is kind


def test_a_file_in_another_encoding_is_known(tmp_path: Path) -> None:
    file = tmp_path / "m.yaml"
    file.write_text("mission: m\nphases: {}\n", encoding="utf-16")

    assert kind_of(file) is Kind.MISSION


@given(st.text())
def test_no_text_is_too_strange(text: str) -> None:
    assert isinstance(kind_of_text(text), Kind)


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
