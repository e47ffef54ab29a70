"""The firmware's loop: four cases in each bus cycle, on the serial port.

The cases are: idle (read bytes), write setpoints, read a board, publish (thesis section 4-2). A
write to a full send ring blocks the whole loop, as on the real controller; cases do not catch up.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from pirate_sm.robot.rosserial.frames import LOG, LogLine, SerialFrame, log_payload
from pirate_sm.robot.rosserial.messages import Array
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.line import SerialLine
from pirate_sm.simulation.bay.node_handle import NodeHandle, Reception, Wire
from pirate_sm.simulation.simulated_robot import SimulatedRobot

_READY = SerialFrame(LOG, log_payload(LogLine(1, "bay ready")))
_CASES = 4


class Record(NamedTuple):
    """An event in the bay.

    Attributes:
        at_s: Time of the event.
        event: ``received`` (a whole array came), ``applied`` (it is in force), ``echoed`` (its echo
            was written to the line), ``tripped`` (the dead man's switch has stopped every slot that
            is not held), ``reset``, ``booted``, ``hung``, ``unconfigured``, ``spontaneous``,
            ``fault`` (the host did something forbidden), ``opened``, ``closed``.
        setpoint_id: Id of the array, if the event is about one.
        counts: Its setpoints.
        detail: Text for people.
    """

    at_s: float
    event: str
    setpoint_id: int | None = None
    counts: tuple[int, ...] = ()
    detail: str = ""


TakeRecord = Callable[[Record], None]


class Firmware:
    """The controller's program between two restarts.

    Args:
        wire: The robot's messages.
        line: The line to and from the host.
        robot: The simulated robot.
        switches: The defects to emulate.
        cycle_s: Period of the bus.
        echo_delay_s: Time from the reception of an array to its echo.
        stop_after_s: The dead man's switch trips after this long without a valid array; infinite:
            there is no switch.
        now_s: When the set-up is done and the loop begins.
        log: Is called with each record.

    Attributes:
        turn: The turn whose board is read next.
    """

    def __init__(
        self,
        wire: Wire,
        line: SerialLine,
        robot: SimulatedRobot,
        switches: Switches,
        *,
        cycle_s: float,
        echo_delay_s: float,
        stop_after_s: float,
        now_s: float,
        log: TakeRecord,
    ) -> None:
        self._wire, self._line, self._robot = wire, line, robot
        self._switches = switches
        self._log = log
        self._case_for_s = cycle_s / _CASES
        self._echo_delay_s = echo_delay_s
        self._node = NodeHandle(wire.publishers, wire.subscribers)
        self._reception = Reception()
        self._turns = robot.turns(wire.one_value)
        self.turn = 0
        self._case = 0
        self._case_s = now_s
        self._poll_s = now_s if switches.poll_s is not None else math.inf
        self._free_s = now_s
        self._to_write: list[Array] = []
        self._echoes: deque[tuple[float, Array]] = deque()
        self._state: SerialFrame | None = None
        self._stop_after_s = stop_after_s
        self._stop_s = math.inf  # before the first array there is nothing to stop
        self._in_force: Array | None = None

    @property
    def configured(self) -> bool:
        """Whether the firmware publishes."""
        return self._node.configured

    @property
    def due_s(self) -> float:
        """When the loop acts next, s."""
        due = min(self._case_s, self._poll_s, self._stop_s)
        if self._echoes and self._echoes[0][0] < due:
            due = self._echoes[0][0]
        return max(due, self._free_s)

    def stall(self, until_s: float) -> None:
        """Block the loop until then."""
        self._free_s = max(self._free_s, until_s)

    def forget(self) -> None:
        """Become unconfigured: publish nothing, but still obey arrays."""
        self._node.configured = False

    def step(self) -> None:
        """Do the next due action."""
        now = self.due_s
        if self._echoes and self._echoes[0][0] <= now:
            self._send_echo(now, self._echoes.popleft()[1])
        elif self._stop_s <= now:
            self._stop(now)
        elif self._poll_s <= now:
            assert self._switches.poll_s is not None
            self._poll(now)
            self._poll_s = now + self._switches.poll_s
        else:
            self._do_case(now)

    def _do_case(self, now_s: float) -> None:
        self._case_s = now_s + self._case_for_s
        case, self._case = self._case, (self._case + 1) % _CASES
        if case == 0:
            if self._switches.poll_s is None:
                self._poll(now_s)
        elif case == 1:
            self._write_setpoints(now_s)
        elif case == 2:
            self._read(now_s)
        else:
            self._publish(now_s)

    def _read(self, now_s: float) -> None:
        """Read the board whose turn it is."""
        turn = self._turns[self.turn]
        self.turn = (self.turn + 1) % len(self._turns)
        counts = self._robot.read(now_s, turn) if self._switches.sensors_started else None
        self._state = (
            None if counts is None else self._wire.state(turn.board.board, turn.channel, counts)
        )

    def _write_setpoints(self, now_s: float) -> None:
        """Apply the last received array; older ones are never applied."""
        waiting, self._to_write = self._to_write, []
        if not waiting or not self._switches.motors_started:
            return
        array = waiting[-1]
        self._robot.set_values(self._wire.values(array))
        self._in_force = array
        self._log(Record(now_s, "applied", array.number, array.counts))

    def _stop(self, now_s: float) -> None:
        """Trip the dead man's switch, because no valid array has come for too long.

        The echo is that of the last array, with the values that are in force now. It may be lost,
        so it is repeated until another array comes.
        """
        self._stop_s = now_s + self._stop_after_s
        if self._in_force is None:
            return
        self._in_force = array = self._wire.tripped(self._in_force)
        self._robot.set_values(self._wire.values(array))
        self._log(Record(now_s, "tripped", array.number, array.counts))
        self._send_echo(now_s, array)

    def _publish(self, now_s: float) -> None:
        state, self._state = self._state, None
        if state is not None and self._node.configured:
            self._send(now_s, state)

    def _send_echo(self, now_s: float, array: Array) -> None:
        if self._node.configured and now_s < self._switches.no_echo_at_s:
            self._send(now_s, self._wire.echo(array))
            self._log(Record(now_s, "echoed", array.number, array.counts))

    def _send(self, now_s: float, frame: SerialFrame) -> None:
        """Send the frame; the loop continues when the send ring has taken it."""
        self._free_s = self._line.write(frame, max(now_s, self._free_s))

    def _poll(self, now_s: float) -> None:
        arrivals, overrun = self._line.read(now_s)
        if overrun and self._switches.old_client:
            self._node.configured = False
        for frame in self._reception.feed(arrivals):
            if self._line.lets_in(frame.topic):
                self._take(now_s, frame)
        was = self._node.configured
        for due in self._node.tick(now_s):
            self._send(now_s, due)
        if was and not self._node.configured:
            self._log(Record(now_s, "unconfigured", detail="no answer to its time requests"))

    def _take(self, now_s: float, frame: SerialFrame) -> None:
        was = self._node.configured
        answer = self._node.take(frame, now_s)
        for due in answer.says:
            self._send(now_s, due)
        if self._node.configured and not was:
            self._send(now_s, _READY)
        if answer.fault:
            self._log(Record(now_s, "fault", detail=answer.fault))
        if answer.delivered is not None:
            self._obey(now_s, answer.delivered)

    def _obey(self, now_s: float, buffer: bytes) -> None:
        """Take the array at the beginning of the buffer, to apply and echo it later."""
        array = self._wire.array(buffer)
        if array is None:
            self._log(Record(now_s, "fault", detail="a payload that is no array of setpoints"))
            return
        self._log(Record(now_s, "received", array.number, array.counts))
        arrives, echoes = self._robot.delivery(now_s)
        if arrives:
            self._stop_s = now_s + self._stop_after_s
            self._to_write.append(array)
        if arrives and echoes:
            self._echoes.append((now_s + self._echo_delay_s, array))
