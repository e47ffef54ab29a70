from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.belief import Claim, judged
from benchmarks.belief_cases import TROUBLES, WAYS, case_of
from benchmarks.robots import twin_of
from pirate_sm.core import library
from pirate_sm.core._loading.robot.twin import load_twin
from pirate_sm.core.loading import load_pipe, load_robot
from pirate_sm.simulation.defects import named


@pytest.mark.thorough
def test_belief_is_tried_in_pipes_and_with_defects_that_can_be_and_repeat(tmp_path: Path) -> None:
    robots = {
        name: load_robot(library.find_robot(name)).profile
        for name in ("pirate_ii", "pirate_ii_imu")
    }
    troubles = set()
    for number in range(len(WAYS) * len(TROUBLES)):
        case = case_of(3, number, tmp_path)
        load_pipe(Path(case.order.pipe or ""))
        robot = "pirate_ii_imu" if case.order.mission == "level" else "pirate_ii"
        assert len(named(case.order.defects, robots[robot], seed=0)) == dict(TROUBLES)[case.trouble]
        assert case_of(3, number, tmp_path).order == case.order
        troubles.add((case.order.mission, case.trouble))
    assert troubles == {(way.mission, trouble) for way in WAYS for trouble, _ in TROUBLES}


@pytest.mark.parametrize(
    ("said_mm", "bound_mm", "true_mm", "allowed"),
    [
        (400, float("nan"), 419, True),
        (400, float("nan"), 421, False),
        (400, 12, 419, True),
        (400, 12, 421, False),
        (400, 30, 429, True),
        (400, 30, 371, True),
        (400, 30, 369, False),
        (float("nan"), 30, 400, False),
        (400, 30, float("nan"), False),
    ],
)
def test_a_claim_is_within_20_mm_or_its_bound(
    said_mm: float, bound_mm: float, true_mm: float, allowed: bool
) -> None:
    claim = Claim(said_mm / 1000, bound_mm / 1000, true_mm / 1000)
    assert claim.allows(claim.estimate_m) is allowed


def test_a_run_with_nothing_wrong_claims_what_is_true(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    found = judged(case_of(0, 0, Path(), ["drive_on"]))
    assert (found.verdict, found.case.trouble) == ("claimed", "nothing")
    assert found.claim.truth_m == pytest.approx(found.case.asked_m, abs=0.02)


def test_every_drawn_robot_can_be_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    profile = load_robot(library.find_robot("pirate_ii")).profile
    twins = [load_twin(twin_of(0, number), profile) for number in range(20)]
    torques = [twin.motors["bend"].stall_torque or 0.0 for twin in twins]
    assert 0.5 <= min(torques) < 0.9
    assert 1.6 < max(torques) <= 2.0
