"""How level a part comes that is turned by the accelerometer, in a round pipe in space.

    python -m benchmarks.align [--rolls 12] [--seeds 1] [--pitch 0] [--diameter 120] [--backend sim]
                               [--robot pirate_ii_imu] [--enter 20]

The robot stands in a straight round pipe, both parts clamped, in a plane at one of twelve rolls.
One part lets go, AlignHorizontal or AlignVertical turns it. Printed is the angle by which its
plane is off then, by the truth of the simulator, or why the command failed. A command that does
not come within 3 deg must fail as *impossible*; the exit code is 1 where one does neither.

In a flat pipe of 120 mm the mission `level` is run from each roll then, whose robot is loose at
first: how it ends, and how far its two planes are from the horizontal. `--enter` runs the mission
`enter_3d` with so many seeds, of a robot that is put in upright and of one that is put in lying.
That one turns into an upright plane, and must say so.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from math import degrees, isnan, nan, remainder
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

from pirate_sm.core.companion import entered

WITHIN_DEG = 3.0
"""The bar: how far a levelled plane may be off."""

COMMANDS = {"AlignHorizontal": 0.0, "AlignVertical": 90.0}
"""The commands, and the roll of the plane that they lead to, in degrees."""

HOLDERS = {"rear": ("RelaxFront", 1), "front": ("RelaxRear", 2)}
"""Per part that holds, the command that lets the other one go, and where its roll stands."""

PUT_IN = {90.0: "upright", 0.0: "lying"}
"""How the robot of enter_3d is put in, by its roll in degrees."""

_PIPE = """\
format: 1
pipe: rolled
diameter: {diameter:g} mm
section: round
tilt: {pitch:g} deg
roll: {roll:g} deg
segments: [{{straight: 1.5 m}}]
start: {{at: 900 mm}}
"""

_MISSION = """\
format: 1
mission: align
robot: {robot}
pipe: rolled.yaml
starts_in:
  BendingState: DoubleClamped
  FrontWheelsState: Fixed
  RearWheelsState: Fixed
on_failure: failed
start: hold
phases:
  hold:
    do: [{relax}, {command}]
    go: level
ends:
  level: {{succeed: Level}}
  failed: {{fail: "{{cause}}"}}
"""


@dataclass(frozen=True)
class Trial:
    """One command from one roll.

    Attributes:
        off_deg: How far the plane of the part that turned is off; NaN where the command failed.
        why: Why it failed; empty where it did not.
    """

    command: str
    holder: str
    roll_deg: float
    seed: int
    off_deg: float
    why: str
    took_s: float

    @property
    def passes(self) -> bool:
        """Whether it came within the bar, or said that it is impossible."""
        return abs(self.off_deg) <= WITHIN_DEG or "impossible:" in self.why


def try_out(
    order: tuple[str, str, float, int],
    *,
    pitch_deg: float = 0.0,
    diameter_mm: float = 120.0,
    backend: str = "sim",
    robot: str = "pirate_ii_imu",
) -> Trial:
    """Give one command and return what comes of it.

    Args:
        order: The command, the part that holds, the roll at the start in degrees, and the seed.
        pitch_deg: How steep the pipe climbs.
        diameter_mm: Its inner diameter.
        backend: The backend that moves the robot.
        robot: Name or path of the robot.
    """
    command, holder, roll_deg, seed = order
    relax, part = HOLDERS[holder]
    with TemporaryDirectory() as folder:
        mission = Path(folder) / "align.yaml"
        mission.write_text(_MISSION.format(robot=robot, relax=relax, command=command))
        pipe = _PIPE.format(diameter=diameter_mm, pitch=pitch_deg, roll=_against(roll_deg))
        (Path(folder) / "rolled.yaml").write_text(pipe)
        why, rolls_deg, took_s = _run(str(mission), None, backend, seed)
    off_deg = nan if why else remainder(rolls_deg[part] - COMMANDS[command], 180.0)
    return Trial(*order, off_deg, why, took_s)


def drive_off(
    roll_deg: float, seed: int = 0, *, mission: str = "level", backend: str = "sim"
) -> Trial:
    """Run a mission with a robot that is put in at a roll; by default `level`.

    Args:
        roll_deg: The roll at the start, in degrees.
        seed: The seed.
        mission: Name of the mission.
        backend: The backend that moves the robot.
    """
    with TemporaryDirectory() as folder:
        pipe = Path(folder) / "rolled.yaml"
        pipe.write_text(_PIPE.format(diameter=120.0, pitch=0.0, roll=_against(roll_deg)))
        why, rolls_deg, took_s = _run(mission, str(pipe), backend, seed)
    off_deg = max((remainder(each, 180.0) for each in rolls_deg[1:]), key=abs)
    return Trial(mission, "both", roll_deg, seed, off_deg, why, took_s)


def _against(roll_deg: float) -> float:
    """Return the roll of a pipe against a robot at this roll, in degrees."""
    return remainder(-roll_deg, 360.0)


def _run(
    mission: str, pipe: str | None, backend: str, seed: int
) -> tuple[str, tuple[float, ...], float]:
    """Return why a mission failed, else "", the true rolls in degrees, and how long it took."""
    from pirate_sm.running.runtime.loop import MissionRun
    from pirate_sm.running.runtime.scripted_events import FirstChoice
    from pirate_sm.running.wiring import Order, load, prepare

    wishes = Order(mission, backend, pipe=pipe, seed=seed)
    ready = prepare(wishes, load(wishes))
    with entered(ready.companions):
        companions = (*ready.companions, FirstChoice())
        result = MissionRun(ready.engine, ready.backend, companions=companions).execute()
    rolls_deg = tuple(map(degrees, ready.backend.truth.rolls_rad))  # type: ignore[attr-defined]
    why = "" if result.ended.outcome == "succeeded" else result.ended.message
    return why, rolls_deg, result.now_s


def main() -> int:
    """Print what came of each command; return 1 when one was neither level nor impossible."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--rolls", type=int, default=12, help="how many, all round")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--pitch", type=float, default=0.0, help="of the pipe, in degrees")
    parser.add_argument("--diameter", type=float, default=120.0, help="of the pipe, in mm")
    parser.add_argument("--backend", default="sim")
    parser.add_argument("--robot", default="pirate_ii_imu")
    parser.add_argument("--enter", type=int, default=0, help="seeds of enter_3d")
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    wishes = parser.parse_args()
    orders = [
        (command, holder, 360.0 * number / wishes.rolls, seed)
        for command in COMMANDS
        for holder in HOLDERS
        for number in range(wishes.rolls)
        for seed in range(wishes.seeds)
    ]
    one = partial(
        try_out,
        pitch_deg=wishes.pitch,
        diameter_mm=wishes.diameter,
        backend=wishes.backend,
        robot=wishes.robot,
    )
    with ProcessPoolExecutor(wishes.workers, mp_context=get_context("spawn")) as pool:
        trials = list(pool.map(one, orders))
        missions = []
        if (wishes.pitch, wishes.diameter) == (0.0, 120.0):
            rolls = [360.0 * number / wishes.rolls for number in range(wishes.rolls)]
            missions = list(pool.map(partial(drive_off, backend=wishes.backend), rolls))
        enter = partial(drive_off, mission="enter_3d", backend=wishes.backend)
        seeds = range(wishes.enter)
        entered_ = {roll: list(pool.map(partial(enter, roll), seeds)) for roll in PUT_IN}
    for command in COMMANDS:
        for holder in HOLDERS:
            show([each for each in trials if (each.command, each.holder) == (command, holder)])
    if missions:
        _show_missions(missions)
    for roll, runs in entered_.items():
        for why, count in Counter(each.why or "succeeded" for each in runs).most_common():
            off = max(abs(each.off_deg) for each in runs)
            print(f"enter_3d, put in {PUT_IN[roll]}, {off:.1f} deg off at most: {count} x {why}")
    return 0 if all(each.passes for each in trials) and not any(m.why for m in missions) else 1


def _show_missions(missions: Sequence[Trial]) -> None:
    failed = [each for each in missions if each.why]
    print(
        f"the mission level: {len(missions) - len(failed)} of {len(missions)} succeed,"
        f" {max(abs(each.off_deg) for each in missions):.1f} deg off at most;"
        f" {max(each.took_s for each in missions):.1f} s at most"
    )
    for each in failed:
        print(f"    roll {each.roll_deg:g} deg: {each.why}")


def show(trials: Sequence[Trial]) -> None:
    """Print what came of one command with one part that holds."""
    level = [abs(each.off_deg) for each in trials if not isnan(each.off_deg)]
    impossible = sum("impossible:" in each.why for each in trials)
    first = trials[0]
    off = f"{max(level):.1f} deg off at most" if level else "none came to a level"
    print(
        f"{first.command}, {first.holder} holds: {len(level)} of {len(trials)} level,"
        f" {off}; {impossible} impossible;"
        f" {max(each.took_s for each in trials):.1f} s at most"
    )
    for each in trials:
        if not each.passes:
            what = each.why or f"{each.off_deg:.1f} deg off"
            print(f"    roll {each.roll_deg:g} deg, seed {each.seed}: {what}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
