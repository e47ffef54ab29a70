"""What each known defect of the robot leads to, over the shipped missions.

    python -m benchmarks.defects [--seeds 5] [--joint-seeds 20]

Every run must end by itself, without a fault of ours, with the wheels stopped, and with a part
still held once one was; it either completes or fails with a reason that can be read.

Then every defect of a bend joint, with each detector and in each bend, also with missions that go
on whatever is found wrong with a sensor: no run may succeed with a wheel more than 15 mm short of
the place that the detector's last word means, by the truth.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.campaign import Outcome, run_all
from pirate_sm.loading import library
from pirate_sm.loading.robot import load_robot
from pirate_sm.model.profile import Profile
from pirate_sm.wiring import Order

MISSIONS = ("mitre_bend", "exp_2c_tilted", "mitre_bend_backward", "exp_1a_both", "climb")
BENDS = ("mitre_bend", "mitre_bend_backward", "mitre_bend_other_side", "exp_2c_tilted")
DETECTORS = ("sim", "odometry")
SENSOR_FAULTS = (
    "sensor.silent", "sensor.stuck", "sensor.jumped", "sensor.spiking", "sensor.range",
    "motion.unasked",
)  # fmt: skip
SHORT_M = 0.015
"""So far a wheel may be short of the place that the detector's last word means."""

GRIPPED_NM = 0.1
"""A part whose joints bear less than this has let go."""


def main() -> int:
    """The outcomes per defect and mission are printed; 1 when a run broke a rule."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--joint-seeds", type=int, default=20)
    wishes = parser.parse_args()
    profile = load_robot(library.find_robot("pirate_ii")).profile
    bad = _survive(profile, range(wishes.seeds))
    with TemporaryDirectory() as folder:
        orders = bend_orders(profile, range(wishes.joint_seeds), heedless(Path(folder)))
        bad += _tell_truly(orders)
    return 1 if bad else 0


def _survive(profile: Profile, seeds: Sequence[int]) -> int:
    """Every defect in several missions; returns how many runs broke a rule."""
    orders = [
        Order(mission, seed=seed, defects=(defect,))
        for defect in profile.simulation.defects
        for mission in MISSIONS
        for seed in seeds
    ]
    bad = 0
    outcomes = run_all(orders)
    for defect in profile.simulation.defects:
        print(defect)
        for mission in MISSIONS:
            mine = [
                outcome
                for order, outcome in zip(orders, outcomes, strict=True)
                if order.defects == (defect,) and order.mission == mission
            ]
            for (what, why), count in Counter((o.outcome, o.message) for o in mine).most_common():
                print(f"    {mission:20} {count} × {what}: {why}")
            for outcome in mine:
                broken = _broken(outcome)
                bad += bool(broken)
                for rule in broken:
                    print(f"    {mission:20} seed {outcome.seed}: {rule}")
    print(f"{len(outcomes)} runs, {bad} broke a rule")
    return bad


def _tell_truly(orders: Sequence[Order]) -> int:
    """Every defect of a joint, each detector, each bend; returns how many successes are false."""
    outcomes: dict[tuple[str, str, str], list[Outcome]] = {}
    for order, outcome in zip(orders, run_all(orders), strict=True):
        case = (order.defects[0], order.detector or "", Path(order.mission).stem)
        outcomes.setdefault(case, []).append(outcome)
    bad = 0
    print(f"\n{'defect':24} {'detector':9} {'mission':30} succeeded  farthest short  falsely")
    for (defect, detector, mission), mine in outcomes.items():
        passed = [each for each in mine if each.outcome == "succeeded"]
        farthest = f"{max(each.short_m for each in passed) * 1000:.0f} mm" if passed else "-"
        false = [str(each.seed) for each in passed if is_false(each)]
        bad += len(false)
        print(
            f"{defect:24} {detector:9} {mission:30} {len(passed):3} of {len(mine):3}"
            f"  {farthest:>14}  {'seeds ' + ', '.join(false) if false else 'none'}"
        )
    print(f"{len(orders)} runs, {bad} succeeded falsely")
    return bad


def bend_orders(profile: Profile, seeds: Sequence[int], missions: Sequence[str]) -> list[Order]:
    """Return what is to be run: each defect of a bend joint or of its sensors, on every bend."""
    return [
        Order(mission, seed=seed, defects=(defect,), detector=detector)
        for defect in joint_defects(profile)
        for detector in DETECTORS
        for mission in (*BENDS, *missions)
        for seed in seeds
    ]


def heedless(folder: Path) -> list[str]:
    """Write missions that go on whatever is found wrong with a sensor; return their paths."""
    found = []
    for name in ("mitre_bend", "mitre_bend_backward"):
        text = library.find_mission(name).read_text(encoding="utf-8")
        caught = f"fault: [{', '.join(SENSOR_FAULTS)}, wheel.dead]"
        changed = re.sub(r"fault: \[sensor\.silent[^]]*\]", caught, text)
        assert changed != text, f"{name} handles no fault of a sensor"
        path = folder / f"{name}_heedless.yaml"
        path.write_text(changed.replace(f"mission: {name}", f"mission: {path.stem}"), "utf-8")
        found.append(str(path))
    return found


def joint_defects(profile: Profile) -> list[str]:
    """Return the names of the defects of bend joints or of their sensors."""
    joints = {joint.name for joint in profile.body.joints}
    return [
        name
        for name, defect in profile.simulation.defects.items()
        if joints & {*defect.signals, *defect.raw, defect.joint}
    ]


def is_false(outcome: Outcome) -> bool:
    """Return whether a run succeeded though its wheel was short of the last word's place."""
    return outcome.outcome == "succeeded" and not outcome.short_m <= SHORT_M


def _broken(outcome: Outcome) -> list[str]:
    """Which rules the run broke."""
    broken = []
    if outcome.exit_code == 4:
        broken.append("CRASHED")
    if outcome.time_s > 3600:
        broken.append("HUNG")
    if not outcome.stopped:
        broken.append("WHEELS NOT STOPPED")
    if outcome.held_at_end is False and len(outcome.states) > 3:
        broken.append("LET GO: no part is held at the end")
    if outcome.held_at_end and max(map(abs, outcome.torques), default=0.0) < GRIPPED_NM:
        broken.append("LET GO: no joint bears a torque at the end")
    if outcome.gone:
        broken.append("LEFT THE PIPE")
    return broken


if __name__ == "__main__":
    sys.exit(main())
