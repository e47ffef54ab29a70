"""Who decides in a trace: a script, else the first trigger of each wait; and when it ends."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest

from pirate_sm.core.companion import Companion
from pirate_sm.core.effects import Effect, Ended, TriggerFired
from pirate_sm.core.errors import ExitCode
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import Firing, FirstChoice, TriggerScript
from pirate_sm.running.wiring import Order, prepare

ENDS = "\nends: {passed: {succeed: Passed}, late: {fail: Late}}\n"
HEAD = "format: 1\nmission: m\nrobot: pirate_ii\npipe: straight_113\n"


class Played(NamedTuple):
    fired: list[tuple[float, str]]
    ended: Ended
    exit_code: int
    companions: tuple[Companion, ...]

    @property
    def script(self) -> TriggerScript:
        return next(each for each in self.companions if isinstance(each, TriggerScript))

    @property
    def unused(self) -> list[Firing]:
        return self.script.unused


class Fired:
    def __init__(self) -> None:
        self.found: list[tuple[float, str]] = []

    def see(self, effects: tuple[Effect, ...], now_s: float) -> None:
        self.found += [(now_s, each.trigger) for each in effects if isinstance(each, TriggerFired)]


def play(tmp_path: Path, body: str, *firings: Firing) -> Played:
    path = tmp_path / "m.yaml"
    path.write_text(HEAD + body + ENDS)
    prepared = prepare(Order(str(path), backend="trace", firings=firings), say=print)
    fired = Fired()
    companions = (*prepared.companions, FirstChoice("nobody"))
    run = MissionRun(prepared.engine, prepared.backend, observers=[fired], companions=companions)
    result = run.execute()
    return Played(fired.found, result.ended, result.exit_code, companions)


ONE_WAIT = """
start: p
phases:
  p:
    wait:
      - {when: detector == close, name: first, go: passed}
      - {operator: b, name: second, go: late}%s
    within: {time: %s, go: late}
"""


def test_the_first_trigger_fires_after_a_second(tmp_path: Path) -> None:
    assert play(tmp_path, ONE_WAIT % ("", "60 s")).fired == [(1.0, "first")]


def test_the_first_trigger_is_in_time_for_a_short_wait(tmp_path: Path) -> None:
    assert play(tmp_path, ONE_WAIT % ("", "500 ms")).fired == [(0.25, "first")]


@pytest.mark.parametrize("after", ["1 s", "200 ms"])
def test_a_trigger_of_time_does_not_fire_in_place_of_the_first(tmp_path: Path, after: str) -> None:
    played = play(tmp_path, ONE_WAIT % (f"\n      - {{after: {after}, go: late}}", "60 s"))

    assert [name for _, name in played.fired] == ["first"]
    assert played.ended.outcome == "succeeded"


@pytest.mark.parametrize("script", [(), (Firing("rest"),)])
def test_a_trigger_of_time_fires_at_its_time(tmp_path: Path, script: tuple[Firing, ...]) -> None:
    body = """
start: p
phases:
  p: {wait: [{after: 3 s, name: rest, go: passed}], within: {time: 5 s, go: late}}
"""
    assert play(tmp_path, body, *script).fired == [(3.0, "rest")]


def test_a_trigger_of_time_does_not_fire_in_place_of_one_that_the_script_names(
    tmp_path: Path,
) -> None:
    body = """
start: p
phases:
  p:
    wait: [{after: 1 s, name: time, go: late}, {when: detector == close, name: word, go: passed}]
    within: {time: 5 s, go: late}
"""
    assert [name for _, name in play(tmp_path, body).fired] == ["time"]
    assert [name for _, name in play(tmp_path, body, Firing("word")).fired] == ["word"]


TWO_WAITS = """
start: p
phases:
  p:
    wait: [{when: detector == close, name: first, go: q}, {operator: b, name: second, go: q}]
    within: {time: 60 s, go: q}
  q:
    wait: [{operator: a, name: first, go: passed}, {operator: b, name: second, go: late}]
    within: {time: 60 s, go: late}
"""


def test_a_script_fires_what_it_lists_where_it_fits(tmp_path: Path) -> None:
    played = play(tmp_path, TWO_WAITS, Firing("second", 3.0, phase="q"), Firing("second", 0.5))

    assert played.fired == [(0.5, "second"), (3.5, "second")]
    assert played.unused == []


def test_a_script_lets_the_time_limit_pass(tmp_path: Path) -> None:
    assert play(tmp_path, TWO_WAITS, Firing("within")).fired == [(60.0, "within"), (61.0, "first")]


def test_an_entry_that_fits_no_wait_stays_unused(tmp_path: Path) -> None:
    thrice = [Firing("second")] * 3
    assert play(tmp_path, TWO_WAITS, *thrice).unused == [Firing("second")]


@pytest.mark.parametrize(
    ("firing", "forestalled"),
    [
        (Firing("second", 100.0), True),  # `within` ends the wait after 60 s
        (Firing("second", 1.0), False),
        (Firing("within"), False),
    ],
)
def test_an_entry_whose_wait_ended_before_is_told_from_one_that_fired(
    tmp_path: Path, firing: Firing, forestalled: bool
) -> None:
    played = play(tmp_path, TWO_WAITS, firing)

    assert played.unused == []
    assert played.script.forestalled == ([firing] if forestalled else [])


def test_an_entry_that_lets_time_pass_is_forestalled_by_what_time_makes_true(
    tmp_path: Path,
) -> None:
    late = "\n      - {after: 1 s, go: late}"
    played = play(tmp_path, ONE_WAIT % (late, "60 s"), Firing("within"))

    assert [at_s for at_s, _ in played.fired] == [1.0]
    assert played.script.forestalled == [Firing("within")]


POLLING = """
start: look
phases:
  look:
    do: [ToggleLighting, ToggleLighting]
    wait: [{after: 1 s, name: again, go: look}, {when: detector == close, name: word, go: passed}]
    within: {time: 5 s, go: late}
"""


def test_a_polling_loop_ends_where_it_comes_back_to_the_same_situation(tmp_path: Path) -> None:
    played = play(tmp_path, POLLING)

    assert played.ended.outcome == "interrupted"
    assert "situation in which it has been before" in played.ended.message
    assert played.exit_code == ExitCode.FAILED
    assert [name for _, name in played.fired] == ["again"]


def test_a_polling_loop_goes_on_while_the_script_has_something_new(tmp_path: Path) -> None:
    again = [Firing("again")] * 3
    played = play(tmp_path, POLLING, *again, Firing("word"))

    assert [name for _, name in played.fired] == ["again", "again", "again", "word"]
    assert played.ended.outcome == "succeeded"


def test_a_question_that_leads_back_to_itself_ends(tmp_path: Path) -> None:
    body = """
start: p
phases:
  p: {do: [{ask: Go on?, choices: {again: p, stop: continue}, timeout: 10 s}], go: late}
"""
    played = play(tmp_path, body)

    assert played.exit_code == ExitCode.FAILED
    assert "situation in which it has been before" in played.ended.message
