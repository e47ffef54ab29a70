"""How fast missions are explored and checked.

    python -m benchmarks.check [--runs 5] [--mission NAME] [--phases 300 1000 3000] [--held 2 6 12]

Times are of the processor, the best of several runs, so that other programs disturb them less.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from pirate_sm.checking.exploring.explore import conditions_of, explore
from pirate_sm.checking.mission.check_mission import check_loaded
from pirate_sm.core import library
from pirate_sm.core.loading import LoadedMission, load_mission

RUNS = 5
PHASES = (300, 1_000, 3_000)
HELD = (2, 6, 12)

HEAD = "format: 1\nmission: m\nrobot: pirate_ii\n"
SIGNALS = [*(f"gamma_{n}" for n in range(1, 5)), *(f"wheel_torque_{n}" for n in range(1, 7))]
SIGNALS += ["roll", "pitch"]


def best_s(work: Callable[[], object], runs: int) -> float:
    """The least processor time that the work takes."""
    times = []
    for _ in range(runs):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times)


def exploring(loaded: LoadedMission, runs: int) -> tuple[int, float]:
    """Steps of one exploration, and how long it takes."""
    robot, program = loaded.robot, loaded.program
    steps = len(explore(robot, program, conditions_of(loaded)).steps)
    return steps, best_s(lambda: explore(robot, program, conditions_of(loaded)), runs)


def long_mission(phases: int) -> str:
    """So many phases one after the other, each with a command, a wait, a failure and faults."""
    lines = [
        f"  p{n}: {{do: [ToggleLighting], wait: [{{when: detector == close, held: 200 ms, "
        f"go: {f'p{n + 1}' if n + 1 < phases else 'e'}}}], within: {{time: 10 s, go: r}}}}"
        for n in range(phases)
    ]
    faults = "on_fault: [{fault: robot.stuck, go: r}, {fault: sensor.silent, go: r}]\n"
    return (
        f"{HEAD}on_failure: r\n{faults}start: p0\nphases:\n" + "\n".join(lines)
        + "\n  r: {do: [ToggleLighting], go: f}\nends: {e: {succeed: ok}, f: {fail: bad}}\n"
    )  # fmt: skip


def holding_mission(triggers: int) -> str:
    """One wait for any of ``triggers`` conditions to be held."""
    lines = [
        f"      - {{when: known({name}), held: {n + 1} s, name: t{n}, go: e}}"
        for n, name in enumerate(SIGNALS[:triggers])
    ]
    wait = "start: a\nphases:\n  a:\n    wait:\n" + "\n".join(lines)
    ends = "ends: {e: {succeed: ok}, f: {fail: bad}}\n"
    return f"{HEAD}{wait}\n    within: {{time: 1 min, go: f}}\n{ends}"


def shipped(names: Collection[str], runs: int) -> None:
    """These shipped missions: the exploration alone, and all of the check of a loaded mission."""
    print(f"{'mission':24}{'steps':>8}{'steps/s':>10}{'check':>10}")
    for path in (each for each in library.missions() if each.stem in names):
        loaded = load_mission(path)
        number, exploring_s = exploring(loaded, runs)
        checking_s = best_s(lambda: check_loaded(loaded), runs)  # noqa: B023
        print(f"{path.stem:24}{number:8}{number / exploring_s:10.0f}{1e3 * checking_s:7.1f} ms")


def growing(folder: Path, phases: Sequence[int], held: Sequence[int]) -> None:
    """Missions that grow in length, and waits that grow in width."""
    print(f"\n{'made':24}{'steps':>8}{'steps/s':>10}{'check':>10}")
    made = [(f"{n} phases", long_mission(n)) for n in phases]
    made += [(f"{n} conditions to hold", holding_mission(n)) for n in held]
    for name, text in made:
        (folder / "m.yaml").write_text(text, encoding="utf-8")
        loaded = load_mission(folder / "m.yaml")
        number, exploring_s = exploring(loaded, 1)
        checking_s = best_s(lambda: check_loaded(loaded), 1)  # noqa: B023
        print(f"{name:24}{number:8}{number / exploring_s:10.0f}{1e3 * checking_s:7.0f} ms")


def main() -> None:
    """The figures stand on standard output."""
    names = [path.stem for path in library.missions()]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=RUNS, help="of which the best counts")
    parser.add_argument("--mission", action="append", choices=names, help="all by default")
    parser.add_argument("--phases", type=int, nargs="*", default=PHASES, help="of long missions")
    parser.add_argument("--held", type=int, nargs="*", default=HELD, help="conditions to hold")
    wishes = parser.parse_args()
    shipped(wishes.mission or names, wishes.runs)
    with TemporaryDirectory() as folder:
        growing(Path(folder), wishes.phases, wishes.held)


if __name__ == "__main__":
    main()
