"""A robot that is declared to hold nothing: what a held one and a loose one show at the start."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from pathlib import Path

import pytest

from pirate_sm.core import library
from pirate_sm.core.events import Event
from pirate_sm.core.loading import load_pipe, load_robot
from pirate_sm.running.runtime.ending import Result
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, Prepared, prepare
from pirate_sm.simulation.backend import SimulatorBackend

HOLD = """\
format: 1
mission: hold
robot: pirate_ii
starts_in: {BendingState: DoubleClamped, FrontWheelsState: Fixed, RearWheelsState: Fixed}
start: hold
phases:
  hold: {do: [{control: exp_3a}], wait: [{after: 5 s, go: done}]}
ends: {done: {succeed: Holding}}
"""

RESET = """\
format: 1
mission: straighten
robot: pirate_ii
allow_unclamp: a robot that lies on a table
starts_in: {BendingState: Unclamped}
start: reset
phases:
  reset: {do: [{command: Reset, unneeded: skip}], go: done}
ends: {done: {succeed: Straight}}
"""


class LaterStart:
    """An open simulator as a program meets it that begins later: its time starts at 0."""

    def __init__(self, prepared: Prepared, begun_s: float) -> None:
        self._backend, self._begun_s = prepared.backend, begun_s
        self.name, self.completion = prepared.backend.name, prepared.backend.completion
        self.real_time = False

    def open(self) -> Sequence[Event]:
        return self._backend.open()

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        self._backend.submit(setpoint_id, values)

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        now_s, events = self._backend.advance(until_s + self._begun_s)
        return now_s - self._begun_s, events

    def close(self) -> None:
        self._backend.close()


def begun_anew(tmp_path: Path, pipe: str) -> tuple[Result, Prepared]:
    """A robot holds by a control; then another program begins, with a mission that resets it."""
    for name, text in (("hold", HOLD), ("straighten", RESET)):
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    held = prepare(Order(str(tmp_path / "hold.yaml"), pipe=pipe))
    first = MissionRun(held.engine, held.backend, keep_open=True)
    assert first.execute().ended.outcome == "succeeded"
    then = prepare(Order(str(tmp_path / "straighten.yaml"), pipe=pipe))
    return MissionRun(then.engine, LaterStart(held, first.now_s)).execute(), held


@pytest.mark.parametrize("pipe", ["straight_113", "vertical"])
def test_a_robot_that_a_control_holds_is_not_reset(tmp_path: Path, pipe: str) -> None:
    result, held = begun_anew(tmp_path, pipe)

    assert result.ended.outcome == "fault"
    assert "BendingState is declared Unclamped, but the front part bears" in result.ended.message
    bends = held.backend.truth.bends_rad  # type: ignore[attr-defined]
    assert max(map(abs, bends)) > 1.5, "it still holds"


APEXES = {"front": (1, 2, 0, -1.0), "rear": (4, 3, 5, 1.0)}
"""Of each part: its apex, its other joint, its outer wheel, the sign of its apex when it holds.

Joints and wheels are those of the wheels counted from 0: gamma_1 sits at wheel 1.
"""


def folded(pipe: str, part: str, fold_deg: float) -> SimulatorBackend:
    """A robot that lies in the pipe with a part folded so far, and is driven no more."""
    robot = load_robot(library.find_robot("pirate_ii"))
    backend = SimulatorBackend(robot.profile, load_pipe(library.find_pipe(pipe))[0])
    apex, other, _, sign = APEXES[part]
    duties = {f"gamma_{apex}": 0.3 * sign, f"gamma_{other}": -0.3 * sign}
    joints = [slot.joint or "" for slot in robot.profile.slots]
    now_s = 0.0
    backend.submit(1, tuple(duties.get(joint, 0.0) for joint in joints))
    while sign * backend.truth.bends_rad[apex] < radians(fold_deg):
        now_s, _ = backend.advance(now_s + 0.05)
    backend.submit(2, (0.0,) * len(joints))
    until_s = now_s + 2.0
    while now_s < until_s:
        now_s, _ = backend.advance(until_s)
    return backend


@pytest.mark.parametrize("fold_deg", [74, 80])  # spans of 102 and 106 mm in a pipe of 120 mm
@pytest.mark.parametrize("part", APEXES)
@pytest.mark.parametrize("pipe", ["straight_113", "straight_113_upright", "mitre_90_tilted"])
def test_a_loose_part_that_nearly_spans_the_pipe_does_not_press_like_one_that_holds(
    pipe: str, part: str, fold_deg: float
) -> None:
    """Upright the front is pushed against the upper wall by its own worms: there it does hold."""
    apex, _, outer, sign = APEXES[part]
    slack_nm = load_robot(library.find_robot("pirate_ii")).profile.seen.parts[part].slack

    backend = folded(pipe, part, fold_deg)

    presses = sign * backend.truth.torques_nm[apex] >= slack_nm
    holds = backend.robot.values("press")[outer] > 5.0
    assert presses == holds
    assert holds == (pipe == "straight_113_upright" and part == "front")
