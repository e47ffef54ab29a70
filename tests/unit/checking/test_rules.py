"""Every rule stands in the table of its package, and nothing depends on the order of a set."""

from __future__ import annotations

import inspect
import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

import pytest

import pirate_sm.checking as package
from pirate_sm.checking.mission import check_mission
from pirate_sm.checking.pipe import check_in_pipe
from pirate_sm.checking.robot import check_robot

HERE = Path(package.__file__).parent
TABLES = {"robot": check_robot, "mission": check_mission, "pipe": check_in_pipe}
VIEWS = {"RobotView", "MissionView", "PipeView"}

UNDECIDED = """\
format: 1
mission: m
robot: newt
start: a
phases:
  a:
    wait: [{when: "front_angle - rear_angle > 10 deg and front_angle > 0 rad", go: b}]
    within: {time: 9 s, go: e}
  b: {do: [DriveForward, Climb, Climb], go: e}
ends: {e: {succeed: ok}}
"""


def rules_in(name: str) -> set[str]:
    """Return the public functions of a package that take one view and yield findings."""
    found = set()
    for module in iter_modules([str(HERE / name)]):
        loaded = import_module(f"{package.__name__}.{name}.{module.name}")
        for function in vars(loaded).values():
            if not inspect.isfunction(function) or function.__name__.startswith("_"):
                continue
            signature = inspect.signature(function)
            given = [each.annotation for each in signature.parameters.values()]
            if set(given) <= VIEWS and given and signature.return_annotation == "Iterator[Finding]":
                found.add(function.__name__)
    return found


@pytest.mark.parametrize("name", TABLES)
def test_every_rule_of_a_package_is_run(name: str) -> None:
    table = [rule.__name__ for rule in TABLES[name].RULES]

    assert len(table) == len(set(table))
    assert rules_in(name) | {"in_its_pipe"} == {*table, "in_its_pipe"}
