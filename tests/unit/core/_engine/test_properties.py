"""Whatever happens in whatever order, the engine keeps its promises (see `world.py`)."""

from __future__ import annotations

from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any

import pytest
from driving import NEWT, PIRATE, ROOT
from hypothesis import given, settings
from hypothesis import strategies as st
from inventing import MISSIONS, program_of
from representative import MISSIONS as REPRESENTATIVE
from representative import thorough_but
from world import COURSES, Action, Course, replay

from pirate_sm.core._engine.mission.program import STOP, Finish, Program, Question, Wait
from pirate_sm.core._loading.mission.loader import LoadedMission, load_mission
from pirate_sm.core._loading.robot.loader import load_robot

SHIPPED = [
    *sorted((ROOT / "sequences").glob("*.yaml")),
    *sorted((ROOT / "docs" / "examples").glob("*.yaml")),
    NEWT / "patrol.yaml",
    NEWT / "take_hold.yaml",
]
FEW = [path for path in SHIPPED if path.parent == NEWT or path.stem in REPRESENTATIVE]


@cache
def loaded(path: Path) -> LoadedMission:
    return load_mission(path)


@pytest.mark.parametrize("nominal", [True, False], ids=["nominal", "measured"])
@pytest.mark.parametrize("path", thorough_but(FEW, SHIPPED), ids=lambda path: path.stem)
@settings(max_examples=settings.default.max_examples // 4)
@given(course=COURSES)
def test_a_shipped_mission_survives_any_course_of_events(
    path: Path, nominal: bool, course: list[Action]
) -> None:
    mission = loaded(path)
    run = Course(mission.robot, mission.program, nominal)

    run.run(course)

    assert replay(run) == run.effects


def targets(program: Program) -> list[int]:
    """Every index that an instruction may lead to."""
    found = [program.start]
    for at, instruction in enumerate(program.instructions):
        match instruction:
            case Wait():
                found += [trigger.go for trigger in instruction.triggers]
                found += [instruction.within] if isfinite(instruction.within_s) else []
            case Question():
                found += [target for _, target in instruction.choices]
                found += [instruction.failed]
            case Finish():
                pass
            case _:
                fields = instruction._asdict()
                names = ("next", "failed", "if_true", "if_false")
                found += [fields[name] for name in names if name in fields]
        found += [each.go for each in program.handlers[at] if each.go is not None]
    return found


@settings(max_examples=settings.default.max_examples * 3)
@given(mission=MISSIONS, nominal=st.booleans(), course=COURSES)
def test_any_mission_survives_any_course_of_events(
    mission: dict[str, Any], nominal: bool, course: list[Action]
) -> None:
    model, program = program_of(mission)
    run = Course(load_robot(PIRATE).oriented(model.polarity), program, nominal)

    run.run(course)

    assert replay(run) == run.effects
    assert all(STOP <= target < len(program.instructions) for target in targets(program))
