"""Times, counting, resuming and faults that lead nowhere are told; what is meant is left alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.checking.mission.check_mission import check_mission

CLAMP = "  a: {do: [ClampFront, ClampRear], go: b}\n"
DRIVE = (
    "  b: {do: [DriveForward], wait: [{when: change(odometry) >= 100 mm, go: c}], within: LATE}\n"
)
END = "  c: {do: [Brake], go: good}\n  late: {do: [Brake], go: bad}\n"
FLOW = {"limit.beyond", "handler.again", "wait.counts_on", "resume.refused"}


def told(folder: Path, phases: str, head: str = "", within: str = "30 s") -> list[str]:
    """The codes about the flow of a mission, each with the text at its place."""
    text = (
        f"format: 1\nmission: m\nrobot: pirate_ii\npipe: straight_113\n{head}start: a\nphases:\n"
        f"{phases}ends: {{good: {{succeed: Good}}, bad: {{fail: Bad}}}}\n"
    )
    file = folder / "m.yaml"
    file.write_text(text.replace("LATE", f"{{time: {within}, go: late}}"), encoding="utf-8")
    lines = file.read_text(encoding="utf-8").splitlines()
    return [
        f"{each.code} {lines[each.place.line - 1][each.place.column - 1 :]}"
        for each in check_mission(file).findings
        if each.code in FLOW
    ]


@pytest.mark.parametrize(("within", "late"), [("1 min", False), ("61 s", True)])
def test_a_wait_is_over_before_the_mission_is(tmp_path: Path, within: str, late: bool) -> None:
    found = told(tmp_path, CLAMP + DRIVE + END, "time_limit: 1 min\n", within)

    assert found == ["limit.beyond 61 s, go: late}}"] * late


@pytest.mark.parametrize(
    ("go", "more", "again"),
    [
        ("b", "", True),
        ("again", "  again: {do: [DriveForward], wait: [{after: 3 s, go: c}]}\n", True),
        ("again", "  again: {do: [Brake, {wait: [{after: 5 s}]}, DriveForward], go: b}\n", False),
        ("again", "  again: {do: [Brake, {control: gentle}, DriveForward], go: c}\n", False),
        ("late", "", False),
    ],
)
def test_a_fault_comes_again_where_only_the_drive_begins_again(
    tmp_path: Path, go: str, more: str, again: bool
) -> None:
    head = f"on_fault: [{{fault: robot.stuck, go: {go}}}]\n"

    assert (
        told(tmp_path, CLAMP + DRIVE + more + END, head)
        == [f"handler.again robot.stuck, go: {go}}}]"] * again
    )


@pytest.mark.parametrize(
    ("when", "counted"), [("odometry) >= 200 mm", True), ("gamma_1) >= 10 deg", False)]
)
def test_only_what_was_counted_counts_on(tmp_path: Path, when: str, counted: bool) -> None:
    on = f"  on: {{wait: [{{when: change({when}, go: c}}], counts_on: true, within: LATE}}\n"
    found = told(tmp_path, CLAMP + DRIVE.replace("go: c", "go: on") + on + END)

    assert [each.partition(" ")[0] for each in found] == ["wait.counts_on"] * (not counted)


@pytest.mark.parametrize(
    ("resume", "fits"), [("a", False), ("rest", True), ("here", True), ("never", True)]
)
def test_a_phase_resumes_where_its_commands_can_be_given(
    tmp_path: Path, resume: str, fits: bool
) -> None:
    let_go = "  b: {do: [RelaxFront], go: w}\n"
    waits = f"  w: {{wait: [{{after: 3 s, go: rest}}], resume: {resume}}}\n"
    rest = "  rest: {do: [{command: ClampFront, unneeded: skip}], go: good}\n"

    found = told(tmp_path, CLAMP + let_go + waits + rest)
    assert found == [f"resume.refused {resume}}}"] * (not fits)
