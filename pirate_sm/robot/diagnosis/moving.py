"""Sends setpoints to a robot whose wheels can turn freely, to test whether it obeys."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from math import isnan, nan

from pirate_sm.robot.backends.serial.link.link_plan import to_counts
from pirate_sm.robot.backends.serial.port import PortLostError
from pirate_sm.robot.diagnosis.facts import MoveFact, TurnFact
from pirate_sm.robot.diagnosis.listening import Listening

ECHOES = 10
DUTY = 0.3
TURN_FOR_S = 0.6
TURNED_RAD = 0.1
"""A driven wheel turns much farther than this at this duty."""

BEARS = 0.4
"""A joint holds something whose motor draws this share of its stall current, or that bears this
share of its stall torque, as a worm gear does also without any current [assumed]."""

_ANSWER_WITHIN_S = 2.0
_LOOK_UP_S = 0.1
_COAST_S = 0.2


class Moving:
    """The test with setpoints; at its end every wheel is at rest.

    Args:
        listening: The connection to the robot, whose sensors must have reported.
        announce: Takes a message before each step.
    """

    def __init__(self, listening: Listening, announce: Callable[[str], None]) -> None:
        self._listening = listening
        self._profile = listening.subject.profile
        self._announce = announce
        self._next_id = 1
        self._accepted = 0
        self._rest = self._at_rest()
        rates = [board.expected_per_s for board in listening.facts().boards]
        # If a message holds one value, a board's turn comes late.
        self._settle_s = max([_COAST_S, *(1.5 / rate for rate in rates if rate)])

    @property
    def bearing(self) -> tuple[str, ...]:
        """The slots of joints that may hold something, which an array of zeros could release.

        A sensor that has shown nothing does not say that its joint holds nothing.
        """
        found = []
        for slot in self._profile.slots:
            motor = self._profile.motors[slot.motor]
            stalls = {"current": motor.stall_current, "torque": motor.stall_torque}
            if slot.wheel is None and not all(
                abs(value) < BEARS * stall
                for sense, stall in stalls.items()
                if stall
                for value in self._readings(slot.name, sense)
            ):
                found.append(slot.name)
        return tuple(found)

    def run(self) -> MoveFact:
        """Turn every wheel for a moment, stop it, and return the results.

        Raises:
            PortLostError: The port has gone.
        """
        wheels: list[TurnFact] = []
        try:
            self._announce("sending arrays in which nothing moves")
            for _ in range(ECHOES):
                self._send(self._rest)
            if self._accepted:
                for at, slot in enumerate(self._profile.slots):
                    if slot.wheel is not None:
                        self._announce(f"turning {slot.name}")
                        wheels.append(self._turn(at, slot.name))
        finally:
            self._stop()
        return MoveFact(self._next_id - 1, self._accepted, tuple(wheels))

    def _turn(self, at: int, name: str) -> TurnFact:
        before = self._angle(name)
        values = list(self._rest)
        values[at] = DUTY
        self._send(tuple(values))
        self._wait(TURN_FOR_S)
        self._send(self._rest)
        self._wait(self._settle_s)
        turned = self._angle(name) - before
        return TurnFact(name, None if isnan(turned) else turned, abs(turned) >= TURNED_RAD)

    def _send(self, values: tuple[float, ...]) -> None:
        """Send the array and wait until it is accepted or its result is unknown."""
        number, listening = self._next_id, self._listening
        self._next_id += 1
        listening.exchange.submit(number, values, listening.port.now())
        give_up_s = listening.port.now() + _ANSWER_WITHIN_S
        while number not in listening.results and listening.port.now() < give_up_s:
            listening.turn(min(give_up_s, listening.port.now() + _LOOK_UP_S))
        result = listening.results.get(number)
        self._accepted += result is not None and result.status == "accepted"

    def _stop(self) -> None:
        """Bring every wheel to rest, as far as the link allows.

        This waits for copies under way. They would be lost with the port, and the count of writings
        would differ from what the robot has received.
        """
        listening = self._listening
        with suppress(PortLostError):
            link, plan = listening.exchange.link, listening.subject.plan
            if not link.idle or link.applied != to_counts(plan.slots, self._rest):
                self._send(self._rest)
            give_up_s = listening.port.now() + _ANSWER_WITHIN_S
            while not link.idle and listening.port.now() < give_up_s:
                listening.turn(min(give_up_s, listening.port.now() + _LOOK_UP_S))

    def _wait(self, seconds: float) -> None:
        until_s = self._listening.port.now() + seconds
        self._listening.turn(until_s)

    def _at_rest(self) -> tuple[float, ...]:
        """Return zero duties, and the present angle of every board with a controller of its own."""
        values = []
        for slot in self._profile.slots:
            value = 0.0
            if slot.unit == "angle":
                angle = self._angle(slot.name)
                limit = slot.limit if slot.limit is not None else abs(angle)
                value = 0.0 if isnan(angle) else min(max(angle, -limit), limit)
            values.append(value)
        return tuple(values)

    def _angle(self, slot: str) -> float:
        """Return the angle that the slot's own sensor shows, rad; NaN if it shows none."""
        return self._seen(slot, "angle")

    def _seen(self, slot: str, sense: str) -> float:
        """Return what the slot's own sensor of this kind shows, in SI; NaN if it shows nothing."""
        return next(self._readings(slot, sense), nan)

    def _readings(self, slot: str, sense: str) -> Iterator[float]:
        """Yield what the slot's own sensors of this kind show, in SI; NaN if one shows nothing."""
        subject = self._listening.subject
        for number, board in subject.robot.boards.items():
            channels = next(b.channels for b in self._profile.boards if b.id == number)
            for place, _, scale in board.channels:
                channel = channels[place]
                if (channel.senses, channel.slot) == (sense, slot):
                    yield self._listening.records.last(number, place) * scale
