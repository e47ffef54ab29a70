"""What it costs to keep a run: speed, processor time, size.

    python -m benchmarks.recording

The same mission, up and down a straight pipe for ten minutes, with and without a recording; as
fast as it goes, and for a while in real time, where the share of one processor counts. Processor
time is that of the whole process, with the thread that writes.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from pathlib import Path
from statistics import median
from time import perf_counter, process_time

from pirate_sm.cli.recording import RecordingWishes, recorded
from pirate_sm.runtime.companions import FirstChoice
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.runtime.stopping import Stop, StopRequests
from pirate_sm.wiring import Order, prepare

MISSION = Path(__file__).with_name("ten_minutes.yaml")
REPEATS = 5
REAL_TIME_S = 20.0
TEN_MINUTES_S = 600.0


@dataclass
class Cost:
    """What a run took.

    Attributes:
        wall_s: On the wall.
        processor_s: On processors.
        run_s: Mission time.
        size: Of the recording, bytes; ``beginning`` of what does not grow with time.
    """

    wall_s: float
    processor_s: float
    run_s: float
    size: int
    beginning: int

    def size_of(self, run_s: float) -> float:
        """How large a recording of so much mission time is, bytes."""
        return self.beginning + (self.size - self.beginning) * run_s / self.run_s


class _Until:
    """Asks a run to stop at a mission time."""

    listening = False

    def __init__(self, at_s: float, requests: StopRequests) -> None:
        self.due_s = at_s
        self._requests = requests

    def react(self, effects: object, now_s: float) -> None:
        """Nothing."""

    def speak(self, now_s: float) -> tuple[()]:
        """The stop is asked for."""
        self.due_s = inf
        self._requests.ask(Stop("measured", 0))
        return ()


def measure_recording() -> None:
    """Costs with and without a recording are printed."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _run(None, inf, inf)
        # In turn, so that what else goes on meanwhile meets both.
        pairs = [
            (_run(None, inf, inf), _run(folder / f"{n}.mcap", inf, inf)) for n in range(REPEATS)
        ]
        plain, real = _run(None, 1.0, REAL_TIME_S), _run(folder / "real.mcap", 1.0, REAL_TIME_S)
    without, kept = ([pair[each] for pair in pairs] for each in (0, 1))
    before, after = (_median(costs, lambda c: c.run_s / c.wall_s) for costs in (without, kept))
    lost = median(1 - pair[0].wall_s / pair[1].wall_s for pair in pairs)
    print(f"    full speed: {before:,.0f} × real time without, {after:,.0f} × with a recording")
    print(f"        costs {lost:.0%} of the speed (median of {REPEATS} pairs)")
    before, after = (_median(costs, lambda c: c.processor_s) for costs in (without, kept))
    share = f"{1 - before / after:.0%} of it is the recording's"
    print(f"        processor time {before:.2f} s without, {after:.2f} s with, {share}")
    size = _median(kept, lambda c: c.size_of(TEN_MINUTES_S))
    print(f"        ten minutes: {size / 1e6:.1f} MB")
    print(f"    real time, {REAL_TIME_S:.0f} s: {_share(plain)} without, {_share(real)} with")
    print(f"        ten minutes: {real.size_of(TEN_MINUTES_S) / 1e6:.1f} MB")


def _share(cost: Cost) -> str:
    return f"{cost.processor_s / cost.wall_s:.2%} of a processor"


def _median(costs: list[Cost], of: Callable[[Cost], float]) -> float:
    return median(map(of, costs))


def _run(path: Path | None, factor: float, until_s: float) -> Cost:
    prepared = prepare(Order(str(MISSION)))
    wishes = RecordingWishes(record=str(path) if path else None, off=path is None)
    requests = StopRequests()
    began_s, spent_s = perf_counter(), process_time()
    with recorded(prepared, wishes, factor) as kept:
        run = MissionRun(
            prepared.engine, prepared.backend, tap=kept.tap, requests=requests, factor=factor,
            companions=(
                *prepared.companions, *kept.companions, FirstChoice(), _Until(until_s, requests),
            ),
        )  # fmt: skip
        kept.follow(run)
        beginning = path.stat().st_size if path else 0
        result = run.execute()
    wall_s, processor_s = perf_counter() - began_s, process_time() - spent_s
    size = path.stat().st_size if path else 0
    return Cost(wall_s, processor_s, result.now_s, size, beginning)


if __name__ == "__main__":
    measure_recording()
    sys.exit(0)
