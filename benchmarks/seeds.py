"""How often the whole bend succeeds when start, friction, diameter and noise vary.

    python -m benchmarks.seeds [--row NAME] [--seeds 300] [--workers 2]
                               [--detector odometry] [--start-jitter 20] [--backend physics]

Each seed shifts the start by up to 20 mm (odometry does not know by how much), friction by up to
20 %, the diameter by up to 2 mm, and draws its own sensor and detector noise. A run counts as
passed when the mission succeeds, every wheel is beyond the bend in truth, no part is folded back on
itself, and forward the nine snapshots of fig. 6-9 are a subsequence of its states.

The rows with an upright leg also count a run that fails and holds: a clamp bears, and the robot
stays where it is, both in truth. In no row may a run say falsely that it succeeded.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter

import yaml

from benchmarks.campaign import MotorValue, Outcome, options_of_rows, run_all
from pirate_sm.wiring import Order

SNAPSHOTS = Path(__file__).with_name("fig_6_9.yaml")
CROSSING_M = 1.0
GRIPPED_NM = 0.1
"""A part whose joints bear less than this does not hold."""
STAYS_M = 0.005
"""A robot that is carried farther in two seconds after its mission does not hold."""

FALSE = "said to have passed"


@dataclass(frozen=True)
class Row:
    """A mission in a pipe, and how often it must end well.

    Attributes:
        name: What is printed, and what ``--row`` takes.
        mission: Name of the mission.
        pipe: Name of the pipe, in place of the mission's own.
        seeds: Number of runs.
        bar: Least share of runs that must count; 0 for a row that is only shown.
        forward: Whether the robot must end beyond the crossing, or before it.
        snapshots: Whether fig. 6-9 must appear.
        holding: Whether a run that fails with the robot held counts too.
        defects: Of the robot.
        motors: Values of motors in place of the profile's.
    """

    name: str
    mission: str
    pipe: str | None = None
    seeds: int = 300
    bar: float = 0.99
    forward: bool = True
    snapshots: bool = True
    holding: bool = False
    defects: tuple[str, ...] = ()
    motors: tuple[MotorValue, ...] = ()


_SOFT = (("wheel", "hold_torque", 0.05), ("wheel", "dead_drag", 0.05))

ROWS = (
    Row("horizontal", "mitre_bend", seeds=1000),
    Row("28 deg tilt", "mitre_bend", "mitre_90_tilted", seeds=1000),
    Row("backward", "mitre_bend_backward", seeds=1000, forward=False),
    Row("45 deg", "mitre_bend", "mitre_45"),
    Row("60 deg", "mitre_bend", "mitre_60"),
    Row("115 mm", "mitre_bend", "mitre_90_115mm"),
    Row("105 mm", "mitre_bend", "mitre_90_105mm", bar=0.90),
    Row("wheels 3, 4 dead", "mitre_bend", defects=("wheels_3_4_dead",)),
    Row("from below", "take_bend", "mitre_90_from_below", snapshots=False, holding=True),
    Row("from above", "take_bend", "mitre_90_from_above", snapshots=False, holding=True),
    Row("upwards", "take_bend", "mitre_90_up", snapshots=False, holding=True),
    Row("downwards", "take_bend", "mitre_90_down", snapshots=False, holding=True),
    Row("hold 50/50 mNm", "mitre_bend", bar=0.0, motors=_SOFT),
)
_AGREEING = 8
"""So many rows, the first ones, are those in which the two physics are compared."""


@dataclass(frozen=True)
class Verdict:
    """How a run ended, by truth.

    Attributes:
        seed: Its seed.
        passed: Whether it counts as passed.
        counts: Whether it counts for the bar.
        false: Whether the mission succeeded and the robot did not pass.
        why: Why it did not pass.
    """

    seed: int
    passed: bool
    counts: bool
    false: bool
    why: str


def main() -> int:
    """Print each row; return 1 when one misses its bar or a run succeeded falsely."""
    seeds = "runs of every row, in place of its own number"
    parser = options_of_rows(__doc__, [row.name for row in ROWS], None, seeds)
    parser.add_argument("--detector", default="sim")
    parser.add_argument("--backend", default="sim", help="physics: at least 95 %% of each row")
    parser.add_argument("--start-jitter", type=float, default=20.0, help="mm")
    wishes = parser.parse_args()
    good = True
    rows = ROWS[:_AGREEING] if wishes.backend == "physics" else ROWS
    for row in rows if wishes.row is None else ROWS:
        if wishes.row is None or row.name in wishes.row:
            order = replace(row, seeds=wishes.seeds or row.seeds)
            if wishes.backend == "physics":
                order = replace(order, bar=min(order.bar, 0.95))
            usual = Order(
                row.mission, wishes.backend, pipe=row.pipe, detector=wishes.detector,
                start_jitter_m=wishes.start_jitter / 1000, friction_jitter=0.20,
                diameter_jitter_m=0.002, defects=row.defects,
            )  # fmt: skip
            good &= _show(order, usual, wishes.workers)
    return 0 if good else 1


def _show(row: Row, usual: Order, workers: int | None) -> bool:
    """Run a row and print what came of it; return whether it is good enough."""
    began = perf_counter()
    orders = [replace(usual, seed=seed) for seed in range(row.seeds)]
    outcomes = run_all(orders, workers=workers, motors=row.motors)
    snapshots = _snapshots() if row.forward and row.snapshots else []
    verdicts = [judge(outcome, row, snapshots) for outcome in outcomes]
    passed = sum(verdict.passed for verdict in verdicts)
    counted = sum(verdict.counts for verdict in verdicts)
    times = sorted(o.time_s for o, v in zip(outcomes, verdicts, strict=True) if v.passed) or [0.0]
    also = f", {counted - passed} end holding" if row.holding else ""
    bar = f"bar {row.bar:.0%}" if row.bar else "no bar"
    print(
        f"{row.name:17} {passed / row.seeds:7.2%} of {row.seeds} passed{also} ({bar}), in"
        f" {times[0]:.1f}/{times[len(times) // 2]:.1f}/{times[-1]:.1f} s (least/median/most),"
        f" measured in {perf_counter() - began:.0f} s",
        flush=True,
    )
    _show_failures(verdicts)
    return counted >= row.bar * row.seeds and not any(v.false for v in verdicts if row.bar)


def _show_failures(verdicts: Sequence[Verdict]) -> None:
    causes = Counter(verdict.why for verdict in verdicts if not verdict.passed)
    for why, count in causes.most_common():
        seeds = ", ".join(str(v.seed) for v in verdicts if not v.passed and v.why == why)
        print(f"    {count:4} × {why} (seeds {seeds})", flush=True)


def judge(outcome: Outcome, row: Row, snapshots: list[tuple[str, ...]]) -> Verdict:
    """Return how a run ended, by what is true of the robot."""
    why = _failure(outcome, row, snapshots)
    false = bool(why) and outcome.outcome == "succeeded"
    held = bool(why) and not false and row.holding and _holds(outcome)
    if why and row.holding and not held and not false:
        why = f"NOT HELD: {why}"
    return Verdict(outcome.seed, not why, not why or held, false, why)


def _holds(outcome: Outcome) -> bool:
    """Whether the robot stands in the pipe, with a clamp that bears."""
    gripped = max(map(abs, outcome.torques), default=0.0) >= GRIPPED_NM
    stays = outcome.slid_m < STAYS_M and not outcome.gone
    return outcome.held_at_end and gripped and outcome.stopped and stays


def _failure(outcome: Outcome, row: Row, snapshots: list[tuple[str, ...]]) -> str:
    """Return why the run did not pass; empty when it did."""
    if outcome.outcome != "succeeded":
        return outcome.message
    beyond = [arc > CROSSING_M if row.forward else arc < CROSSING_M for arc in outcome.arcs_m]
    if not all(beyond) or outcome.gone:
        return f"{FALSE}, with {beyond.count(False)} wheels not beyond the crossing"
    if list(outcome.arcs_m) != sorted(outcome.arcs_m, reverse=True):
        return f"{FALSE}, with a part folded back on itself"
    missing = _missing(outcome.states, snapshots)
    return f"{missing} snapshots of fig. 6-9 did not appear in order" if missing else ""


def _missing(states: Iterable[tuple[str, ...]], snapshots: list[tuple[str, ...]]) -> int:
    """How many snapshots are left when the states have been walked through once."""
    left = list(snapshots)
    for state in states:
        if left and state == left[0]:
            left.pop(0)
    return len(left)


def _snapshots() -> list[tuple[str, ...]]:
    # `Off` and `On` are words here, not truth values: read every scalar as text.
    rows = yaml.load(SNAPSHOTS.read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
    return [tuple(row) for row in rows.values()]


if __name__ == "__main__":
    sys.exit(main())
