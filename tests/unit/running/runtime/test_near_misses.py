"""What nearly happened in a run, told by what the engine is given and gives back."""

from __future__ import annotations

from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pirate_sm.core import effects as fx
from pirate_sm.core._engine.state import Ending
from pirate_sm.core.engine import Engine
from pirate_sm.core.events import SensorFrame, Tick
from pirate_sm.core.loading import load_mission
from pirate_sm.core.robot import at_rest_in
from pirate_sm.running.runtime.near_misses import NearMiss, NearMisses

MISSION = """\
format: 1
mission: m
robot: pirate_ii
time_limit: 100 s
start: a
phases:
  a:
    do: [ClampFront]
    wait: [{when: detector == close, held: 1 s, go: good}]
    within: {time: 10 s, go: bad}
ends:
  good: {succeed: ok}
  bad: {fail: bad}
"""


class Run:
    """A run whose every moment is laid down."""

    def __init__(self, file: Path) -> None:
        file.write_text(MISSION, encoding="utf-8")
        loaded = load_mission(file)
        self.program = loaded.program
        self.robot = loaded.robot
        self.calls = NearMisses(loaded.robot, loaded.program)
        body = at_rest_in(loaded.robot, loaded.program.start_configuration)
        self._run: Any = SimpleNamespace(
            state=Engine(loaded.robot, loaded.program, nominal=False).start(body=body)[0]
        )
        self.calls.follow(lambda: self._run.state)

    @property
    def state(self) -> Any:
        return self._run.state

    def goes(self, at: float, *effects: fx.Effect, event: Any = None, **changes: Any) -> None:
        self._run.state = self._run.state._replace(**changes)
        self.calls.take(event or Tick(), at, effects)

    def call(self, about: str) -> NearMiss:
        (found,) = (each for each in self.calls.nearest() if each.about == about)
        return found

    def wait(self, *since: float) -> Any:
        """The mission at its wait, with its conditions true since then."""
        at = next(n for n, it in enumerate(self.program.instructions) if hasattr(it, "triggers"))
        return self.state.mission._replace(pc=at, begun=True, since=since)


@pytest.fixture
def run(tmp_path: Path) -> Run:
    return Run(tmp_path / "m.yaml")


def test_a_command_is_held_against_its_time(run: Run) -> None:
    motion = run.state.robot.motion
    assert motion.timeout_s == 40.0
    run.goes(1.0, fx.CommandStatus("ClampFront", "accepted", "", "m.yaml:9:10"))
    run.goes(5.0, fx.CommandStatus("ClampFront", "done", "", "m.yaml:9:10"))

    call = run.call("ClampFront (m.yaml:9:10)")
    assert (call.share, call.at_s) == (pytest.approx(0.1), 5.0)
    assert call.text == "ClampFront (m.yaml:9:10) took 4.0 s of the 40 s that it has"


def test_a_command_that_fails_has_had_it(run: Run) -> None:
    run.goes(1.0, fx.CommandStatus("ClampFront", "accepted", "", "p"))
    run.goes(11.0, fx.CommandStatus("ClampFront", "failed", "not done within 10 s", "p"))

    assert run.call("ClampFront (p)").text == (
        "ClampFront (p) failed after 10.0 s: not done within 10 s"
    )
    assert run.call("ClampFront (p)").share == 1.0


def test_a_wait_is_held_against_its_limit_the_longest_time(run: Run) -> None:
    for begins, ends in ((0.0, 4.0), (5.0, 13.0), (20.0, 21.0)):
        run.goes(begins, fx.WaitArmed("a", ("good",), ("",), begins + 10))
        run.goes(ends, fx.TriggerFired("a", "good", "good", ""))

    assert run.call("the wait of a") == (
        "the wait of a",
        "the wait of a took 8.0 s of its limit of 10 s",
        pytest.approx(0.8),
        13.0,
    )


def test_a_wait_that_lasts_too_long_has_come_about(run: Run) -> None:
    run.goes(0.0, fx.WaitArmed("a", ("good",), ("",), 10.0))
    run.goes(10.0, fx.TriggerFired("a", "within", "bad", ""))

    assert run.call("the wait of a").share == 1.0


def test_a_trigger_that_falls_away_has_held_for_a_part_of_its_time(run: Run) -> None:
    run.goes(2.0, mission=run.wait(2.0))
    run.goes(2.5, mission=run.wait(2.0))
    run.goes(2.75, mission=run.wait(nan))

    call = run.call("the trigger 'detector == close for 1 s' of a")
    assert call.share == pytest.approx(0.75)
    assert call.text.endswith("held for 0.75 s and became false again")


def test_a_word_that_goes_soon_after_its_use_was_nearly_missed(run: Run) -> None:
    silent = run.state.words
    spoken = (*silent[:-3], "close", *silent[-2:])
    run.goes(1.0, words=spoken)
    run.goes(2.0, fx.TriggerFired("a", "good", "good", ""))
    run.goes(2.25, words=silent)

    call = run.call("the detector's word 'close'")
    assert call.share == pytest.approx(0.8)
    assert call.text == "the detector's word 'close' was used after 1.00 s and gone after 1.25 s"


def test_a_word_that_nothing_used_is_no_call(run: Run) -> None:
    silent = run.state.words
    run.goes(1.0, words=(*silent[:-3], "close", *silent[-2:]))
    run.goes(2.0, fx.TriggerFired("a", "within", "bad", ""))
    run.goes(2.25, words=silent)

    assert all("word" not in each.about for each in run.calls.nearest())


def test_a_rule_that_holds_for_a_part_of_its_time_is_told_with_it(run: Run) -> None:
    index = next(n for n, each in enumerate(run.robot.faults) if each.code == "robot.stuck")
    board = next(each for each in run.robot.boards.values() if index in each.faults)
    since = tuple(1.0 if n == index else nan for n in range(len(run.robot.faults)))
    run.goes(2.5, event=SensorFrame(board.id, ()), faults=run.state.faults._replace(since=since))

    call = run.call("robot.stuck")
    assert (call.share, call.at_s) == (pytest.approx(0.25), 2.5)
    assert call.text.startswith("robot.stuck held for 1.50 s of 6 s: ")


def test_a_fault_that_comes_up_has_come_about(run: Run) -> None:
    run.goes(3.0, fx.Fault("clamp.lost", "there is no wall", "regrip"))

    assert run.call("clamp.lost")[1:] == ("clamp.lost came up: there is no wall", 1.0, 3.0)


def test_a_mission_is_held_against_its_time_limit(run: Run) -> None:
    run.goes(25.0)

    assert run.call("time limit").share == pytest.approx(0.25)


def test_the_nearest_comes_first(run: Run) -> None:
    run.goes(0.0, fx.WaitArmed("a", ("good",), ("",), 10.0))
    run.goes(2.0, fx.TriggerFired("a", "good", "good", ""), fx.Fault("x.y", "", "continue"))
    shares = [each.share for each in run.calls.nearest()]

    assert shares == sorted(shares, reverse=True)
    assert shares[0] == 1.0


def test_what_leads_to_the_end_counts_and_the_safe_stop_does_not(run: Run) -> None:
    run.goes(0.0, fx.WaitArmed("a", ("good",), ("",), 10.0))
    ending = run.state.mission._replace(ending=Ending("failed", "", "bad", 12.0))
    run.goes(10.0, fx.TriggerFired("a", "within", "bad", ""), mission=ending)
    run.goes(11.0, fx.Fault("x.y", "after it", "stop"))

    assert run.call("the wait of a").share == 1.0
    assert all(each.about != "x.y" for each in run.calls.nearest())
