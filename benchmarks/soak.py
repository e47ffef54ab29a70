"""Driver, guardian's logic, a bad link and the emulated bay in one process and in virtual time.

    python -m benchmarks.soak [--commands 100000] [--missions 100] [--seed 0]

Commands: arrays of setpoints, one after the other, over a link that loses 20 % of all frames each
way and changes 1 % of all bytes, against the thesis's scheme on the same link (each message sent
twice, 100 ms apart, echoes not looked at). Missions: the bend over that link, without and with
random restarts of the firmware. A seed replays a run exactly.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise
from multiprocessing import get_context
from os import cpu_count
from pathlib import Path
from random import Random
from statistics import median, quantiles
from time import perf_counter

from pirate_sm.backends.pico.assembly import read_plan
from pirate_sm.backends.pico.backend import SerialBackend
from pirate_sm.backends.pico.framing import encode
from pirate_sm.backends.pico.plan import Plan
from pirate_sm.backends.pico.virtual_port import VirtualPort
from pirate_sm.bay.switches import Switches
from pirate_sm.bay.texts import message_texts
from pirate_sm.bay.virtual import VirtualBay
from pirate_sm.engine.engine import Engine
from pirate_sm.loading import library
from pirate_sm.loading.mission import LoadedMission, load_mission
from pirate_sm.model.events import SubmitResult
from pirate_sm.runtime.companions import FirstChoice
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.runtime.outcome import Result

LOSS, CORRUPTION = 0.20, 0.01
MISSION = "mitre_bend"
BATCH = 2_000
"""Commands of one seed."""

TWICE_AFTER_S = 0.1
DIGITS = 1_000
FAR_S = 1e6


@dataclass
class Tally:
    """What came of many commands.

    Attributes:
        latencies_s: From submission to acceptance.
        faults: What must never happen, in words.
        damaged_s: How long each array that was applied damaged stayed in force.
    """

    commands: int = 0
    virtual_s: float = 0.0
    latencies_s: list[float] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    statuses: Counter[str] = field(default_factory=Counter)
    damaged_s: list[float] = field(default_factory=list)
    round_trips_s: list[float] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        """The other's commands are counted in."""
        self.commands += other.commands
        self.virtual_s += other.virtual_s
        self.latencies_s += other.latencies_s
        self.faults += other.faults
        self.statuses += other.statuses
        self.damaged_s += other.damaged_s
        self.round_trips_s += other.round_trips_s


@dataclass(frozen=True)
class Ride:
    """One mission over the link.

    Attributes:
        safe: Whether every wheel's setpoint was zero in the bay at the end.
    """

    seed: int
    result: Result
    safe: bool
    faults: tuple[str, ...]


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
        seeds = range(wishes.seed, wishes.seed + -(-wishes.commands // BATCH))
        good = _tell_commands(pool.map(commands, seeds), cpu_count() or 1)
        _tell_twice(pool.map(twice, seeds[: max(1, len(seeds) // 10)]))
        for name, reset_every_s in (("without restarts", 0.0), ("with restarts", 20.0)):
            seeds = range(wishes.seed, wishes.seed + wishes.missions)
            rides = pool.map(ride, seeds, [reset_every_s] * len(seeds))
            good &= _tell_rides(name, list(rides), reset_every_s)
    return 0 if good else 1


# --- commands ---------------------------------------------------------------------------------


def commands(seed: int) -> Tally:
    """A batch of commands has been brought over the link, and watched in the bay."""
    bay, plan = _bay(seed, "straight", Switches(LOSS, LOSS, corruption=CORRUPTION))
    backend = SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))
    backend.open()
    tally, random = Tally(commands=BATCH), Random(seed)
    fates: dict[int, str] = {}
    told_s: dict[int, float] = {}
    sent_s: dict[int, float] = {}
    number, now_s = 0, 0.0
    while number < BATCH or len(fates) < number:
        if number < BATCH and (number == len(fates) or random.random() < 0.002):
            number += 1
            sent_s[number] = now_s
            backend.submit(number, _values(number, len(plan.slots)))
        now_s, events = backend.advance(now_s + FAR_S)
        for event in events:
            if not isinstance(event, SubmitResult):
                continue
            if event.status == "unknown" and event.setpoint_id == number:
                backend.submit(number, _values(number, len(plan.slots)))
                continue  # as the engine does
            if event.setpoint_id in fates:
                tally.faults.append(f"seed {seed}: two fates of array {event.setpoint_id}")
            fates[event.setpoint_id] = event.status
            told_s[event.setpoint_id] = backend.port.now()
            if event.status == "accepted":
                tally.latencies_s.append(now_s - sent_s[event.setpoint_id])
    backend.close()
    tally.statuses.update(fates.values())
    tally.virtual_s = backend.port.now()
    tally.round_trips_s = list(backend.exchange.link.round_trips)
    _watch(bay, fates, told_s, tally, f"seed {seed}")
    return tally


def _watch(
    bay: VirtualBay, fates: dict[int, str], told_s: dict[int, float], tally: Tally, name: str
) -> None:
    """What the bay applied agrees with what was told of it."""
    applied = [record for record in bay.records if record.event == "applied"]
    last, seen = 0, dict[int, float]()
    for record in applied:
        number = _number(record.counts)
        if number is None:
            continue
        seen[number] = record.at_s
        if number < last:
            tally.faults.append(f"{name}: array {number} was applied after {last}")
        last = max(last, number)
    for number, fate in fates.items():
        if fate == "accepted" and number not in seen:
            tally.faults.append(f"{name}: array {number} was accepted and never applied")
        if fate == "superseded" and seen.get(number, 0.0) > told_s[number]:
            tally.faults.append(f"{name}: array {number} was superseded and applied")
    if applied and _number(applied[-1].counts) is None:
        tally.faults.append(f"{name}: the last array is a damaged one")
    for one, next_ in pairwise(applied):
        if _number(one.counts) is None:
            tally.damaged_s.append(next_.at_s - one.at_s)


def _values(number: int, slots: int) -> tuple[float, ...]:
    """An array that says its number, twice, in slots that drive nothing far."""
    high, low = divmod(number, DIGITS)
    digits = [low, high, low, high]
    return (*(digit / DIGITS for digit in digits), *(0.0,) * (slots - len(digits)))


def _number(counts: tuple[int, ...]) -> int | None:
    """The number that an array says; None where it has been damaged."""
    low, high = counts[:2]
    whole = counts[2:4] == (low, high) and not any(counts[4:])
    return high * DIGITS + low if whole and low >= 0 and high >= 0 else None


def twice(seed: int) -> Tally:
    """The same with each message written twice and no echo awaited before the next."""
    bay, plan = _bay(seed, "straight", Switches(LOSS, LOSS, corruption=CORRUPTION))
    port = VirtualPort(bay)
    backend = SerialBackend(plan, port)
    backend.open()
    bay.records.clear()
    tally, slots = Tally(commands=BATCH), len(plan.slots)
    for number in range(1, BATCH + 1):
        began_s = port.now()
        counts = [round(value * DIGITS) for value in _values(number, slots)]
        for copy in range(2):
            port.write(encode(100, plan.messages.setpoints.pack(2 * number + copy, counts)))
            port.wait(began_s + (copy + 1) * TWICE_AFTER_S)
        echoed = [r for r in bay.records if r.event == "applied" and _number(r.counts) == number]
        if echoed:
            tally.latencies_s.append(echoed[0].at_s - began_s)
        tally.statuses["applied" if echoed else "lost"] += 1
        bay.records.clear()
    return tally


# --- missions ---------------------------------------------------------------------------------


def ride(seed: int, reset_every_s: float) -> Ride:
    """The mission has been run over the link to its end."""
    switches = Switches(LOSS, LOSS, corruption=CORRUPTION, reset_every_s=reset_every_s)
    loaded = _loaded()
    bay, plan = _bay(seed, MISSION, switches)
    backend = SerialBackend(plan, VirtualPort(bay, plan.serial.heartbeat_within))
    from pirate_sm.detectors.choice import detecting

    detector = detecting(
        None, usual="odometry", profile=loaded.loaded_robot.profile, robot=loaded.robot,
        pipe=loaded.pipe,
    )  # fmt: skip
    engine = Engine(loaded.robot, loaded.program, nominal=False)
    companions = (*detector.companions, FirstChoice())
    result = MissionRun(engine, backend, companions=companions).execute()
    zeros = loaded.robot.safe_zero
    last = bay.last_applied
    safe = last is None or not any(last.counts[slot] for slot in zeros)
    return Ride(seed, result, safe, tuple(record.detail for record in bay.records if record.detail))


def _loaded() -> LoadedMission:
    return load_mission(library.find_mission(MISSION))


def _bay(seed: int, where: str, switches: Switches) -> tuple[VirtualBay, Plan]:
    loaded = _loaded()
    robot, folder = loaded.loaded_robot, loaded.loaded_robot.folder
    assert loaded.pipe is not None
    plan = read_plan(Path(folder), robot.profile, loaded.robot)
    texts = message_texts(folder, robot.profile)
    return VirtualBay(robot.profile, loaded.pipe, texts, switches, seed), plan


# --- telling ----------------------------------------------------------------------------------


def _tell_commands(tallies: Iterator[Tally], processes: int) -> bool:
    total, began = Tally(), perf_counter()
    for tally in tallies:
        total.add(tally)
    took_s = perf_counter() - began
    speed = total.virtual_s / took_s
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
        f"    applied damaged: {len(total.damaged_s)}, corrected after at most "
        f"{max(total.damaged_s, default=0.0) * 1000:.0f} ms"
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
        f"{_spread('others applied after', total.latencies_s)}"
    )


def _tell_rides(name: str, rides: list[Ride], reset_every_s: float) -> bool:
    outcomes = Counter(ride.result.ended.outcome for ride in rides)
    share = outcomes["succeeded"] / len(rides)
    unsafe = [ride.seed for ride in rides if not ride.safe]
    print(f"{len(rides)} missions {name}: {share:.1%} succeeded; wheels left driven: {len(unsafe)}")
    reasons = Counter(
        ride.result.ended.message for ride in rides if ride.result.ended.outcome != "succeeded"
    )
    for reason, count in reasons.most_common(8):
        seeds = [r.seed for r in rides if r.result.ended.message == reason][:5]
        print(f"    {count:4} × {reason} (seeds {', '.join(map(str, seeds))})")
    return not unsafe and (reset_every_s > 0 or share >= 0.99)


def _spread(what: str, values_s: list[float]) -> str:
    if len(values_s) < 2:
        return f"{what}: nothing measured"
    p99 = quantiles(values_s, n=100)[98]
    return f"{what} {median(values_s) * 1000:.0f}/{p99 * 1000:.0f} ms (median/99th percentile)"


if __name__ == "__main__":
    sys.exit(main())
