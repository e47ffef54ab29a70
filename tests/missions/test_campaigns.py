"""The shipped campaigns can be read, and mean what their comments say."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest
from representative import thorough_but

from benchmarks.camera_bends import joint_defects
from benchmarks.campaign import run, run_all
from pirate_sm.core import library
from pirate_sm.core.loading import load_robot
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.chunk import Sent, loaded_mission, run_seed
from pirate_sm.lab.campaign.conductor import chunk_of
from pirate_sm.lab.campaign.plan import CampaignPlan
from pirate_sm.running.wiring import Order

CAMPAIGNS = Path(__file__).parents[2] / "campaigns"
PROFILE = load_robot(library.find_robot("pirate_ii")).profile


@cache
def plan_of(name: str) -> CampaignPlan:
    return read_campaign(CAMPAIGNS / f"{name}.yaml", check=False)


@pytest.mark.thorough
@pytest.mark.parametrize("file", sorted(CAMPAIGNS.glob("*.yaml")), ids=lambda file: file.stem)
def test_a_shipped_campaign_can_be_run(file: Path) -> None:
    plan = plan_of(file.stem)

    assert plan.name == file.stem
    assert len({cell.key for cell in plan.cells}) == len(plan.cells)


def test_every_defect_is_in_the_campaign_of_defects() -> None:
    cells = plan_of("defects").cells

    assert {cell.order.defects[0] for cell in cells} == {*PROFILE.simulation.defects}


@pytest.mark.thorough
def test_every_defect_of_a_joint_is_in_the_campaign_of_joint_defects() -> None:
    cells = plan_of("joint_defects").cells

    assert {cell.order.defects[0] for cell in cells} == {*joint_defects(PROFILE)}


@pytest.mark.parametrize("name", ["mitre_bend", "mitre_bend_backward"])
def test_a_heedless_mission_differs_in_the_faults_that_it_ignores_alone(name: str) -> None:
    heedless = (CAMPAIGNS / "missions" / f"{name}_heedless.yaml").read_text("utf-8")
    ignored = re.compile(r"^  - \{fault: .*then: continue\}.*\n", re.MULTILINE)
    text = heedless.replace(f"mission: {name}_heedless", f"mission: {name}")
    text = text.replace("schema=../../", "schema=../")

    assert ignored.search(heedless)
    assert ignored.sub("", text) == ignored.sub("", library.find_mission(name).read_text("utf-8"))


def test_wheels_that_hold_less_are_those_of_the_twin() -> None:
    twin = str(CAMPAIGNS / "twins" / "soft_wheels.yaml")
    as_it_is, soft = run(Order("climb")), run(Order("climb", twin=twin))

    assert as_it_is.outcome == soft.outcome == "succeeded"
    assert soft.time_s != as_it_is.time_s


@pytest.mark.thorough
@pytest.mark.parametrize("seed", thorough_but([2], [2, 14]))
def test_a_joint_that_drops_by_little_makes_no_false_success(seed: int) -> None:
    """In these runs its angle drops from -102 to -120 deg, which others cannot push it to."""
    plan = plan_of("joint_defects")
    row = "mitre_bend_other_side"
    wanted = row, "odometry", ("gamma_2_drops",)
    (cell,) = (
        each for each in plan.cells if (each.row, each.order.detector, each.order.defects) == wanted
    )
    sent = Sent(cell.mission, plan.missions[cell.mission])

    assert run_seed(chunk_of(cell, [seed]), loaded_mission(sent), seed).verdict != "false"


@pytest.mark.thorough
def test_outcomes_of_benchmarks_are_the_same_for_any_number_of_workers() -> None:
    orders = [Order("enter_2d", seed=seed, friction_jitter=0.2) for seed in range(3)]
    # As text, for NaN (no word was said) is not equal to itself.
    assert repr(run_all(orders, workers=1)) == repr(run_all(orders, workers=2))
