"""The chart of a robot as other programs run it: what a command costs.

    python -m benchmarks.charts [--repeats 5]

The same random commands through python-statemachine, through sismic where it is installed, and
through the compiled table; each answers whether the command moves the chart, and the table why not.
"""

from __future__ import annotations

import argparse
import random
import sys
from collections.abc import Callable, Mapping
from time import process_time
from typing import Any

from pirate_sm.core import library
from pirate_sm.core.loading import LoadedRobot, load_robot

COMMANDS = 20_000
SEED = 7
REPEATS = 5

Contender = Callable[[LoadedRobot, list[str]], int]
"""Gives commands to a robot's chart and counts those that move it."""


def main() -> int:
    """Print how many commands each takes in a second."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=REPEATS)
    repeats = parser.parse_args().repeats
    loaded = load_robot(library.find_robot("pirate_ii"))
    contenders: dict[str, Contender] = {"python-statemachine": in_library, "sismic": in_sismic}
    try:
        import sismic  # noqa: F401
    except ModuleNotFoundError:
        del contenders["sismic"]
        print("sismic is not installed (make bench installs it)")
    few = _commands(loaded, COMMANDS // 10)
    moved = {each(loaded, few) for each in (*contenders.values(), in_table)}
    assert len(moved) == 1, f"the contenders disagree: {moved}"
    rates = {name: rate(each, loaded, repeats) for name, each in contenders.items()}
    rates["compiled table"] = rate(in_table, loaded, repeats, COMMANDS)
    for name, found in rates.items():
        times = found / rates["python-statemachine"]
        print(f"{name:22} {found:12,.0f} commands/s   {times:8.1f} ×")
    return 0


def rate(
    contender: Contender, loaded: LoadedRobot, repeats: int, count: int = COMMANDS // 10
) -> float:
    """Return how many commands it takes in a second of the processor, at best."""
    names, times = _commands(loaded, count), []
    for _ in range(repeats):
        began_s = process_time()
        contender(loaded, names)
        times.append(process_time() - began_s)
    return count / min(times)


def _commands(loaded: LoadedRobot, count: int) -> list[str]:
    return random.Random(SEED).choices(loaded.table.commands, k=count)


def in_table(loaded: LoadedRobot, names: list[str]) -> int:
    """By the compiled table."""
    table = loaded.table
    here, moved, index = table.initial, 0, table.command_index
    for name in names:
        command = index[name]
        there = table.follow(here, command)
        if there == here:
            table.why_not(here, command)
        else:
            moved += 1
            here = there
    return moved


def in_library(loaded: LoadedRobot, names: list[str]) -> int:
    """By python-statemachine."""
    from statemachine.io import load

    machine = load(loaded.documents[1].text, format="yaml")()
    moved = 0
    before = frozenset(machine.configuration_values)
    for name in names:
        machine.send(name)
        after = frozenset(machine.configuration_values)
        moved += after != before
        before = after
    return moved


def in_sismic(loaded: LoadedRobot, names: list[str]) -> int:
    """By sismic."""
    from sismic.interpreter import Interpreter
    from sismic.io.datadict import import_from_dict

    interpreter = Interpreter(import_from_dict(_as_sismic(loaded.documents[1].data)))
    interpreter.execute()
    moved = 0
    for name in names:
        interpreter.queue(name)
        steps = interpreter.execute()
        moved += any(step.exited_states for step in steps)
    return moved


def _as_sismic(chart: Mapping[str, Any]) -> dict[str, Any]:
    """The same chart in sismic's own format."""
    ((top, body),) = chart["states"].items()
    regions = []
    for region, inside in body["states"].items():
        states = []
        for state, content in inside["states"].items():
            transitions = [
                {
                    "event": each["event"],
                    "target": each["target"],
                    **({"guard": each["cond"].replace("In(", "active(")} if "cond" in each else {}),
                }
                for each in content.get("transitions", ())
            ]
            states.append({"name": state, "transitions": transitions})
        initial = next(s for s, c in inside["states"].items() if c.get("initial"))
        regions.append({"name": region, "initial": initial, "states": states})
    root = {"name": top, "parallel states": regions}
    return {"statechart": {"name": "robot", "root state": root}}


if __name__ == "__main__":
    sys.exit(main())
