"""What people wait for, measured in the tree that is the working folder.

`benchmarks.bench` calls each work in a process of its own, in this tree and in an earlier one, so
the works use what both have: commands, and little of the package itself.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

from benchmarks.used import Used, used_by

BEND, ROUND, SHORT = "mitre_bend", "take_elbow", "enter_2d"


def _used(*words: object, start: str = "main") -> Used:
    """What a command of this tree uses."""
    code = f"from pirate_sm.cli.start import {start}; {start}()"
    return used_by(sys.executable, "-c", code, *words)


def check(small: bool) -> Sequence[float]:
    """Wall time of the check of all files without kept results, processor time of a second one."""
    words = ("check", *([f"sequences/{SHORT}.yaml"] if small else ()))
    return _used(*words).wall_s, _used(*words).processor_s


def mission(small: bool) -> Sequence[float]:
    """Processor time of the check of a mission: unchanged, and with a comment more."""
    with TemporaryDirectory() as folder:
        file = Path(folder, "mission.yaml")
        text = Path("sequences", f"{SHORT if small else BEND}.yaml").read_text("utf-8")
        file.write_text(text, encoding="utf-8")
        _used("check", file)
        unchanged_s = _used("check", file).processor_s
        file.write_text(f"{text}# changed\n", encoding="utf-8")
        return unchanged_s, _used("check", file).processor_s


def explored(small: bool) -> Sequence[float]:
    """Steps that an exploration takes in a second of the processor."""
    from benchmarks.check import exploring
    from pirate_sm.core import library
    from pirate_sm.core.loading import load_mission

    steps, took_s = exploring(load_mission(library.find_mission(BEND)), 1 if small else 10)
    return (steps / took_s,)


def process(small: bool) -> Sequence[float]:
    """Processor time of a bend in a new process, its most memory in MB, and that of the help."""
    again = range(1 if small else 5)
    bends = [_used(BEND, "--speed", "max", "--quiet", start="run_main") for _ in again]
    helped = [_used("--help", start="run_main").processor_s for _ in again]
    most = max(each.memory_bytes for each in bends) / 2**20
    return min(each.processor_s for each in bends), most, min(helped)


def interpreted(small: bool) -> Sequence[float]:
    """A bend with the interpreter in times real time, and in a round pipe.

    Before them stand the events that python-statemachine does in a second, and by how much of real
    time a bend is faster for each of them.
    """
    from benchmarks.charts import in_library, rate
    from benchmarks.gliding import run
    from pirate_sm.core import library
    from pirate_sm.core.loading import load_robot
    from pirate_sm.running.wiring import Order

    repeats = 1 if small else 9
    events = rate(in_library, load_robot(library.find_robot("pirate_ii")), repeats, 200)
    factors = []
    for name in (SHORT,) if small else (BEND, ROUND):
        times = [run(Order(name), glides=True)[:2] for _ in range(repeats + 1)]
        factors.append(times[0][1] / min(took_s for took_s, _ in times[1:]))
    return factors[0] / events, events, factors[0], factors[-1]


def loop(small: bool) -> Sequence[float]:
    """Processor time of a mission that runs again with another seed."""
    import pirate_sm

    loaded, runs = pirate_sm.load(SHORT if small else BEND), 1 if small else 20
    pirate_sm.run(loaded)
    began_s = process_time()
    for seed in range(runs):
        pirate_sm.run(loaded, seed=seed)
    return ((process_time() - began_s) / runs,)


def odometry(small: bool) -> Sequence[float]:
    """By how much glides make a bend faster: by odometry, and as a part of that by `sim`."""
    from benchmarks.gliding import run
    from pirate_sm.running.wiring import Order

    gains = []
    for detector in ("odometry", "sim"):
        order = Order(SHORT if small else BEND, detector=detector)
        run(order, glides=True)
        pairs = [
            (run(order, glides=False)[0], run(order, glides=True)[0])
            for _ in range(1 if small else 9)
        ]
        stepped_s, glided_s = map(min, zip(*pairs, strict=True))
        gains.append(stepped_s / glided_s)
    return gains[0], gains[0] / gains[1]


def recorded(small: bool) -> Sequence[float]:
    """What a recording adds to the user's processor time of a bend, in per cent of it."""
    from benchmarks.recording import KINDS, short_runs

    spent = short_runs({kind: KINDS[kind] for kind in ("without", "with")}, 1 if small else 20)
    pairs = zip(spent["with"], spent["without"], strict=True)
    return (100 * median(one.user_s / other.user_s - 1 for one, other in pairs),)


def pipe(small: bool) -> Sequence[float]:
    """Processor time of loading a mission in a pipe of many segments, and of its findings there."""
    from benchmarks.growth import ON, load, pipe_of
    from pirate_sm.checking.pipe.check_in_pipe import pipe_findings, view_in_pipe

    with TemporaryDirectory() as folder:
        loading = load(Path(folder), ON, pipe=pipe_of(20 if small else 1_000))
        times = [process_time()]
        loaded = loading()
        times.append(process_time())
    in_pipe = view_in_pipe(loaded)
    assert in_pipe is not None  # its course is short enough
    pipe_findings(in_pipe)
    return times[1] - times[0], process_time() - times[1]


def learnt(small: bool) -> Sequence[float]:
    """Steps of random play that an environment takes in a second of the processor."""
    import gymnasium

    from benchmarks.learning import Dice, play_alone
    from pirate_sm.learning import IN_PIPE

    count = 1 if small else 12
    environment, dice = gymnasium.make(IN_PIPE), Dice(count)
    play_alone(environment, 0, Dice(1))
    began_s = process_time()
    steps = sum(play_alone(environment, index, dice) for index in range(count))
    return (steps / (process_time() - began_s),)


def campaign(small: bool) -> Sequence[float]:
    """Bends of a campaign that one worker passes in a second on the wall, and two to one."""
    runs = 2 if small else 600
    times = []
    for workers in (1, 2):
        with TemporaryDirectory() as folder:
            what = ("campaign", SHORT if small else BEND, "--seeds", runs, "--workers", workers)
            times.append(_used(*what, "--output", Path(folder, "of")).wall_s)
    return runs / times[0], times[0] / times[1]


def growth(small: bool) -> Sequence[float]:
    """The exponents with which times grow, once all is in memory that stays there."""
    from benchmarks.growth import ROWS, exponent

    for row in ROWS.values():
        row.times(small=True)
    return [exponent(row.times(small)) for row in ROWS.values()]


WORKS: dict[str, Callable[[bool], Sequence[float]]] = {
    each.__name__: each
    for each in (
        *(check, mission, explored, process, interpreted, loop, odometry, recorded, pipe, learnt),
        *(campaign, growth),
    )
}
"""By their names; each returns its figures, and takes seconds if it is to be small."""
