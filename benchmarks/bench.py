"""Speed and memory, side by side in one run.

    python -m benchmarks.bench [simulator] [recording] [console] [processes] [--repeats 5]

Chart commands: the same random commands through python-statemachine, through sismic where it is
installed, and through the compiled table; each answers whether the command moves the chart, and
why not. Simulator: the whole bend mission in one process, interpreter in the loop. Processes:
the installed command from start to end; *first* with empty caches, as after an installation, which
has compiled Python's modules; it is said whether the machine code of the simulator was built with
the package. Recording: see :mod:`benchmarks.recording`.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

from benchmarks.campaign import run
from benchmarks.console import measure_console
from benchmarks.recording import measure_commands, measure_recording, measure_short
from benchmarks.used import used_by
from pirate_sm.core import library
from pirate_sm.core.loading import LoadedRobot, load_robot
from pirate_sm.core.robot import ChartTable
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.machine_code.built_library import PACKAGE, find_library

BEND, IN_SPACE = "mitre_bend", ("take_elbow", "take_branch", "house_connection")
COMMANDS = 20_000
SEED = 7
REPEATS = 5
ALL = "all"


def main() -> int:
    """Everything, or the parts that are named, is measured and printed."""
    works: dict[str, Callable[[int], None]] = {
        "simulator": _simulator,
        "recording": _recording,
        "console": lambda _: measure_console(),
        "processes": _processes,
    }
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("parts", nargs="*", choices=(*works, ALL), default=ALL)
    parser.add_argument("--repeats", type=int, default=REPEATS)
    wishes = parser.parse_args()
    for name in works if ALL in wishes.parts else wishes.parts:
        works[name](wishes.repeats)
    return 0


def _charts(loaded: LoadedRobot, repeats: int) -> float:
    """Print the rates; return that of python-statemachine, in events per second."""
    table = loaded.table
    names = random.Random(SEED).choices(table.commands, k=COMMANDS)
    contenders: dict[str, Callable[[list[str]], int]] = {
        "python-statemachine": lambda some: _library(loaded, some),
        "compiled table": lambda some: _table(table, some),
    }
    try:
        import sismic  # noqa: F401
    except ModuleNotFoundError:
        print("sismic is not installed (make bench installs it)")
    else:
        contenders["sismic"] = lambda some: _sismic(loaded, some)
    print("chart commands, with the reason of a refusal")
    rates: dict[str, float] = {}
    moved: set[int] = set()
    for name, contender in contenders.items():
        count = COMMANDS if name == "compiled table" else COMMANDS // 10
        rates[name] = max(_rate(contender, names[:count]) for _ in range(repeats))
        moved.add(contender(names[: COMMANDS // 10]))
    assert len(moved) == 1, f"the contenders disagree: {moved}"
    base = rates["python-statemachine"]
    for name, rate in rates.items():
        print(f"    {name:22} {rate:12,.0f} /s   {rate / base:8.1f} ×")
    return base


def _rate(contender: Callable[[list[str]], int], names: list[str]) -> float:
    began = perf_counter()
    contender(names)
    return len(names) / (perf_counter() - began)


def _table(table: ChartTable, names: list[str]) -> int:
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


def _library(loaded: LoadedRobot, names: list[str]) -> int:
    from statemachine.io import load

    text = loaded.documents[1].text
    machine = load(text, format="yaml")()
    moved = 0
    before = frozenset(machine.configuration_values)
    for name in names:
        machine.send(name)
        after = frozenset(machine.configuration_values)
        moved += after != before
        before = after
    return moved


def _sismic(loaded: LoadedRobot, names: list[str]) -> int:
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


def _simulator(repeats: int) -> None:
    events_per_s = _charts(load_robot(library.find_robot("pirate_ii")), repeats)
    factors: dict[str, list[float]] = {mission: [] for mission in (BEND, *IN_SPACE)}
    for mission in factors:
        run(Order(mission))
    for _ in range(repeats):  # in turn, so that other work on the machine falls on all alike
        for mission, found in factors.items():
            outcome = run(Order(mission))
            found.append(outcome.time_s / outcome.took_s)
    bend = median(factors[BEND])
    spread = f"least {min(factors[BEND]):,.0f}, most {max(factors[BEND]):,.0f}"
    spread += f", of {repeats} bend missions"
    print(f"simulator, interpreter in the loop: {bend:,.0f} × real time ({spread})")
    share = bend / events_per_s
    print(f"    per event that python-statemachine does in a second: {share:.3f}")
    for mission in IN_SPACE:
        rate = median(factors[mission])
        print(f"    in round pipes, {mission}: {rate:,.0f} × real time, {rate / bend:.2f} of that")


def _recording(repeats: int) -> None:
    print("recording")
    measure_recording(repeats)
    measure_short()
    measure_commands(repeats)


def _processes(repeats: int) -> None:
    command = [str(Path(sys.executable).with_name("pirate-run"))]
    mission = [*command, "mitre_bend", "--speed", "max", "--quiet"]
    with tempfile.TemporaryDirectory() as empty:
        caches = {"NUMBA_CACHE_DIR": empty, "XDG_CACHE_HOME": empty}
        cold = {**os.environ, **caches, "PIRATE_SM_RUNS": ""}
        used_by(sys.executable, "-m", "compileall", "-q", PACKAGE)
        first = used_by(*mission, environment=cold).wall_s
        second = [used_by(*mission, environment=cold) for _ in range(repeats)]
        keeping = {**cold, "PIRATE_SM_RUNS": empty}
        third = [used_by(*mission, environment=keeping) for _ in range(repeats)]
    why_not = find_library().why_not
    print(f"machine code of the simulator: {f'not built, {why_not}' if why_not else 'built'}")
    print(f"bend mission, first process: {first:5.2f} s")
    later_s, recorded_s = (median(each.wall_s for each in some) for some in (second, third))
    print(f"bend mission, later process: {later_s:5.2f} s (median of {repeats})")
    print(f"the same, recorded:         {recorded_s:6.2f} s")
    helps = [used_by(*command, "--help").wall_s for _ in range(2 * repeats)]
    alone = [used_by(sys.executable, "-c", "").wall_s for _ in range(2 * repeats)]
    print(f"pirate-run --help:          {median(helps) * 1000:6.0f} ms (median of {len(helps)})")
    print(f"... Python alone:           {median(alone) * 1000:6.0f} ms")
    peak_bytes = max(each.memory_bytes for each in (*second, *third))
    print(f"peak memory of a mission:   {peak_bytes / 2**20:6.0f} MB (recorded or not)")


if __name__ == "__main__":
    sys.exit(main())
