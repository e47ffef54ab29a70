"""Driver, guardian's logic, a bad link and the emulated bay in one process and in virtual time.

    python -m benchmarks.soak [--commands 100000] [--missions 100] [--seed 0]

Commands: arrays of setpoints, one after the other, over a link that loses 20 % of all frames each
way and changes 1 % of all bytes, against the thesis's scheme on the same link (each message sent
twice, 100 ms apart, echoes not looked at). Missions: the bend over that link, next to the same
seeds on a line that loses nothing, and with random restarts of the firmware. A seed replays a run
exactly.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from os import cpu_count
from statistics import median, quantiles
from time import perf_counter

from benchmarks.arrays import (
    BATCH,
    CORRUPTION,
    LOSS,
    Tally,
    bay_of,
    commands,
    loaded_mission,
    twice,
)
from pirate_sm.core.engine import Engine
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.detectors.registry import Asked, detecting
from pirate_sm.running.runtime.backend_links import Holder
from pirate_sm.running.runtime.ending import Result
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.firmware import Record
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

UNHEARD_S = 0.4
"""A silence that is shorter is none."""

STAND_S, SLID_M = 2.0, 0.02
"""So long after the end the robot may not have come further."""


@dataclass(frozen=True)
class Ride:
    """One mission over the link.

    Attributes:
        safe: Whether every wheel's setpoint was zero in the bay at the end.
        resets: How often the firmware started again by itself before the end.
        wrong: What was not as it must be after restarts, in words; empty where all was.
        trips: How often the firmware's dead man's switch tripped before the end.
    """

    seed: int
    result: Result
    safe: bool
    faults: tuple[str, ...]
    resets: int
    wrong: str
    trips: int


def main() -> int:
    """What was measured is printed; 1 when something is not as it must be."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--commands", type=int, default=100_000)
    parser.add_argument("--missions", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    wishes = parser.parse_args()
    context = get_context("spawn")
    with ProcessPoolExecutor(cpu_count() or 1, mp_context=context) as pool:
        count = min(wishes.commands, BATCH)
        seeds = range(wishes.seed, wishes.seed + -(-wishes.commands // count))
        good = _tell_commands(pool.map(partial(commands, count=count), seeds), cpu_count() or 1)
        seeds = seeds[: max(1, len(seeds) // 10)]
        _tell_twice(pool.map(partial(twice, count=count), seeds))
        seeds = range(wishes.seed, wishes.seed + wishes.missions)
        clean = list(pool.map(ride, seeds, [0.0] * len(seeds), [False] * len(seeds)))
        for name, reset_every_s in (("without restarts", 0.0), ("with restarts", 20.0)):
            rides = list(pool.map(ride, seeds, [reset_every_s] * len(seeds)))
            good &= _tell_rides(name, rides, reset_every_s)
            if not reset_every_s:
                _tell_clean(rides, clean)
    return 0 if good else 1


# --- missions ---------------------------------------------------------------------------------


def ride(seed: int, reset_every_s: float, bad: bool = True) -> Ride:
    """The mission has been run over the link to its end, a bad one or one that loses nothing."""
    switches = Switches(LOSS, LOSS, corruption=CORRUPTION, reset_every_s=reset_every_s)
    switches = switches if bad else Switches()
    loaded = loaded_mission()
    bay, plan = bay_of(seed, switches)
    backend = SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))
    asked = Asked(loaded.loaded_robot.profile, loaded.robot, loaded.pipe)
    detector = detecting(None, "odometry", asked)
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    holder = Holder(backend.hold)
    companions = (holder, *detector.companions, FirstChoice())
    run = MissionRun(engine, backend, companions=companions)
    result = run.execute()
    trips = sum(record.event == "tripped" for record in bay.records)
    zeros = loaded.robot.safe_zero
    last = bay.last_applied
    safe = last is None or not any(last.counts[slot] for slot in zeros)
    details = tuple(record.detail for record in bay.records if record.detail)
    resets = sum(record.event == "reset" for record in bay.records) - 1  # one when it was opened
    wrong = _reason(result, resets) or _stand(run, engine, plan, bay, backend.port.now())
    return Ride(seed, result, safe, details, resets, wrong, trips)


def _reason(result: Result, resets: int) -> str:
    """What is wrong with why a mission with restarts of the firmware ended."""
    ended = result.ended
    if "not confirmed" in ended.message:
        return "the safe state is not confirmed"
    if ended.outcome == "succeeded":
        return ""
    if not resets:
        return "it failed although nothing started again"
    return "" if ended.message.startswith("firmware.reset: ") else "it ended for another reason"


def _stand(run: MissionRun, engine: Engine, plan: LinkPlan, bay: VirtualBay, now_s: float) -> str:
    """What is wrong with how the robot stands at the end, in truth."""
    last = bay.last_applied
    if last is None or run.state is None:
        return ""
    pairs = zip(engine.safe_values(run.state), plan.slots, strict=True)
    if last.counts != tuple(round(value / slot.resolution) for value, slot in pairs):
        return "another array than the safe one is in force"
    reset, applied = _last(bay, "reset"), _last(bay, "applied")
    if reset.at_s > applied.at_s:  # what comes when the safe array is confirmed is not heard of
        return "a restart has undone it" if now_s - reset.at_s > UNHEARD_S else ""
    known, ended = len(bay.records), bay.truth
    bay.advance(now_s + STAND_S)
    if any(record.event == "reset" for record in bay.records[known:]):
        return ""  # nobody was there to say anything to it any more
    slid_m = abs(bay.truth.distance_m - ended.distance_m)
    return f"it slid by {slid_m * 1000:.0f} mm" if slid_m > SLID_M or bay.truth.gone else ""


def _last(bay: VirtualBay, event: str) -> Record:
    """The last such event in the bay."""
    return next(record for record in reversed(bay.records) if record.event == event)


# --- telling ----------------------------------------------------------------------------------


def _tell_commands(tallies: Iterator[Tally], processes: int) -> bool:
    total, began = Tally(), perf_counter()
    for tally in tallies:
        total.add(tally)
    took_s = perf_counter() - began
    speed = total.virtual_s / took_s
    quick = sum(lasted_s <= max(total.round_trips_s) for lasted_s in total.damaged_s)
    print(
        f"{total.commands:,} commands in {total.virtual_s:,.0f} s of the link, "
        f"{speed:,.0f} × real time on {processes} processes; "
        f"loss {LOSS:.0%} each way, {CORRUPTION:.0%} of bytes changed"
    )
    print(f"    fates: {', '.join(f'{n:,} {fate}' for fate, n in total.statuses.most_common())}")
    print(
        f"    {_spread('acceptance after', total.latencies_s)}; "
        f"{_spread('round trip', total.round_trips_s)}"
    )
    print(
        f"    {_spread('in force after', total.applied_s)}\n"
        f"    applied damaged: {len(total.damaged_s)}, {quick} of them for no longer than a round "
        f"trip; written again after at most "
        f"{max(total.rewritten_s, default=0.0) * 1000:.0f} ms, "
        f"{_spread('corrected after', total.damaged_s)}, "
        f"at most {max(total.damaged_s, default=0.0) * 1000:.0f} ms"
    )
    for fault in total.faults[:10]:
        print(f"    WRONG {fault}")
    return not total.faults and speed >= 100


def _tell_twice(tallies: Iterable[Tally]) -> None:
    total = Tally()
    for tally in tallies:
        total.add(tally)
    lost = total.statuses["lost"]
    print(
        f"    sent twice instead: {lost / total.commands:.1%} of {total.commands:,} lost, "
        f"{_spread('others in force after', total.latencies_s)}"
    )


def _tell_rides(name: str, rides: list[Ride], reset_every_s: float) -> bool:
    outcomes = Counter(ride.result.ended.outcome for ride in rides)
    share = outcomes["succeeded"] / len(rides)
    unsafe = [ride.seed for ride in rides if not ride.safe]
    print(f"{len(rides)} missions {name}: {share:.1%} succeeded; wheels left driven: {len(unsafe)}")
    tripped = [ride.trips for ride in rides]
    print(f"    dead man's switch: {sum(tripped)} trips, at most {max(tripped)} in a mission")
    reasons: dict[str, list[int]] = {}
    for ride in rides:
        if ride.result.ended.outcome != "succeeded":
            alike = re.sub(r"\d+\.\d s", "… s", ride.result.ended.message)
            reasons.setdefault(alike, []).append(ride.seed)
    for reason, seeds in sorted(reasons.items(), key=lambda each: -len(each[1]))[:8]:
        first = ", ".join(map(str, seeds[:5]))
        print(f"    {len(seeds):4} × {reason} (seeds {first})")
    if not reset_every_s:
        return not unsafe and share >= 0.99
    resets = sum(ride.resets for ride in rides)
    wrong = [ride for ride in rides if ride.wrong]
    print(f"    {resets} restarts; not as it must be: {len(wrong)}")
    for ride in wrong[:10]:
        print(f"    WRONG seed {ride.seed}: {ride.wrong}: {ride.result.ended.message}")
    return not unsafe and not wrong


def _tell_clean(rides: list[Ride], clean: list[Ride]) -> None:
    """The same seeds on a line that loses nothing: what fails there too is not the link's doing."""
    passed = [one.result.ended.outcome == "succeeded" for one in clean]
    failed = [one.result.ended.outcome != "succeeded" for one in rides]
    both = sum(bad and not good for bad, good in zip(failed, passed, strict=True))
    print(
        f"    the same seeds on a line that loses nothing: {sum(passed) / len(clean):.1%}; "
        f"of {sum(failed)} failures above {both} happen there too"
    )


def _spread(what: str, values_s: list[float]) -> str:
    if len(values_s) < 2:
        return f"{what}: nothing measured"
    p99 = quantiles(values_s, n=100)[98]
    return f"{what} {median(values_s) * 1000:.0f}/{p99 * 1000:.0f} ms (median/99th percentile)"


if __name__ == "__main__":
    sys.exit(main())
