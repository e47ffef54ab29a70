"""Sensors are held against what a body and its motors can do; what cannot be is not passed on.

A value that its joint cannot have reached is held back for at most two readings, with the last
good one in its place: a spike is over by then and has not been seen, while a value that goes on
the same way is a trend and passes at once, and one that stays passes as what it is.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isnan, nan
from typing import NamedTuple

from pirate_sm.model.events import FaultReport, SensorFrame

STUCK = "sensor.stuck"
SPIKING = "sensor.spiking"
RANGE = "sensor.range"
UNASKED = "motion.unasked"

_HELD_BACK = 2
_SPIKES = 5
_SPIKES_WITHIN_S = 10.0
_REFERENCE_FOR_S = 1.0
_STUCK_AFTER_S = 1.5
_UNLOADED = 0.4
_SETTLED_AFTER_S = 1.5
_SEEN_TWICE = 2
"""A motion is seen by two readings: a single one may be damage that the line's sum let through."""


class Watched(NamedTuple):
    """What is known beforehand of one channel, in its raw counts.

    Attributes:
        place: In the frame of its board.
        name: For people.
        low: Least value that it can have; ``high`` the largest.
        rate: Fastest change, counts per second; ``slack`` is allowed besides at any time.
        slot: Index of the setpoint that moves what it measures; -1 without.
        joint: Whether it is the angle of something that holds its place when not driven.
        wheel: Whether it is the angle of a wheel.
        moved: A change that is a motion.
        least_duty: Below it, what it measures may stand still though driven.
        load: Place of the current of the same motor; -1 without. ``full_load``: its counts when
            the motor is stalled at full duty.
    """

    place: int
    name: str
    low: float = -inf
    high: float = inf
    rate: float = inf
    slack: float = 0.0
    slot: int = -1
    joint: bool = False
    wheel: bool = False
    moved: float = inf
    least_duty: float = inf
    load: int = -1
    full_load: float = 0.0


@dataclass
class _Channel:
    """What has come from one channel.

    Attributes:
        good: The last value believed; ``held`` those since that were not.
        running: Direction of a trend that is faster than its motor; 0 without.
        same: What it showed while driven without load, since ``same_s``.
        rest: Where it came to rest, once ``proven`` by a second reading; ``away``: how many
            readings in a row were far from there.
    """

    good: float = nan
    good_s: float = -inf
    held: list[float] = field(default_factory=list)
    running: float = 0.0
    spikes: deque[float] = field(default_factory=lambda: deque(maxlen=_SPIKES))
    spiking_s: float = -inf
    outside: bool = False
    same: float = nan
    same_s: float = inf
    stuck: bool = False
    rest: float = nan
    proven: bool = False
    away: int = 0
    unasked: bool = False


class Supervision:
    """Looks at every frame before the engine does.

    Args:
        boards: What is watched of each board.
        wheels: Slots that drive wheels.
        frame_s: The least time between two reports of one board, however close together they are
            read after this program has stood still for a moment.

    Attributes:
        hidden: How many spikes have been hidden.
    """

    def __init__(
        self,
        boards: Mapping[int, Sequence[Watched]],
        wheels: Sequence[int],
        frame_s: float = 0.0,
    ) -> None:
        self._boards = {
            board: [(watched, _Channel()) for watched in channels]
            for board, channels in boards.items()
        }
        self._wheels = tuple(wheels)
        self._frame_s = frame_s
        self._setpoints: tuple[float, ...] = ()
        self._since_s = inf
        self.hidden = 0

    def actuated(self, setpoints: tuple[float, ...], now: float) -> None:
        """These setpoints may be in force from now on."""
        if setpoints != self._setpoints:
            self._setpoints, self._since_s = setpoints, now
            for channels in self._boards.values():
                for _, channel in channels:
                    channel.rest, channel.unasked = nan, False

    def forget(self) -> None:
        """Whatever comes next is believed: counters may have begun anew."""
        for channels in self._boards.values():
            for _, channel in channels:
                channel.good, channel.rest, channel.same = nan, nan, nan
                channel.held.clear()

    def look(self, frame: SensorFrame, now: float) -> tuple[SensorFrame, list[FaultReport]]:
        """The frame as it may be believed, and what is wrong with its sensors."""
        faults: list[FaultReport] = []
        values = list(frame.values)
        for watched, channel in self._boards.get(frame.board, ()):
            raw = values[watched.place]
            if isnan(raw):
                channel.held.clear()
                continue
            values[watched.place] = self._believe(watched, channel, raw, now, faults)
            if self._setpoints and watched.slot >= 0:
                self._stuck(watched, channel, raw, frame, now, faults)
                self._unasked(watched, channel, now, faults)
        return SensorFrame(frame.board, tuple(values)), faults

    def _believe(
        self, watched: Watched, channel: _Channel, raw: float, now: float, faults: list[FaultReport]
    ) -> float:
        inside = watched.low <= raw <= watched.high
        if inside and self._plausible(watched, channel, raw, now):
            if channel.held:
                self.hidden += 1
                self._spiked(watched, channel, now, faults)
            channel.held.clear()
            channel.good, channel.good_s, channel.outside = raw, now, False
            return raw
        channel.held.append(raw)
        if len(channel.held) <= _HELD_BACK and not isnan(channel.good):
            return channel.good
        if inside:
            channel.held.clear()
            channel.good, channel.good_s, channel.outside = raw, now, False
            return raw
        if not channel.outside and len(channel.held) > _HELD_BACK:
            channel.outside = True
            where = f"{raw:g} counts, outside {watched.low:.0f} to {watched.high:.0f}"
            faults.append(FaultReport(RANGE, f"{watched.name} reports {where}"))
        return nan

    def _plausible(self, watched: Watched, channel: _Channel, raw: float, now: float) -> bool:
        elapsed_s = now - channel.good_s
        if isnan(channel.good) or elapsed_s > _REFERENCE_FOR_S or watched.rate == inf:
            return True
        elapsed_s = max(elapsed_s, self._frame_s)
        step = raw - channel.good
        if abs(step) <= watched.rate * elapsed_s + watched.slack:
            channel.running = 0.0
            return True
        if channel.held:
            before = channel.held[-1] - channel.good
            if before * step > 0 and abs(step) - abs(before) > watched.slack / 2:
                channel.running = step
                channel.held.clear()  # it was no spike
        return channel.running * step > 0

    def _spiked(
        self, watched: Watched, channel: _Channel, now: float, faults: list[FaultReport]
    ) -> None:
        channel.spikes.append(now)
        often = len(channel.spikes) == _SPIKES and now - channel.spikes[0] <= _SPIKES_WITHIN_S
        if often and now - channel.spiking_s > _SPIKES_WITHIN_S:
            channel.spiking_s = now
            within_s = now - channel.spikes[0]
            message = f"{watched.name} has spiked {_SPIKES} times in {within_s:.1f} s"
            faults.append(FaultReport(SPIKING, message))

    def _stuck(
        self,
        watched: Watched,
        channel: _Channel,
        raw: float,
        frame: SensorFrame,
        now: float,
        faults: list[FaultReport],
    ) -> None:
        """A motor that is driven and bears no load turns; a sensor that shows nothing is stuck."""
        if watched.load < 0:
            return
        duty = abs(self._setpoints[watched.slot])
        load = abs(frame.values[watched.load])
        free = duty > watched.least_duty and load < _UNLOADED * duty * watched.full_load
        if not free or raw != channel.same:
            channel.same_s, channel.stuck = (now if free else inf), channel.stuck and free
            channel.same = raw
        elif now - channel.same_s >= _STUCK_AFTER_S and not channel.stuck:
            channel.stuck = True
            message = (
                f"{watched.name} has shown the same for {_STUCK_AFTER_S:g} s while its motor is "
                "driven and bears no load: the sensor is stuck, or the motor gets no current"
            )
            faults.append(FaultReport(STUCK, message))

    def _unasked(
        self, watched: Watched, channel: _Channel, now: float, faults: list[FaultReport]
    ) -> None:
        """With every wheel at rest and nothing new asked for, nothing moves far."""
        if not (watched.joint or watched.wheel) or self._setpoints[watched.slot] != 0:
            return
        still = now - self._since_s >= _SETTLED_AFTER_S
        if not still or any(self._setpoints[slot] for slot in self._wheels):
            channel.rest = nan
        elif isnan(channel.rest):
            channel.rest, channel.proven, channel.away = channel.good, False, 0
        elif abs(channel.good - channel.rest) <= watched.moved:
            channel.proven, channel.away = True, 0
        elif not channel.proven:
            channel.rest, channel.proven = channel.good, True
        elif channel.away + 1 < _SEEN_TWICE:
            channel.away += 1
        elif not channel.unasked:
            channel.unasked = True
            message = f"{watched.name} moves though nothing was asked of its motor"
            faults.append(FaultReport(UNASKED, message))
