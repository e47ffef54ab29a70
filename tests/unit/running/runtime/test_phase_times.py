"""What earlier runs say about the times of the next one, held against what is known in closed form.

The next time is uniform or exponential and every order of the times is equally likely, so that the
chance of each band is a ratio of whole numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, exp, sqrt
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pirate_sm.core.effects import Ended, PhaseChange, WaitArmed
from pirate_sm.core.engine import EngineState
from pirate_sm.core.robot import RobotSpec
from pirate_sm.running.runtime.phase_times import (
    LEAST_RUNS,
    EarlierRuns,
    ForecastWatch,
    PhaseKey,
    PhaseVisits,
    band_of,
)

REPEATED = 2000
DRIVE = PhaseKey("drive", 1)


def forecast(*times_s: float) -> EarlierRuns:
    return EarlierRuns([[("drive", each), ("halt", 2.0)] for each in times_s], "sim")


# --- bands ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("runs", [19, 25, 39, 100, 312])
@pytest.mark.parametrize("shape", ["uniform", "exponential"])
def test_a_band_holds_the_next_time_as_often_as_the_order_of_times_says(
    runs: int, shape: str
) -> None:
    random = np.random.default_rng(runs)
    held = share = 0.0
    for _ in range(REPEATED):
        *earlier, following = getattr(random, shape)(size=runs + 1).tolist()
        band = band_of(earlier)
        assert band is not None
        held += band.low_s <= following <= band.high_s
        at = (lambda t: t) if shape == "uniform" else (lambda t: 1.0 - exp(-t))
        share += at(band.high_s) - at(band.low_s)  # the chance that it holds, given this band
    left_out = (runs + 1) // 20
    exact = (runs + 1 - 2 * left_out) / (runs + 1)

    assert exact >= 0.9
    assert share / REPEATED == pytest.approx(exact, abs=0.008)
    assert held / REPEATED == pytest.approx(exact, abs=4 * sqrt(0.09 / REPEATED))


def test_there_is_no_band_of_too_few_runs() -> None:
    assert band_of([1.0] * (LEAST_RUNS - 1)) is None
    assert band_of(map(float, range(LEAST_RUNS))) == (0.0, 18.0, LEAST_RUNS)
    assert "only 3 runs on sim, and 19 are needed" in forecast(1.0, 2.0, 3.0).notice


def test_a_band_leaves_out_as_many_times_on_each_side() -> None:
    assert band_of(map(float, range(1, 100))) == (5.0, 95.0, 99)


@pytest.mark.parametrize(
    "runs", [19, *(pytest.param(each, marks=pytest.mark.thorough) for each in (60, 99, 312))]
)
def test_a_phase_is_rarely_called_slow_by_chance(runs: int) -> None:
    random = np.random.default_rng(runs)
    slow = 0
    for _ in range(REPEATED):
        *earlier, following = random.exponential(scale=100.0, size=runs + 1).tolist()
        slow += bool(forecast(*earlier).slow_words(DRIVE, following))
    chance = max(1, (runs + 1) // 100) / (runs + 1)

    assert chance <= max(0.01, 1 / (runs + 1))
    assert slow / REPEATED == pytest.approx(chance, abs=4 * sqrt(chance / REPEATED))


def test_it_says_how_many_runs_were_faster() -> None:
    it = forecast(*range(1, 313))

    assert it.slow_words(DRIVE, 310.0) == ""
    assert it.slow_words(DRIVE, 311.0) == (
        "drive is slower than in 310 of 312 runs on sim: more than 310.0 s, usually 15.0 to 298.0 s"
    )
    assert "in all 40 runs on sim" in forecast(*range(40)).slow_words(DRIVE, 40.0)


def test_an_equal_time_is_not_slow() -> None:
    assert forecast(*[12.0] * 30).slow_words(DRIVE, 12.0) == ""


# --- what is left ---------------------------------------------------------------------------------


@pytest.mark.thorough
def test_what_is_left_is_that_of_whole_runs_so_phases_that_are_slow_together_count_together() -> (
    None
):
    """Both phases take the same exponential time: bands of each by itself would be too narrow."""
    random = np.random.default_rng(7)
    held = at_the_end = 0
    for _ in range(REPEATED):
        *earlier, own = random.exponential(scale=10.0, size=61).tolist()
        it = EarlierRuns([[("out", each), ("back", each)] for each in earlier], "sim")
        whole = it.remaining(PhaseKey("out", 1), 0.0)
        assert whole is not None
        held += whole.low_s <= 2 * own <= whole.high_s
        left = it.remaining(PhaseKey("back", 1), 0.0)
        assert left is not None
        at_the_end += left.low_s <= own <= left.high_s
    exact = (61 - 2 * 3) / 61

    for count in (held, at_the_end):
        assert count / REPEATED == pytest.approx(exact, abs=4 * sqrt(0.09 / REPEATED))


def test_what_is_left_of_a_phase_without_memory_does_not_depend_on_how_long_it_has_lasted() -> None:
    """What is left of an exponential time is distributed as the whole: mean 10 s."""
    random = np.random.default_rng(3)
    it = EarlierRuns([[("drive", each)] for each in random.exponential(10.0, 4000).tolist()], "sim")
    for spent_s in (0.0, 5.0, 15.0):
        left = it.remaining(DRIVE, spent_s)
        assert left is not None
        assert left.runs == pytest.approx(4000 * exp(-spent_s / 10.0), rel=0.1)
        assert left.low_s == pytest.approx(-10 * np.log(0.95), rel=0.25)
        assert left.high_s == pytest.approx(-10 * np.log(0.05), rel=0.15)


def test_what_is_left_is_unknown_where_too_few_runs_have_been() -> None:
    it = forecast(*range(1, 41))

    assert it.remaining(DRIVE, 0.0) == (4.0, 41.0, 40)
    assert it.remaining(DRIVE, 30.0) is None
    assert it.remaining_words(DRIVE, 30.0) == "time left unknown"
    assert it.remaining(PhaseKey("stop", 1), 0.0) is None


def test_each_entry_into_a_phase_is_compared_with_the_same_entry() -> None:
    it = EarlierRuns([[("drive", 5.0), ("halt", 1.0), ("drive", 9.0)]] * 20, "sim")

    assert it.usual(DRIVE) == (5.0, 5.0, 20)
    assert it.usual(PhaseKey("drive", 2)) == (9.0, 9.0, 20)
    assert it.remaining(PhaseKey("drive", 2), 4.0) == (5.0, 5.0, 20)
    assert it.whole == (15.0, 15.0, 20)


# --- where a run is -------------------------------------------------------------------------------


def wait(phase: str) -> WaitArmed:
    return WaitArmed(phase, ("past",), ("detector == past",), 60.0)


def test_visits_follow_phases_and_the_way_back_from_a_mission_that_was_called() -> None:
    it = PhaseVisits()
    it.see([PhaseChange("bend")], 1.0)
    it.see([PhaseChange("bend/inner.turn")], 1.0)
    it.see([wait("bend/inner.turn")], 2.0)
    it.see([wait("bend")], 5.0)
    assert it.key == PhaseKey("bend", 2)
    it.see([PhaseChange("halt")], 9.0)
    it.see([Ended("succeeded", "done")], 9.5)

    assert it.key is None
    assert it.visits == [("bend", 0.0), ("bend/inner.turn", 4.0), ("bend", 4.0), ("halt", 0.5)]


class Watched:
    """A run that a watch follows, looked at whenever it asks for it."""

    def __init__(self, it: EarlierRuns) -> None:
        self.watch = ForecastWatch(it)
        self.paused = False
        self.said: list[tuple[float, str, str]] = []

    def until(self, at_s: float, *effects: Any) -> Sequence[tuple[float, str, str]]:
        """Let time run, then give it effects; return all that was said."""
        while self.watch.due_s <= at_s:
            self._look(self.watch.due_s)
        self.watch.react(effects, at_s)
        if self.watch.due_s <= at_s:
            self._look(at_s)
        return self.said

    def _look(self, now_s: float) -> None:
        state = SimpleNamespace(mission=SimpleNamespace(paused=self.paused))
        for log in self.watch.look(cast("EngineState", state), now_s):
            self.said.append((now_s, log.level, log.message))


def test_a_watch_says_what_is_usual_and_warns_once() -> None:
    run = Watched(forecast(*[10.0 + each / 10 for each in range(40)]))
    run.until(1.0, PhaseChange("drive"))
    run.until(14.0)
    assert [each[:2] for each in run.said] == [(1.0, "info")]
    assert "drive usually takes 10.1 to 13.8 s (90 % of 40 runs on sim)" in run.said[0][2]
    assert "12.1 to 15.8 s left if it succeeds" in run.said[0][2]

    run.until(60.0)
    ((at_s, level, text),) = run.said[1:]
    assert level == "warning"
    assert 14.9 < at_s < 15.6  # the longest of them took 13.9 s
    assert "slower than in all 40 runs" in text


def test_paused_time_does_not_count() -> None:
    run = Watched(forecast(*[10.0] * 40))
    run.paused = True
    run.until(0.0, PhaseChange("drive"))
    run.until(100.0)
    assert run.said == []
    assert run.watch.left(100.0) == ""
    run.paused = False
    run.until(109.0)
    assert [each[1] for each in run.said] == ["info"]
    assert run.watch.left(ceil(run.said[0][0]) + 0.0).endswith("left if it succeeds")


def test_a_watch_begins_again_with_the_next_run() -> None:
    run = Watched(forecast(*[10.0] * 40))
    run.until(0.0, PhaseChange("drive"))
    run.until(5.0, Ended("interrupted", "by the operator"))
    run.watch.restart(cast("RobotSpec", None))
    run.until(6.0, PhaseChange("drive"))
    run.until(15.0)
    assert [each[1] for each in run.said] == ["info", "info"]
