"""Plans: the fewest commands between two configurations, and none that lets go of the pipe."""

from __future__ import annotations

from dataclasses import replace
from itertools import takewhile
from pathlib import Path

import pytest

from pirate_sm.core._engine.mission.planning import opened, plans
from pirate_sm.core._engine.robot.command_outcome import refusal
from pirate_sm.core._engine.robot.robot_state import Mark, at_rest_in, states_of
from pirate_sm.core._loading.robot.loader import load_robot
from pirate_sm.core.generated_missions import by_hand

ROOT = Path(__file__).resolve().parents[5]
ROBOTS = {
    "pirate_ii": ROOT / "hardware_profiles" / "pirate_ii",
    "newt": ROOT / "tests" / "robots" / "newt",
}


@pytest.fixture(scope="module", params=sorted(ROBOTS))
def loaded(request):
    return load_robot(ROBOTS[request.param])


@pytest.fixture(scope="module")
def pirate():
    return load_robot(ROBOTS["pirate_ii"])


@pytest.fixture(scope="module")
def newt():
    return load_robot(ROBOTS["newt"])


def every_rule(loaded):
    return replace(by_hand(loaded).program, rules=loaded.rules)


def in_states(loaded, **states):
    """The robot at rest where these states hold, all others being those it begins in."""
    table = loaded.table
    names = dict(zip(table.regions, table.configurations[table.initial], strict=True)) | states
    return at_rest_in(loaded.normal, table.index_of(tuple(names.values())))


def best(loaded, body, **wanted):
    table = loaded.table
    for plan in plans(loaded.normal, every_rule(loaded), body):
        names = dict(zip(table.regions, states_of(loaded.normal, plan.body), strict=True))
        if all(names[region] == state for region, state in wanted.items()):
            return plan
    return None


def commands(loaded, plan):
    return [loaded.normal.commands[step.command].name for step in plan.steps]


def test_the_first_plan_is_to_stay(loaded):
    body = at_rest_in(loaded.normal, loaded.table.initial)
    first = next(plans(loaded.normal, every_rule(loaded), body))

    assert (first.body, first.steps, first.hindered) == (body, (), None)


def test_what_is_ruled_out_while_both_parts_hold_is_done_before(pirate):
    body = in_states(pirate)
    plan = best(pirate, body, BendingState="DoubleClamped", RotationState="AlignedRight")

    assert len(plan.steps) == 3
    assert "AlignRight" in commands(pirate, plan)[:2]
    assert plan.hindered is None


def test_turning_from_a_double_clamp_opens_one_part_and_clamps_it_again(pirate):
    body = in_states(
        pirate,
        BendingState="DoubleClamped",
        FrontWheelsState="DrivingForward",
        RearWheelsState="DrivingForward",
    )
    plan = best(pirate, body, BendingState="DoubleClamped", RotationState="AlignedRight")

    given = commands(pirate, plan)
    assert [given[0], given[2]] == ["Brake", "AlignRight"]
    assert given[1].replace("Relax", "Clamp") == given[3]
    assert len(given) == 4


def test_of_two_ways_of_one_length_the_quicker_is_taken(pirate):
    spec = pirate.normal
    slow = spec.table.command_index["ClampFront"]
    changed = replace(
        spec,
        commands=tuple(
            replace(each, nominal_s=100.0) if index == slow else each
            for index, each in enumerate(spec.commands)
        ),
    )
    program, begin = every_rule(pirate), in_states(pirate)
    holding = next(
        plan for plan in plans(changed, program, begin) if spec.held[plan.body.configuration]
    )

    assert commands(pirate, holding) == ["ClampRear"]
    assert (
        holding.nominal_s(changed) == spec.commands[spec.table.command_index["ClampRear"]].nominal_s
    )


def test_letting_go_comes_last_and_says_so(pirate):
    body = in_states(pirate, BendingState="RearClampedFrontRelaxed", RearWheelsState="Fixed")
    plan = best(pirate, body, BendingState="Unclamped")

    assert commands(pirate, plan) == ["Reset"]
    assert plan.hindered is plan.steps[0]
    assert plan.hindered.hindrance == ("it lets go of rear, and no other part is confirmed to hold")


def test_a_clamp_that_nobody_has_confirmed_holds_nothing(pirate):
    spec = pirate.normal
    front = spec.parts.index("front")
    body = in_states(
        pirate, BendingState="DoubleClamped", FrontWheelsState="Fixed", RearWheelsState="Fixed"
    )
    declared = body._replace(marks=frozenset({Mark("part", front, -2)}))

    sure = best(pirate, body, BendingState="FrontClampedRearRelaxed")
    doubted = best(pirate, declared, BendingState="FrontClampedRearRelaxed")
    assert commands(pirate, sure) == ["RelaxRear"]
    assert commands(pirate, doubted) == ["ClampFront", "RelaxRear"]
    assert doubted.hindered is None


def test_a_state_that_a_pause_has_doubted_is_restored_by_its_own_command(pirate):
    spec = pirate.normal
    body = in_states(
        pirate,
        BendingState="DoubleClamped",
        FrontWheelsState="DrivingForward",
        RearWheelsState="DrivingForward",
    )
    doubted = body._replace(marks=frozenset({Mark("region", 0, -1), Mark("region", 1, -1)}))
    restored = next(
        plan
        for plan in plans(spec, every_rule(pirate), doubted)
        if plan.body.configuration == body.configuration and not plan.body.marks
    )

    assert commands(pirate, restored) == ["DriveForward"]


def test_another_robot_is_planned_for_likewise(newt):
    plan = best(newt, in_states(newt), Grip="BothHeld", Crawl="Ahead", Lamp="Lit")

    assert len(plan.steps) == 4
    assert plan.hindered is None
    assert best(newt, in_states(newt, Grip="BothHeld"), Grip="Loose").hindered is not None


def test_each_plan_can_be_followed_and_none_without_hindrance_lets_go(loaded):
    spec, begin = loaded.normal, at_rest_in(loaded.normal, loaded.table.initial)
    seen = 0
    for plan in takewhile(lambda each: not each.hindered, plans(spec, every_rule(loaded), begin)):
        here = begin
        for step in plan.steps:
            assert refusal(spec, here, step.command) == ""
            assert (step.body.motion, step.body.flight) == (None, None), "it is done"
            assert not opened(spec, here, step.body.configuration)
            assert spec.held[step.body.configuration] or not spec.held[here.configuration]
            here = step.body
        assert here == plan.body
        seen += 1

    assert seen > 10


def test_no_shorter_way_is_overlooked(loaded):
    """Measured against a walk over the bare table, as far as no command lets go."""
    spec, table = loaded.normal, loaded.table
    length = {table.initial: 0}
    order = [table.initial]
    for here in order:
        body = at_rest_in(spec, here)
        for command in range(len(table.commands)):
            there = table.follow(here, command)
            holds = not spec.held[here] or spec.held[here] & spec.held[there]
            if holds and not refusal(spec, body, command) and there not in length:
                length[there] = length[here] + 1
                order.append(there)
    begin = at_rest_in(spec, table.initial)
    found = {}
    for plan in takewhile(lambda each: not each.hindered, plans(spec, every_rule(loaded), begin)):
        found.setdefault(plan.body.configuration, len(plan.steps))

    assert found == length


def test_a_rule_of_the_robot_is_kept(pirate):
    program = every_rule(pirate)
    names = {rule.name for rule in program.rules}
    assert {"never_let_go", "drive_with_a_clamp"} <= names
    held = next(rule for rule in program.rules if rule.name == "never_let_go")
    always = replace(program, rules=(held._replace(name="hold_always", after=None),))
    begin = at_rest_in(pirate.normal, pirate.table.initial)
    lit = next(
        plan
        for plan in plans(pirate.normal, always, begin)
        if states_of(pirate.normal, plan.body)[4] == "On"
    )

    assert commands(pirate, lit)[0].startswith("Clamp")  # not the light before anything holds
    assert lit.hindered is None
