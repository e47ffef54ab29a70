"""What the check says of missions that nobody wrote is what happens when they are run.

Some missions by default; NIGHTLY=1 tries thousands, other ones with NIGHTLY=2 and so on.
"""

from __future__ import annotations

import os
from functools import partial
from itertools import islice
from pathlib import Path
from random import Random

import pytest

from agreement.judging import Judge
from agreement.missions import invent
from agreement.playing import is_it, play, shows, written
from agreement.running import Measured, Run, Shown
from agreement.searching import Search, TooMuchError
from pirate_sm.checking.mission.check_mission import check_mission

NIGHT = int(os.environ.get("NIGHTLY", "0"))
KINDS = ("pirate", "newt", "made", "made")

pytestmark = pytest.mark.timeout(3_600 if NIGHT else 120)


def seeds(few: int, many: int) -> range:
    """Numbers of missions, in tens: one test for each ten."""
    return range(NIGHT * 1_000_000, NIGHT * 1_000_000 + (many if NIGHT else few), 10)


@pytest.mark.thorough
@pytest.mark.parametrize("first", seeds(few=20, many=4_000))
@pytest.mark.parametrize("world", [Run, Measured], ids=["nominal", "measured"])
def test_a_run_does_nothing_that_the_check_has_not_told(first: int, world: type[Run]) -> None:
    for seed in range(first, first + 10):
        check = check_mission(invent(seed, KINDS).write())
        assert check.loaded is not None, check.findings
        judge, shown = Judge(check), Shown(check.loaded)
        for number in range(25 if NIGHT else 8):
            run = world(check.loaded, shown, Random(seed * 1_000 + number))
            run.go_on(60)
            judge.hold(run)


@pytest.mark.parametrize("first", seeds(few=10, many=2_000))
def test_every_counterexample_runs_into_its_violation(first: int, tmp_path: Path) -> None:
    for seed in range(first, first + 10):
        path = invent(seed, KINDS).write()
        check = check_mission(path)
        for finding in (each for each in check.findings if each.course):
            effects = play(written(finding, check, path, tmp_path))
            assert shows(finding, effects), f"{seed}: {finding.place}: {finding.message}"


@pytest.mark.thorough
@pytest.mark.parametrize("first", seeds(few=40, many=4_000))
def test_there_is_no_shorter_counterexample(first: int) -> None:
    for seed in range(first, first + 10):
        check = check_mission(invent(seed, KINDS, small=True).write())
        assert check.loaded is not None
        found = (each for each in check.findings if each.course and each.code != "loop.endless")
        for finding in islice(found, None if NIGHT else 3):
            exploration, step = finding.course[0]
            length = len(exploration.path(step))
            if length > (11 if NIGHT else 7):
                continue
            try:
                shortest = Search(check.loaded).length(partial(is_it, finding), length)
            except TooMuchError:
                continue
            assert shortest == length, f"{seed}: {finding.place}: {finding.message}"


@pytest.mark.thorough
def test_the_missions_are_of_all_kinds() -> None:
    """Else the tests above would say little."""
    judges = []
    for seed in range(40):
        check = check_mission(invent(seed, ("newt", "made")).write())
        judges.append(Judge(check))

    assert any(judge.clean for judge in judges)
    assert len(set().union(*(judge.codes for judge in judges))) > 10
