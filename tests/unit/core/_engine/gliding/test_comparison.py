"""What frames must leave as it is while states are compared is what the comparison itself says."""

from __future__ import annotations

from math import nan
from pathlib import Path
from random import Random

import pytest
from agreement.robots import NEWT
from representative import thorough_but

from pirate_sm.core import library
from pirate_sm.core._engine.gliding.comparison import codes_of
from pirate_sm.core._engine.robot.criteria import HeldSpec
from pirate_sm.core._engine.robot.declared_states import declared_in
from pirate_sm.core._engine.robot.evidence import spec_of, verdict
from pirate_sm.core._engine.robot.robot_state import at_rest_in, states_of
from pirate_sm.core._expressions import machine
from pirate_sm.core.loading import load_robot

ROBOTS = [library.find_robot("pirate_ii"), NEWT]


@pytest.mark.parametrize("folder", ROBOTS, ids=lambda folder: folder.name)
@pytest.mark.parametrize("diameter_m", thorough_but([None], [None, 0.12]))
def test_codes_say_what_the_verdict_says(folder: Path, diameter_m: float | None) -> None:
    robot = load_robot(folder).oriented("normal")
    lot, said = Random(1), [0, 0, 0]
    for _ in range(3000):
        configuration = lot.randrange(len(robot.table.configurations))
        body = declared_in(robot, configuration)
        setpoints = at_rest_in(robot, configuration).values
        scale = lot.choice([0.0, 0.01, 0.1, 1.0])
        numbers = [
            nan if lot.random() < 0.05 else lot.uniform(-1.0, 1.0) * scale
            for _ in robot.vocabulary.numbers
        ]
        for part in filter(None, robot.sight.parts):
            numbers[part.diameter] = lot.choice((0.118, 0.12, 0.15, nan))
            for joint in part.joints if lot.random() < 0.5 else ():
                numbers[joint.rate] = lot.choice((0.0, 0.0, 1.0))
                limit_nm = lot.choice((joint.least_nm, joint.needed_nm, part.slack))
                numbers[joint.torque] = lot.choice((-1.0, 1.0)) * limit_nm
        for mark in body.marks:
            shown = verdict(robot, setpoints, body, mark, tuple(numbers), diameter_m)
            codes = codes_of(robot, configuration, mark, setpoints, diameter_m)
            agrees, firmly, against = (
                machine.value_of(code, 0, len(code), numbers, (), [0.0] * machine.DEEPEST) == 1.0
                for code in codes
            )
            spec = spec_of(robot, states_of(robot, body), mark)
            if against:
                said[0] += 1
                continue  # every frame goes through the engine
            assert not shown.against
            assert agrees == shown.agrees
            if agrees and isinstance(spec, HeldSpec):
                assert firmly == (shown.for_s == spec.for_s)
                said[2] += 1
            said[1] += agrees
    assert min(said) > 10
