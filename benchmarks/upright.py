"""How a robot holds in an upright pipe: clamped as friction asks for, and by a fixed torque.

    python -m benchmarks.upright [--seeds 60] [--seed 0] [--loss 20] [--row careful]

The robot of 0.79 kg heads upwards with even seeds and downwards with odd ones. Each seed draws the
kinetic friction from 0.2 to 0.7; static friction is 1.3 times as much. Somewhere on the way there
is a patch, 0.2 m long, with half of that. At first outer wheels turn
faster than the others and slip, then the robot drives forth and back, while a simulated ruler
measures its speed. In between it settles for as long as a grip needs to be lowered.

The same seeds run in the simulator and over a line to the emulated bay that loses a share of all
frames each way.

A robot slides where it moves downhill beyond what any of its wheels rolls, and falls where that is
more than 50 mm. It is dragged where it moves beyond what the median of its wheels rolls: outer
wheels that turn faster than the others drag it along. Clamp torques are those that the sensors of
the apexes show, while nothing is known of the friction of their part, and once it is.

The row `little` are pipes of too little friction, 0.06 to 0.12: 700 mNm at each apex bear the
weight there with a margin of less than 1.25, so `grip.exhausted` must come before a robot slides.
A tenth of the seeds are run in it.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from math import isnan
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from benchmarks.upright_trial import KINETIC, TOO_LITTLE, Trial, try_out, written

ROWS = {
    "careful": ("careful", KINETIC),
    "fixed": ("fixed", KINETIC),
    "little": ("careful", TOO_LITTLE),
}


def main() -> int:
    """Print what came of each control; return 1 when a careful robot fell."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0, help="the first one")
    parser.add_argument("--loss", type=float, default=20, help="in per cent, each way")
    parser.add_argument("--row", action="append", choices=ROWS, help="all rows by default")
    parser.add_argument("--only", choices=("bay", "simulator"), help="both by default")
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    wishes = parser.parse_args()
    falls = 0
    with (
        TemporaryDirectory() as folder,
        ProcessPoolExecutor(wishes.workers, mp_context=get_context("spawn")) as pool,
    ):
        for loss in (wishes.loss / 100, None):
            where = "simulator" if loss is None else f"bay, {loss:.0%} of frames lost each way"
            if wishes.only and not where.startswith(wishes.only):
                continue
            for row in wishes.row or ROWS:
                control, kinetic = ROWS[row]
                mission = str(written(Path(folder), control))
                trial = partial(try_out, mission, loss, kinetic=kinetic)
                count = wishes.seeds if kinetic == KINETIC else max(1, wishes.seeds // 10)
                found = list(pool.map(trial, range(wishes.seed, wishes.seed + count)))
                falls += sum(each.fell for each in found if row == "careful")
                _show(f"{row}, {where}", found)
    return 1 if falls else 0


def _show(what: str, trials: Sequence[Trial]) -> None:
    fallen = [trial for trial in trials if trial.fell]
    slides = sorted(trial.slid_m * 1000 for trial in trials)
    dragged = max(trial.dragged_m * 1000 for trial in trials)
    print(
        f"{what}: {len(fallen)} of {len(trials)} fell; slid {median(slides):.1f} mm in the"
        f" median, {slides[-1]:.1f} mm at most, dragged {dragged:.1f} mm at most"
    )
    for down in (False, True):
        mine = [trial for trial in trials if trial.heads_down == down]
        fell = [f"{trial.seed} ({trial.kinetic:.2f})" for trial in mine if trial.fell]
        way = "downwards" if down else "upwards"
        print(f"    heading {way}: fell {', '.join(fell) or 'never'}, of {len(mine)}")
    _show_torques(trials)
    before = [trial.exhausted_m * 1000 for trial in trials if not isnan(trial.exhausted_m)]
    if before:
        print(f"    grip.exhausted in {len(before)}, slid {max(before):.1f} mm at most until then")
    for words, count in Counter(trial.ended for trial in trials).most_common():
        print(f"    {count:4} × {words}", flush=True)


def _show_torques(trials: Sequence[Trial]) -> None:
    for what, values in (
        ("unknown", [nm for trial in trials for nm in trial.unknown_nm]),
        ("known", [nm for trial in trials for nm in trial.known_nm]),
    ):
        if values:
            print(f"    clamp torque with friction {what}: {median(values) * 1000:.0f} mNm, median")
    near = [nm for trial in trials if abs(trial.kinetic - 0.5) < 0.05 for nm in trial.known_nm]
    if near:
        print(f"    ... known to be 0.45 to 0.55: {median(near) * 1000:.0f} mNm, median")


if __name__ == "__main__":
    sys.exit(main())
