"""A mission is explored once for all its pipes: no diameter and no torque of a clamp counts."""

from __future__ import annotations

from collections import deque
from pathlib import Path

import pytest

from pirate_sm.checking.exploring import explore as exploring
from pirate_sm.checking.exploring.explore import conditions_of, explore, explore_mission
from pirate_sm.core import library
from pirate_sm.core.loading import LoadedMission, load_mission

NARROW, WIDE = "mitre_90_105mm", "mitre_90_115mm"
CHEAP = ("climb", "mitre_bend")


def in_pipe(mission: str, pipe: str) -> LoadedMission:
    place = str(library.find_pipe(pipe, Path.cwd()))
    return load_mission(library.find_mission(mission), pipe=place)


@pytest.mark.parametrize(
    "mission",
    [
        each.stem if each.stem in CHEAP else pytest.param(each.stem, marks=pytest.mark.thorough)
        for each in library.missions()
        if "\nroute:" not in each.read_text("utf-8")  # the others are for a pipe that has it
    ],
)
def test_what_is_shared_is_what_each_mission_would_find_with_its_own_pipe(mission: str) -> None:
    narrow, wide = in_pipe(mission, NARROW), in_pipe(mission, WIDE)
    assert narrow.program != wide.program

    shared, _ = explore_mission(narrow)

    for loaded in (narrow, wide):
        assert explore_mission(loaded)[0] is shared
        own = explore(loaded.robot, loaded.program, conditions_of(loaded))
        found = shared[0].found
        assert (own.complete, own.work, own.branches) == (
            found.complete, found.work, found.branches
        )  # fmt: skip
        assert repr(own.steps) == repr(found.steps)
        assert list(map(exploring.key_of, (each.state for each in own.nodes))) == list(
            map(exploring.key_of, (each.state for each in found.nodes))
        )


def test_other_programs_and_robots_are_explored_for_themselves() -> None:
    path = library.find_mission("mitre_bend")
    usual, mirrored = (
        load_mission(path),
        load_mission(library.find_mission("mitre_bend_other_side")),
    )
    other_start = load_mission(path, start_phase=list(usual.mission.phases)[1])

    found = [explore_mission(each)[0] for each in (usual, mirrored, other_start)]

    assert len(set(map(id, found))) == 3


def test_the_oldest_are_forgotten_and_the_last_never_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exploring, "MOST_SHARED", 0)
    monkeypatch.setattr(exploring, "_SHARED", deque())
    old, last = in_pipe("climb", NARROW), load_mission(library.find_mission("mitre_bend"))
    first, second = explore_mission(old)[0], explore_mission(last)[0]

    assert explore_mission(last)[0] is second
    assert explore_mission(old)[0] is not first
    assert len(exploring._SHARED) == 1


def test_answers_that_a_copy_finds_are_its_own() -> None:
    loaded = in_pipe("climb", NARROW)
    _, conditions = explore_mission(loaded)
    before = conditions.tests
    copied = conditions.copied()
    trigger = next(
        trigger.condition
        for each in loaded.program.instructions
        for trigger in getattr(each, "triggers", ())
        if trigger.condition is not None
    )

    states = loaded.robot.table.configurations[0]
    assert copied.ask([(trigger.tree, True)], states) == conditions.within({}).ask(
        [(trigger.tree, True)], states
    )
    assert copied.tests > before == conditions.tests
