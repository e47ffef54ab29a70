"""Arrays of setpoints over a bad link, one after the other: what became of each, and of damage.

An array says its own number, twice, so that the bay's records tell which one was in force.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from random import Random

from pirate_sm.core import library
from pirate_sm.core.events import SubmitResult
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.robot.backends.serial.assembly import read_plan
from pirate_sm.robot.backends.serial.backend import SerialBackend
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.rosserial.frames import encode
from pirate_sm.running.wiring.backends import start_values
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.node_handle import message_texts
from pirate_sm.simulation.bay.virtual import VirtualBay, VirtualPort

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
        applied_s: From submission to the first time in force, which only the bay knows.
        faults: What must never happen, in words.
        damaged_s: How long each array that was applied damaged stayed in force.
        rewritten_s: How long after that the right one was written again.
    """

    commands: int = 0
    virtual_s: float = 0.0
    latencies_s: list[float] = field(default_factory=list)
    applied_s: list[float] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    statuses: Counter[str] = field(default_factory=Counter)
    damaged_s: list[float] = field(default_factory=list)
    rewritten_s: list[float] = field(default_factory=list)
    round_trips_s: list[float] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        """The other's commands are counted in."""
        self.commands += other.commands
        self.virtual_s += other.virtual_s
        self.latencies_s += other.latencies_s
        self.applied_s += other.applied_s
        self.faults += other.faults
        self.statuses += other.statuses
        self.damaged_s += other.damaged_s
        self.rewritten_s += other.rewritten_s
        self.round_trips_s += other.round_trips_s


def commands(seed: int, count: int = BATCH) -> Tally:
    """So many commands have been brought over the link, and watched in the bay."""
    bay, plan = bay_of(seed, Switches(LOSS, LOSS, corruption=CORRUPTION))
    port = VirtualPort(bay, plan.serial.heartbeat_within)
    backend = SerialBackend(plan, port)
    backend.open()
    began_s = port.now()
    tally, random = Tally(commands=count), Random(seed)
    fates: dict[int, str] = {}
    told_s: dict[int, float] = {}
    sent_s: dict[int, float] = {}
    number, now_s = 0, 0.0
    while number < count or len(fates) < number:
        if number < count and (number == len(fates) or random.random() < 0.002):
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
            told_s[event.setpoint_id] = port.now()
            if event.status == "accepted":
                tally.latencies_s.append(now_s - sent_s[event.setpoint_id])
    backend.close()
    tally.statuses.update(fates.values())
    tally.virtual_s = port.now()
    tally.round_trips_s = list(backend.exchange.link.quality.round_trips)
    seen = _watch(bay, fates, told_s, tally, f"seed {seed}")
    tally.applied_s = [at_s - began_s - sent_s[number] for number, at_s in seen.items()]
    _watch_damage(bay, port, tally, f"seed {seed}")
    return tally


def _watch(
    bay: VirtualBay, fates: dict[int, str], told_s: dict[int, float], tally: Tally, name: str
) -> dict[int, float]:
    """What the bay applied agrees with what was told of it; returns when each array first was."""
    applied = [record for record in bay.records if record.event == "applied"]
    last, first_s, last_s = 0, dict[int, float](), dict[int, float]()
    for record in applied:
        number = _number(record.counts)
        if number is None:
            continue
        first_s.setdefault(number, record.at_s)
        last_s[number] = record.at_s
        if number < last:
            tally.faults.append(f"{name}: array {number} was applied after {last}")
        last = max(last, number)
    for number, fate in fates.items():
        if fate == "accepted" and number not in first_s:
            tally.faults.append(f"{name}: array {number} was accepted and never applied")
        if fate == "superseded" and last_s.get(number, 0.0) > told_s[number]:
            tally.faults.append(f"{name}: array {number} was superseded and applied")
    if applied and _number(applied[-1].counts) is None:
        tally.faults.append(f"{name}: the last array is a damaged one")
    return first_s


def _watch_damage(bay: VirtualBay, port: VirtualPort, tally: Tally, name: str) -> None:
    """After damage the driver has written again within a round trip; the line may lose that too."""
    applied = [record for record in bay.records if record.event == "applied"]
    longest = max(len(data) for _, data in port.written)
    written_s = [at_s for at_s, data in port.written if len(data) == longest]
    for one, next_ in pairwise(applied):
        if _number(one.counts) is not None:
            continue
        after_s = written_s[bisect_right(written_s, one.at_s)] - one.at_s
        tally.damaged_s.append(next_.at_s - one.at_s)
        tally.rewritten_s.append(after_s)
        if after_s > max(tally.round_trips_s):
            tally.faults.append(f"{name}: damage was left for {after_s * 1000:.0f} ms")


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


def twice(seed: int, count: int = BATCH) -> Tally:
    """The same with each message written twice and no echo awaited before the next."""
    bay, plan = bay_of(seed, Switches(LOSS, LOSS, corruption=CORRUPTION))
    port = VirtualPort(bay)
    backend = SerialBackend(plan, port)
    backend.open()
    bay.records.clear()
    tally, slots = Tally(commands=count), len(plan.slots)
    for number in range(1, count + 1):
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


def loaded_mission() -> LoadedMission:
    """The mission that is run, with its robot and pipe."""
    return load_mission(library.find_mission(MISSION))


def bay_of(seed: int, switches: Switches) -> tuple[VirtualBay, LinkPlan]:
    """The emulated bay where that mission starts, and what the driver needs to know of it."""
    return bay_at(loaded_mission(), seed, switches)


def bay_at(loaded: LoadedMission, seed: int, switches: Switches) -> tuple[VirtualBay, LinkPlan]:
    """The emulated bay where a mission starts, and what the driver needs to know of it."""
    robot, folder = loaded.loaded_robot, loaded.loaded_robot.folder
    assert loaded.pipe is not None
    plan = read_plan(Path(folder), robot.profile, loaded.robot)
    texts = message_texts(folder, robot.profile)
    start = start_values(loaded)
    return VirtualBay(robot.profile, loaded.pipe, texts, switches, seed, start), plan
