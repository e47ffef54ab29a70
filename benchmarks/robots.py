"""Whether robots with other motors pass the bend, or end holding and say why: `make robots`.

    python -m benchmarks.robots [--robots 64] [--seed 0] [--number 17] [--detector odometry]

Each robot draws its motors, springs and friction, over what is plausible for numbers that nobody
has measured. The engine knows nothing of them: it has the profile. The simulator's truth judges
whether the robot has passed (every wheel is beyond the bend, no part folded), or ends holding: a
clamp bears, and the robot stays where it is. Why it did not pass is printed with the numbers of
that robot, and the command that repeats it.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from random import Random

import yaml

from benchmarks.campaign import run_all
from pirate_sm.lab.campaign.campaign_model import TrueEnd
from pirate_sm.lab.campaign.plan import command_of
from pirate_sm.lab.campaign.watched_run import RunVerdict, judge
from pirate_sm.running.wiring import Order

FOLDER = Path("runs/robots")
SHARE = 60 / 64
"""At least so many of the robots pass."""

STATIC_SHARE = 1.3
DRAWN = (
    ("bend", "stall_torque", 0.5, 2.0, "Nm"),
    ("bend", "no_load_speed", 0.18, 0.72, "rad/s"),
    ("bend", "stiffness", 1.7, 4.0, "Nm/rad"),
    ("wheel", "stall_torque", 0.25, 0.45, "Nm"),
    ("wheel", "no_load_speed", 3.1, 12.6, "rad/s"),
    ("wheel", "hold_torque", 0.1, 0.4, "Nm"),
    ("wheel", "dead_drag", 0.02, 0.1, "Nm"),
)
"""From where to where each number of a motor is drawn; speeds are those of 3 V to 12 V, where the
profile assumes 6 V."""

KINETIC = 0.3, 0.8
END = TrueEnd(beyond=1.0)


def twin_of(seed: int, number: int) -> Path:
    """Write the numbers of a drawn robot; return the file."""
    lot = Random(f"{seed}:{number}")
    motors: dict[str, dict[str, str]] = {}
    for motor, key, least, most, unit in DRAWN:
        motors.setdefault(motor, {})[key] = f"{lot.uniform(least, most):.3f} {unit}"
    kinetic = round(lot.uniform(*KINETIC), 3)
    friction = {"static": round(kinetic * STATIC_SHARE, 3), "kinetic": kinetic}
    file = FOLDER / f"robot_{seed}_{number}.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    twin = {"format": 1, "robot": "pirate_ii", "motors": motors, "friction": friction}
    file.write_text(yaml.safe_dump(twin, sort_keys=False), encoding="utf-8")
    return file


def main() -> int:
    """Print which robots did not pass, and why; return 1 when too few do, or one lets go."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--number", type=int, help="judge this robot alone")
    parser.add_argument("--detector", default="sim", help="whose words it goes by")
    parser.add_argument("--mission", default="mitre_bend")
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    wishes = parser.parse_args()
    numbers = range(wishes.robots) if wishes.number is None else [wishes.number]
    orders = [
        Order(
            wishes.mission,
            seed=number,
            twin=str(twin_of(wishes.seed, number)),
            detector=wishes.detector,
        )
        for number in numbers
    ]
    verdicts = [judge(outcome, END) for outcome in run_all(orders, workers=wishes.workers)]
    for line in _lines(orders, verdicts):
        print(line)
    passed = sum(each.what == "passed" for each in verdicts)
    held = all(each.held for each in verdicts)
    print(f"{passed} of {len(verdicts)} pass; the others {'hold' if held else 'DO NOT ALL HOLD'}")
    return 0 if held and passed >= SHARE * len(verdicts) else 1


def _lines(orders: Sequence[Order], verdicts: Sequence[RunVerdict]) -> Iterator[str]:
    for order, verdict in zip(orders, verdicts, strict=True):
        if verdict.what != "passed":
            what = "holds" if verdict.held else f"{verdict.what.upper()}, DOES NOT HOLD"
            yield f"{order.seed} {what}: {verdict.why}"
            numbers = yaml.safe_load(Path(order.twin or "").read_text(encoding="utf-8"))
            yield f"    {numbers['motors']} friction {numbers['friction']['kinetic']}"
            yield f"    {command_of(order, order.seed)}"


if __name__ == "__main__":
    sys.exit(main())
