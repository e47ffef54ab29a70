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

from .small_missions import write

HERE = Path(package.__file__).parent
TABLES = {"robot": check_robot, "mission": check_mission, "pipe": check_in_pipe}
VIEWS = {"RobotView", "MissionView", "PipeView"}

COMPARING = """\
start: a
phases:
  a: {do: [{choose: [{if: spin_a > spin_b, do: [Rest]}]}], go: good}
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
    assert rules_in(name) == set(table)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", ["0", "1", "2"])
def test_findings_do_not_depend_on_the_order_of_sets(seed: str, tmp_path: Path) -> None:
    file = write(tmp_path, COMPARING)
    program = "from pirate_sm.cli.start import main; main()"
    command = [sys.executable, "-c", program, "check", str(file), "--format", "json"]
    environment = {**os.environ, "PYTHONHASHSEED": seed}

    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)

    assert done.returncode == 1, done.stderr
    assert "(with spin_a = 0.0 rad/s, spin_b = -0.1 rad/s)" in done.stdout
