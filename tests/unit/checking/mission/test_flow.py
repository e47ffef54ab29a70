"""Times, counting, resuming and faults that lead nowhere are found; what is meant is left alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from pirate_sm.checking.exploring.explore import MOST_WORK
from pirate_sm.checking.mission import time_and_order
from pirate_sm.checking.mission.check_mission import check_mission
from pirate_sm.checking.plans import refused_from
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Program
from pirate_sm.core.robot import RobotState

CLAMP = "  a: {do: [ClampFront, ClampRear], go: b}\n"
DRIVE = (
    "  b: {do: [DriveForward], wait: [{when: change(odometry) >= 100 mm, go: c}], within: LATE}\n"
)
END = "  c: {do: [Brake], go: good}\n  late: {do: [Brake], go: bad}\n"
FLOW = {"limit.beyond", "handler.again", "wait.counts_on", "resume.refused"}


def findings(folder: Path, phases: str, head: str = "", within: str = "30 s") -> list[str]:
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
    found = findings(tmp_path, CLAMP + DRIVE + END, "time_limit: 1 min\n", within)

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
        findings(tmp_path, CLAMP + DRIVE + more + END, head)
        == [f"handler.again robot.stuck, go: {go}}}]"] * again
    )


@pytest.mark.parametrize(
    ("when", "counted"), [("odometry) >= 200 mm", True), ("gamma_1) >= 10 deg", False)]
)
def test_only_what_was_counted_counts_on(tmp_path: Path, when: str, counted: bool) -> None:
    on = f"  on: {{wait: [{{when: change({when}, go: c}}], counts_on: true, within: LATE}}\n"
    found = findings(tmp_path, CLAMP + DRIVE.replace("go: c", "go: on") + on + END)

    assert [each.partition(" ")[0] for each in found] == ["wait.counts_on"] * (not counted)


def test_a_wait_counts_on_what_any_wait_before_it_has_counted(tmp_path: Path) -> None:
    on = "  on: {wait: [{when: change(gamma_1) >= 10 deg, go: c}], counts_on: true, within: LATE}\n"
    turn = "  b: {wait: [{when: change(gamma_1) >= 5 deg, go: d}], within: LATE}\n"
    between = DRIVE.replace("  b: ", "  d: ").replace("go: c", "go: on")

    assert findings(tmp_path, CLAMP + turn + between + on + END) == []


@pytest.mark.thorough
def test_a_way_of_many_waits_is_followed_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = Counter[int]()

    followed = Program.successors

    def counting(program: Program, at: int) -> Iterator[int]:
        asked[at] += 1
        return followed(program, at)

    monkeypatch.setattr(Program, "successors", counting)
    waits = "".join(
        f"  w{n}: {{wait: [{{when: change(odometry) >= {n + 1} mm, go: w{n + 1}}}],"
        f" counts_on: {str(n > 0).lower()}, within: LATE}}\n"
        for n in range(30)
    )
    findings(tmp_path, CLAMP.replace("go: b", "go: w0") + waits + "  w30: {go: c}\n" + END)

    assert 1 <= max(asked.values()) <= 3


def test_resuming_is_explored_once_for_each_phase_and_state(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    explored = list[tuple[str, float]]()

    def counting(
        loaded: LoadedMission, phase: str, body: RobotState, most_work: float
    ) -> tuple[str, float]:
        why, work = refused_from(loaded, phase, body, most_work)
        explored.append((phase, most_work))
        return why, work

    monkeypatch.setattr(time_and_order, "refused_from", counting)
    let_go = "  b: {do: [RelaxFront], go: w0}\n"
    waits = "".join(
        f"  w{n}: {{wait: [{{after: 3 s, go: {f'w{n + 1}' if n < 4 else 'good'}}}], resume: a}}\n"
        for n in range(5)
    )

    found = findings(tmp_path, CLAMP + let_go + waits)

    assert found == ["resume.refused a}"] * 5
    limits = [limit for _, limit in explored]
    assert len(limits) <= 2  # the mission is judged again where faults are corrected
    assert max(limits) == MOST_WORK


def test_resuming_is_explored_within_one_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(time_and_order, "MOST_WORK", 0)
    waits = "  b: {do: [RelaxFront], go: w}\n  w: {wait: [{after: 3 s, go: good}], resume: a}\n"

    assert findings(tmp_path, CLAMP + waits) == []


@pytest.mark.parametrize(
    ("resume", "fits"), [("a", False), ("rest", True), ("here", True), ("never", True)]
)
def test_a_phase_resumes_where_its_commands_can_be_given(
    tmp_path: Path, resume: str, fits: bool
) -> None:
    let_go = "  b: {do: [RelaxFront], go: w}\n"
    waits = f"  w: {{wait: [{{after: 3 s, go: rest}}], resume: {resume}}}\n"
    rest = "  rest: {do: [{command: ClampFront, unneeded: skip}], go: good}\n"

    found = findings(tmp_path, CLAMP + let_go + waits + rest)
    assert found == [f"resume.refused {resume}}}"] * (not fits)
