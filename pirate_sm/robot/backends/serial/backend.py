"""The serial backend: an exchange on a port, timed by the port's clock.

Mission time stands still while the link is silent. A lost port is opened again.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from math import inf
from threading import Event as Flag
from threading import Lock, Thread

from pirate_sm.core.errors import BackendError
from pirate_sm.core.events import BuiltInFault, Event, SensorFrame
from pirate_sm.core.sensing import board_name
from pirate_sm.robot.backends.protocol import Completion
from pirate_sm.robot.backends.serial.link.conversation import (
    SILENT_AFTER_S,
    mute,
    no_sensors,
    unanswered,
)
from pirate_sm.robot.backends.serial.link.exchange import Exchange
from pirate_sm.robot.backends.serial.link.health import LinkHealth, health_of
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.backends.serial.port import Port, PortLostError

# --- bytes ----------------------------------------------------------------------------------------


_REOPEN_EVERY_S = 0.5
_SAMPLE_BYTES = 4096


class LinkPump:
    """Writes due bytes to the port and passes received ones to the exchange.

    Args:
        port: The robot's port.
        exchange: The driver of the link.

    Attributes:
        sample: The last bytes received before the topics were known, for error messages.
    """

    def __init__(self, port: Port, exchange: Exchange) -> None:
        self.sample = b""
        self._port = port
        self._exchange = exchange
        self._faults: list[Event] = []
        self._lost_s = inf
        self._retry_s = -inf

    @property
    def lost(self) -> bool:
        """Whether the port has gone."""
        return self._lost_s < inf

    def take(self) -> list[Event]:
        """Return the events since the last call, oldest first."""
        faults, self._faults = self._faults, []
        return [*faults, *self._exchange.take()]

    def turn(self, until_s: float) -> None:
        """Write everything that is due, and take in what comes by ``until_s``."""
        port, exchange = self._port, self._exchange
        if self.lost:
            self._retry(port.now())
        now = port.now()
        able = not self.lost
        try:
            while data := exchange.write(now, able):
                port.beat(exchange.guarded_frame())  # before the robot moves
                port.write(data)
            port.beat(exchange.guarded_frame())
            data = port.read(min(until_s, self._due_s(now))) if able else b""
        except PortLostError as error:
            self._lose(str(error))
        if self.lost:
            port.wait(min(until_s, self._due_s(now)))
            return
        if data:
            if not exchange.conversation.known:
                self.sample = (self.sample + data)[-_SAMPLE_BYTES:]
            exchange.receive(data, port.now())
        self._heed_guardian()

    def put(self, data: bytes) -> None:
        """Write the bytes as soon as the device's ring has room for them."""
        port, exchange = self._port, self._exchange
        free_s = exchange.throttle.free_s(len(data), port.now())
        while port.now() < free_s:
            port.wait(free_s)
        port.write(data)
        exchange.throttle.wrote(len(data), port.now())

    def _heed_guardian(self) -> None:
        """Report a fault if the guardian has stopped the robot instead of this program."""
        try:
            overruled = self._port.overruled()
        except PortLostError as error:
            self._lose(str(error))
            return
        if overruled:
            message = "this program stood still for too long, the guardian of the port has stopped"
            self._faults.append(BuiltInFault.RUNNER_STALLED.report(f"{message} the robot"))

    def _due_s(self, now: float) -> float:
        return self._retry_s if self.lost else self._exchange.due_s(now)

    def _lose(self, reason: str) -> None:
        now = self._port.now()
        if not self.lost:
            self._lost_s = now
            self._retry_s = now + _REOPEN_EVERY_S
            self._exchange.lost(reason, now)

    def _retry(self, now: float) -> None:
        """Try to reopen a lost port; the exchange then asks for topics and sends the array."""
        if now < self._retry_s:
            return
        self._retry_s = now + _REOPEN_EVERY_S
        if self._port.reopen():
            self._lost_s = inf
            self._exchange.connected(self._port.now())


# --- time -----------------------------------------------------------------------------------------


class MissionTime:
    """Derives mission time from the port's clock.

    Attributes:
        now_s: Mission time, s.
    """

    def __init__(self) -> None:
        self.now_s = 0.0
        self._zero_s = 0.0
        self._held_s = inf
        self._late = False

    def deadline_s(self, until_s: float, look_up_s: float) -> float:
        """Return the time of the clock until which to wait: a mission time, or ``look_up_s``."""
        return look_up_s if self._held_s < inf else min(self._zero_s + until_s, look_up_s)

    def follow(self, exchange: Exchange, now: float) -> None:
        """Stop mission time while the mission is held.

        After a brief silence it catches up, except for the time in which this program stood still.
        It leaves out a silence that is reported as a fault.
        """
        outage = exchange.outage
        self._zero_s += exchange.take_left_out_s()
        if outage is not None:
            self._held_s = min(self._held_s, outage.since_s)
        elif self._held_s < inf:
            if exchange.brief:
                self._late = True
            else:
                self._zero_s += now - self._held_s
            self._held_s = inf

    def stand(self, now: float) -> None:
        """Go on from this time of the clock, and leave out what has passed before."""
        self._zero_s = min(now, self._held_s) - self.now_s
        self._late = False

    def reach(self, now: float, until_s: float) -> bool:
        """Advance mission time to this time of the clock, at most to ``until_s``.

        Returns:
            Whether events may be reported now; if not, mission time is still catching up.
        """
        running_s = min(now, self._held_s)
        now_s = running_s - self._zero_s
        # `now_s` alone is not enough: rounding may leave it just below `until_s`.
        self.now_s = max(self.now_s, min(now_s, until_s))
        if running_s >= self._zero_s + until_s:
            self.now_s = until_s
        if self._late and now_s > until_s:
            return False
        self._late = False
        return True


# --- the backend ----------------------------------------------------------------------------------


ANSWER_WITHIN_S = 6.0
"""Longer than a boot loader runs, and long enough even if every second frame is lost."""

SENSORS_WITHIN_S = 3.0
_LOOK_UP_S = 0.1
_FLUSH_WITHIN_S = 0.8
_RESET_SHOWS_S = SILENT_AFTER_S + 0.1
"""A silence of this length has been noticed by then, and the link counts as away."""

_TEND_S = 0.05
"""How long the link is served at a time while nobody calls; a call waits no longer than this."""


class SerialBackend:
    """Runs the robot at the other end of a serial port.

    Args:
        plan: The robot's link plan.
        port: The port that the robot is connected to.
        baud: Baud rate of the line.
        tended: Whether a thread serves the link while nobody calls, see :meth:`tend`.

    Attributes:
        exchange: The driver of the link.
        confirmed: Whether, when the backend was closed, the robot had confirmed the last array.
        listener: Is given the events that the link has reported, and the time of the port's clock,
            each time that the link is served; it must not raise. None: nobody listens.
    """

    name = "serial"
    completion: Completion = "measured"
    real_time = True

    def __init__(
        self, plan: LinkPlan, port: Port, *, baud: int | None = None, tended: bool = False
    ) -> None:
        self.plan = plan
        self.port = port
        self._baud = baud or plan.serial.baud
        self._begin()
        self._time = MissionTime()
        self._was_away = False
        self._trips = 0
        self._events: list[Event] = []
        self._open = False
        self._closed = False
        self._turn = Lock()
        self._called_of_late = False
        self._tending = False
        self._failure: Exception | None = None
        self._leaving = Flag()
        self._tender = Thread(target=self._attend, daemon=True) if tended else None
        self.confirmed = True
        self.listener: Callable[[Sequence[Event], float], None] | None = None

    def _begin(self) -> None:
        port = self.port
        self.exchange = Exchange(self.plan, port.now(), port.epoch_s, self._baud)
        self._pump = LinkPump(port, self.exchange)

    # --- the protocol -----------------------------------------------------------------------

    def open(self) -> Sequence[Event]:
        """Open the port, learn the topics, and return what every board measures; nothing moves.

        Raises:
            BackendError: The robot cannot be reached; the message says what to do.
        """
        if self._closed:
            raise BackendError("the port has been closed")
        self.port.open()
        self._open = True
        try:
            self._begin()
            self._negotiate()
            events = self._hear_sensors()
        except BaseException:
            self.close()
            raise
        self._time.stand(self.port.now())
        self.exchange.watch()
        if self._tender is not None:
            self._tender.start()
        return events

    def submit(self, setpoint_id: int, values: tuple[float, ...]) -> None:
        """Hand an array over; its result comes from ``advance``."""
        if self._closed or not self._open:
            raise BackendError("the port is closed")
        with self._called():
            self.exchange.submit(setpoint_id, values, self.port.now())

    def advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        """Run until an event, until ``until_s`` or for a tenth of a second; return time and events.

        While the link is silent, mission time stands still and no deadline passes.
        """
        if self._closed or not self._open:
            raise BackendError("the port is closed")
        with self._called():
            return self._advance(until_s)

    def _advance(self, until_s: float) -> tuple[float, Sequence[Event]]:
        if until_s < self._time.now_s:
            return self._time.now_s, ()
        self.exchange.resume(self.port.now())
        look_up_s = self.port.now() + _LOOK_UP_S
        while True:
            deadline_s = self._time.deadline_s(until_s, look_up_s)
            self._pump.turn(deadline_s)
            now = self.port.now()
            self._time.follow(self.exchange, now)
            self._events += self._take(now)
            if self._events or now >= deadline_s:
                break
        if not self._time.reach(now, until_s):
            return self._time.now_s, ()  # reported when mission time is there
        events, self._events = self._events, []
        return self._time.now_s, events

    def close(self) -> None:
        """Send the last array, tell the device to stop publishing, and free the port."""
        if self._closed:
            return
        self._closed = True
        self._leaving.set()
        if self._tender is not None and self._tender.is_alive():
            self._tender.join()
        stopped = self.exchange.stopped
        if self._open:
            with suppress(BackendError):
                self._flush()
            self.confirmed = self.exchange.settled and stopped.confirmed
            # Only to a rosserial device, and to none that still has to confirm an array.
            if self.exchange.conversation.frames and stopped.confirmed:
                with suppress(BackendError):
                    self._pump.put(self.exchange.conversation.farewell())
        self._open = False
        self.port.close(stopped.confirmed)

    # --- beyond it --------------------------------------------------------------------------

    def hold(self, values: tuple[float, ...], seeking: Collection[int] = ()) -> None:
        """Set the safe array, which the guardian sends if this process dies.

        Args:
            values: The safe array.
            seeking: Slots that a position loop drives; the firmware's switch stops them too.
        """
        with self._called():
            self.exchange.hold(values, seeking)

    def tend(self) -> None:
        """Serve the link for a moment while nobody runs a mission; mission time stands still.

        Whoever has opened the backend may think, ask a person or write a report for as long as that
        takes: reports are read, the newest of each board is kept, the controller gets its answers
        and setpoints are refreshed. A robot that may be moving is not tended, because nobody
        watches it: its guardian stops it.
        """
        if not (self._tending or self.exchange.at_rest):
            return
        self._tending = True
        until_s = self.port.now() + _TEND_S
        while self.port.now() < until_s:
            self._pump.turn(until_s)
        now = self.port.now()
        self._time.follow(self.exchange, now)
        self._time.stand(now)
        events = [*self._events, *self._take(now)]
        newest = {each.board: each for each in events if isinstance(each, SensorFrame)}
        others = (each for each in events if not isinstance(each, SensorFrame))
        self._events = [*others, *newest.values()]

    @property
    def health(self) -> LinkHealth:
        """Return the present state of the link in numbers."""
        return health_of(self.exchange, self.port.now())

    def parting(self) -> str:
        """Return what a person must do after the port was closed; empty if nothing."""
        return self.port.remark()

    def remark(self) -> str:
        """Return what a person must know now; each remark is returned once, else empty."""
        if about_the_port := self.port.remark():
            return about_the_port
        trips = self.exchange.counts.trips
        if trips > self._trips:
            self._trips = trips
            return (
                "the robot's dead man's switch had stopped its motors because no setpoints "
                f"arrived; they are sent again ({trips} time{'s' if trips > 1 else ''} so far)"
            )
        was_away, self._was_away = self._was_away, self.exchange.outage is not None
        if was_away or not self._was_away:
            return ""
        within_s = self.plan.away_s
        return (
            "no data comes from the robot, which may continue its motion; without any, the link "
            f"is given up after {within_s:g} s"
        )

    # --- inside -----------------------------------------------------------------------------

    def _take(self, now: float) -> list[Event]:
        """Return what the link has reported; the listener hears it first."""
        events = self._pump.take()
        if (listener := self.listener) is not None:
            listener(events, now)
        return events

    @contextmanager
    def _called(self) -> Iterator[None]:
        """Use the link alone; raise what has gone wrong while it was tended."""
        with self._turn:
            self._called_of_late, self._tending = True, False
            if self._failure is not None:
                raise self._failure
            yield

    def _attend(self) -> None:
        """Tend the link whenever nobody has called for a while."""
        while not self._leaving.wait(_TEND_S):
            with self._turn:
                try:
                    if not self._called_of_late and self._failure is None:
                        self.tend()
                except Exception as error:  # raised at the next call
                    self._failure = error
                self._called_of_late = False

    def _negotiate(self) -> None:
        conversation = self.exchange.conversation
        boot_s = self.plan.serial.boot
        give_up_s = self.port.now() + boot_s + ANSWER_WITHIN_S
        while not conversation.known:
            frames, heard_s = conversation.frames, conversation.heard_s
            self._pump.turn(give_up_s)
            if frames and conversation.heard_s - heard_s > boot_s / 2:
                give_up_s = conversation.heard_s + ANSWER_WITHIN_S  # it has been reset meanwhile
            self._stop_if_refused()
            if self._pump.lost:
                raise BackendError(f"{self.port.name} went away while it was being opened")
            if self.port.now() >= give_up_s:
                name, usual = self.port.name, self.plan.serial.baud
                raise BackendError(
                    unanswered(name, self._baud, conversation, self._pump.sample, usual)
                )

    def _stop_if_refused(self) -> None:
        if self.exchange.refused:
            raise BackendError("; ".join(self.exchange.refused))

    def _hear_sensors(self) -> list[Event]:
        """Return the last frame of every board, and a fault for each board that does not report.

        Raises:
            BackendError: No board reports.
        """
        exchange, boards = self.exchange, set(self.plan.channels)
        give_up_s = self.port.now() + SENSORS_WITHIN_S
        frames: dict[int, SensorFrame] = {}
        faults: list[Event] = []
        while not boards <= frames.keys() and self.port.now() < give_up_s:
            self._pump.turn(give_up_s)
            for event in exchange.take():
                if isinstance(event, SensorFrame):
                    frames[event.board] = event
            self._stop_if_refused()
            if self._pump.lost:
                raise BackendError(f"{self.port.name} went away while it was being opened")
        silent = boards - frames.keys()
        if boards and silent == boards:
            raise BackendError(no_sensors(self.plan.serial.advice.no_sensors))
        if silent:
            of = tuple(map(board_name, sorted(silent)))
            faults.append(BuiltInFault.SENSOR_SILENT.report(mute(self.plan.modules, silent), of=of))
        return [*frames.values(), *faults]

    def _flush(self) -> None:
        """Wait until the last array is confirmed; otherwise write the safe array once more.

        The robot must also report once more, because a robot that was just reset has forgotten what
        it confirmed. If it is away, being reset or unplugged, wait for it.
        """
        exchange, now = self.exchange, self.port.now()
        began_s, patient_s, give_up_s = now, now + self.plan.away_s, now + _FLUSH_WITHIN_S
        while True:
            heard_s = exchange.conversation.heard_s
            if heard_s >= (began_s if exchange.settled else give_up_s):
                break
            if now >= give_up_s and now - heard_s >= _RESET_SHOWS_S:
                break
            self._pump.turn(now + _LOOK_UP_S)
            now = self.port.now()
            if exchange.outage is not None and now < patient_s:
                give_up_s = now + _FLUSH_WITHIN_S
            if exchange.newer:
                exchange.resume(self.port.now())
        if not exchange.settled:
            self._pump.put(exchange.safe_frame())
