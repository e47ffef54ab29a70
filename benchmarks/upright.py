"""How a robot holds in an upright pipe: clamped as friction asks for, and by a fixed torque.

    python -m benchmarks.upright [--seeds 60] [--workers 2]

The robot of 0.79 kg heads upwards with even seeds and downwards with odd ones. Each seed draws the
kinetic friction from 0.2 to 0.7; static friction is 1.3 times as much. Somewhere on the way there
is a patch, 0.2 m long, with half of that. At first outer wheels turn
faster than the others and slip, then the robot drives forth and back, while a simulated ruler
measures its speed. In between it settles for as long as a grip needs to be lowered.

A robot slides where it moves downhill beyond what its wheels roll, and falls where that is more
than 50 mm. Clamp torques are those that the sensors of the apexes show, while nothing is known of
the friction of their part, and once it is.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache, partial
from itertools import pairwise
from math import isnan
from multiprocessing import get_context
from pathlib import Path
from random import Random
from shutil import copytree
from statistics import median
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from pirate_sm.engine.control.torque_loop import TorqueLoop
from pirate_sm.loading import library
from pirate_sm.model.effects import Effect

if TYPE_CHECKING:
    from pirate_sm.loading.mission import LoadedMission
    from pirate_sm.runtime.loop import MissionRun
    from pirate_sm.wiring import Prepared

MISSION = Path(__file__).with_name("upright.yaml")
LEAST_KINETIC, MOST_KINETIC, STATIC_SHARE = 0.2, 0.7, 1.3
PATCH_M = 0.2
PATCH_BEGINS_M = 0.7, 1.7
FALLEN_M = 0.050
SAMPLE_EVERY_S = 0.1
SETTLED_S = 3.0
"""Clamps that start at their torques of rest have wound up after this time."""

FIXED = """\
  fixed:
    description: As exp_3a, clamped by 280 mNm
    extends: exp_3a
    actuation:
      BendingState:
        DoubleClamped: {bend_1: -280 mNm, bend_2: 0 mNm, bend_3: 0 mNm, bend_4: 280 mNm}
"""
CONTROLS = ("careful", "fixed")


@dataclass
class Watch:
    """Notes what the robot does, from the truth and from what the engine knows.

    Attributes:
        down: 1 where ahead is downhill, else -1.
        places_m: The mean place of the wheels and the median of what they have rolled.
        torques_nm: By whether the friction of the part is known, what its apex bears.
    """

    down: int
    prepared: Prepared
    run: MissionRun | None = None
    due_s: float = 0.0
    places_m: list[tuple[float, float]] = field(default_factory=list)
    torques_nm: dict[bool, list[float]] = field(default_factory=lambda: {False: [], True: []})

    def see(self, effects: Sequence[Effect], now_s: float) -> None:
        """Take a sample where one is due."""
        if now_s < self.due_s or self.run is None or self.run.state is None:
            return
        self.due_s = now_s + SAMPLE_EVERY_S
        state, robot = self.run.state, self.prepared.engine.robot
        numbers = state.sensing.numbers
        arcs_m = self.prepared.backend.arcs_m  # type: ignore[attr-defined]
        rolled = [numbers[wheel.angle] * wheel.metres_per_rad for wheel in robot.wheels]
        self.places_m.append((sum(arcs_m) / len(arcs_m), median(rolled)))
        for loop in state.robot.loops:
            if isinstance(loop, TorqueLoop) and loop.asked_nm and now_s > SETTLED_S:
                known = loop.gripping is not None and not isnan(loop.gripping.friction)
                self.torques_nm[known].append(abs(numbers[loop.spec.torque]))

    @property
    def slid_m(self) -> float:
        """Return the farthest that it has been carried downhill."""
        farthest = slid_m = 0.0
        for (place, rolled), (to_place, to_rolled) in pairwise(self.places_m):
            slid_m += self.down * ((to_place - place) - (to_rolled - rolled))
            farthest = max(farthest, slid_m)
        return farthest


@dataclass(frozen=True)
class Trial:
    """One run: ``unknown_nm`` and ``known_nm`` are what the clamps bore, by what was known."""

    seed: int
    kinetic: float
    heads_down: bool
    ended: str
    slid_m: float
    unknown_nm: tuple[float, ...]
    known_nm: tuple[float, ...]

    @property
    def fell(self) -> bool:
        """Return whether the robot was carried away."""
        return self.slid_m > FALLEN_M


def main() -> int:
    """Print what came of each control; return 1 when a careful robot fell."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=60)
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    wishes = parser.parse_args()
    falls = {}
    with (
        TemporaryDirectory() as folder,
        ProcessPoolExecutor(wishes.workers, mp_context=get_context("spawn")) as pool,
    ):
        for control in CONTROLS:
            mission = _written(Path(folder), control)
            found = list(pool.map(partial(try_out, str(mission)), range(wishes.seeds)))
            falls[control] = sum(trial.fell for trial in found)
            _show(control, found)
    return 1 if falls["careful"] else 0


def _written(folder: Path, control: str) -> Path:
    """Write the mission with this control, and the robot that has it; return its path."""
    robot = folder / "pirate_ii"
    if not robot.exists():
        copytree(library.find_robot("pirate_ii"), robot)
        profile = robot / "profile.yaml"
        text = profile.read_text("utf-8")
        profile.write_text(text.replace("  exp_3b:\n", f"{FIXED}  exp_3b:\n", 1), "utf-8")
    text = MISSION.read_text("utf-8")
    if control == "fixed":
        text = text.replace("control: careful", "control: fixed").replace(
            "{control: probing}, ", ""
        )
    path = folder / f"{control}.yaml"
    text = text.replace("robot: pirate_ii", f"robot: {robot}")
    path.write_text(text.replace("mission: upright", f"mission: {control}"), "utf-8")
    return path


@cache
def _loaded(mission: str) -> LoadedMission:
    from pirate_sm.wiring import Order, load

    return load(Order(mission))


def try_out(mission: str, seed: int) -> Trial:
    """Run the mission with the friction and the heading of this seed."""
    from pirate_sm.model.pipe import Patch
    from pirate_sm.model.simulation import Friction
    from pirate_sm.runtime.first_choice import FirstChoice
    from pirate_sm.runtime.loop import MissionRun
    from pirate_sm.wiring import Order, prepare

    heads_down = bool(seed % 2)
    kinetic = Random(f"friction {seed}").uniform(LEAST_KINETIC, MOST_KINETIC)
    begins_m = Random(f"patch {seed}").uniform(*PATCH_BEGINS_M)
    patch = Patch.model_validate(
        {
            "from": f"{begins_m} m",
            "to": f"{begins_m + PATCH_M} m",
            "static": STATIC_SHARE * kinetic / 2,
            "kinetic": kinetic / 2,
        }
    )
    changes = {
        "patches": (patch,),
        "friction": Friction(static=STATIC_SHARE * kinetic, kinetic=kinetic),
        "uphill": 3.141592653589793 if heads_down else 0.0,
    }
    loaded = _loaded(mission)
    assert loaded.pipe is not None
    loaded = replace(loaded, pipe=loaded.pipe.model_copy(update=changes))
    prepared = prepare(Order(mission, seed=seed, ruler=True), loaded)
    watch = Watch(1 if heads_down else -1, prepared)
    run = MissionRun(
        prepared.engine,
        prepared.backend,
        observers=[watch],
        companions=(*prepared.companions, FirstChoice()),
    )
    watch.run = run
    ended = run.execute().ended
    torques = watch.torques_nm
    words = f"{ended.outcome}: {ended.message}"
    return Trial(
        seed, kinetic, heads_down, words, watch.slid_m, tuple(torques[False]), tuple(torques[True])
    )


def _show(control: str, trials: Sequence[Trial]) -> None:
    fallen = [trial for trial in trials if trial.fell]
    slides = sorted(trial.slid_m * 1000 for trial in trials)
    print(
        f"{control}: {len(fallen)} of {len(trials)} fell; slid {median(slides):.1f} mm in the"
        f" median, {slides[-1]:.1f} mm at most"
    )
    for up in (False, True):
        mine = [trial for trial in trials if trial.heads_down == up]
        fell = [f"{trial.seed} ({trial.kinetic:.2f})" for trial in mine if trial.fell]
        way = "downwards" if up else "upwards"
        print(f"    heading {way}: fell {', '.join(fell) or 'never'}, of {len(mine)}")
    for what, values in (
        ("unknown", [nm for trial in trials for nm in trial.unknown_nm]),
        ("known", [nm for trial in trials for nm in trial.known_nm]),
    ):
        if values:
            print(f"    clamp torque with friction {what}: {median(values) * 1000:.0f} mNm, median")
    near = [nm for trial in trials if abs(trial.kinetic - 0.5) < 0.05 for nm in trial.known_nm]
    if near:
        print(f"    ... known to be 0.45 to 0.55: {median(near) * 1000:.0f} mNm, median")
    for words, count in Counter(trial.ended for trial in trials).most_common():
        print(f"    {count:4} × {words}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
