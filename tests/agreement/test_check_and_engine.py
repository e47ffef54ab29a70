"""The check and the engine agree: over invented missions, on both robots and on invented ones.

What the check calls impossible is refused whenever it is run, a mission without errors never is,
every counterexample runs into its finding, and a search over the engine's own events finds none
that is shorter. ``NIGHTLY=1`` invents many times as many.
"""

from __future__ import annotations

import os
from collections import Counter
from random import Random

import pytest

from agreement.judging import Judge
from agreement.missions import invent
from agreement.playing import is_it, play, shows, written
from agreement.running import Measured, Run, Shown
from agreement.searching import Search, TooMuchError
from pirate_sm.checking.mission import check_mission

KINDS = ["pirate", "newt", "made"]
MANY = 60 if os.environ.get("NIGHTLY") else 1
LONGEST = 9
"""Courses of more events are not searched for shorter ones: that takes minutes."""


def invented(first, count, *, small=False):
    for seed in range(first, first + count):
        path = invent(seed, KINDS, robots=100, small=small).write()
        check = check_mission(path)
        if check.loaded is not None:
            yield seed, path, check


@pytest.mark.parametrize("world", [Run, Measured])
def test_what_is_said_of_a_mission_holds_in_every_run_of_it(world):
    clean = 0
    for seed, _, check in invented(0, 40 * MANY):
        judge = Judge(check)
        clean += judge.clean
        shown = Shown(check.loaded)
        for number in range(3 if "loop.instant" in judge.codes else 6):
            run = world(check.loaded, shown, Random(seed * 1000 + number))
            run.go_on(60)
            judge.hold(run)
    assert clean > 0, "some are without errors, else half of this says nothing"


def test_every_counterexample_runs_into_its_finding(tmp_path):
    played = Counter()
    for _, path, check in invented(1000, 12 * MANY):
        for finding in check.findings:
            if finding.course:
                effects = play(written(finding, check, path, tmp_path))
                assert shows(finding, effects), (finding.code, finding.story)
                played[finding.code] += 1
    assert len(played) > 2


def test_no_counterexample_is_longer_than_it_must_be():
    searched = 0
    for _, _, check in invented(2000, 25 * MANY, small=True):
        for finding in check.findings:
            if not finding.course or finding.code == "loop.endless":
                continue  # an endless loop is no event that could be found
            found, number = finding.course[0]
            length = len(found.path(number))
            if length > LONGEST:
                continue
            try:
                shortest = Search(check.loaded).length(
                    lambda effects, it=finding: is_it(it, effects), length
                )
            except TooMuchError:
                continue
            assert shortest == length, (finding.code, finding.story)
            searched += 1
    assert searched > 5
