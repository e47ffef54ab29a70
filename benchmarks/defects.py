"""What each known defect of the robot leads to, over the shipped missions.

    python -m benchmarks.defects [--seeds 5]

Every run must end by itself, without a fault of ours, with the wheels stopped, and with a part
still held once one was; it either completes or fails with a reason that can be read.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter

from benchmarks.campaign import Outcome, run_all
from pirate_sm.loading import library
from pirate_sm.loading.robot import load_robot
from pirate_sm.wiring import Order

MISSIONS = ("mitre_bend", "exp_2c_tilted", "mitre_bend_backward", "exp_1a_both", "climb")
GRIPPED_NM = 0.1
"""A part whose joints bear less than this has let go."""


def main() -> int:
    """The outcomes per defect and mission are printed; 1 when a run broke a rule."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=5)
    seeds = range(parser.parse_args().seeds)
    profile = load_robot(library.find_robot("pirate_ii")).profile
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
    return 1 if bad else 0


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
