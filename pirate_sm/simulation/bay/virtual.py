"""The whole bay in virtual time, and a port to it: bytes go in and out without a clock."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from math import inf
from typing import Protocol

import numpy as np

from pirate_sm.core.models import Pipe, Profile
from pirate_sm.robot.backends.serial.guardian.guard import (
    Action,
    Guard,
    Instructions,
    Note,
    NoteKind,
    Reopen,
    ToPort,
    ToRunner,
)
from pirate_sm.robot.backends.serial.link.conversation import Wanted
from pirate_sm.robot.backends.serial.port import PortLostError
from pirate_sm.robot.rosserial.messages import Array, serial_of
from pirate_sm.simulation.acting_defect import Incident
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.firmware import Firmware, Record
from pirate_sm.simulation.bay.line import SerialLine
from pirate_sm.simulation.bay.node_handle import Wire
from pirate_sm.simulation.kinematic.world import kinematic
from pirate_sm.simulation.physics import MakePhysics
from pirate_sm.simulation.simulated_robot import FullTruth, SimulatedRobot
from pirate_sm.simulation.surroundings import NO_JITTER, Jitter

_SHORTEST_BOOT = 0.75
"""Share of the profile's boot time that a quick start takes: 1.5 to 2 s for an Arduino Mega."""


class VirtualBay:
    """A bay that was switched on at time 0 with nothing connected to it.

    Calls must come in order of time. Equal seeds and calls give equal bytes.

    Args:
        profile: The robot's profile; it must have a serial link.
        pipe: The pipe.
        texts: The ``.msg`` text of each message type, by its name.
        switches: The defects to emulate.
        seed: Seed of all random numbers.
        start_values: Setpoints of the configuration at the start, one per slot, for a start with
            clamped parts; None for a straight robot.
        physics: Makes the physics that moves the robot.
        jitter: How far the robot and its pipe may differ from the files.

    Attributes:
        robot: The robot as it truly is, for whoever measures; it moves by whole cycles.
        records: Past events, oldest first; a reader may clear the list.
        last_array: The last whole array received; None before the first.
        last_applied: The array in force, after a trip of the dead man's switch with its zeros.

    Raises:
        UsageError: Robot, pipe, texts and switches do not fit together.
    """

    def __init__(
        self,
        profile: Profile,
        pipe: Pipe,
        texts: Mapping[str, str],
        switches: Switches | None = None,
        seed: int = 0,
        start_values: Sequence[float] | None = None,
        physics: MakePhysics = kinematic,
        jitter: Jitter = NO_JITTER,
    ) -> None:
        self._switches = switches = switches or Switches()
        serial = serial_of(profile)
        chances = np.random.default_rng((seed, 1)).spawn(5)
        self._wire = Wire(profile, texts, switches.wrong_md5)
        self.robot = SimulatedRobot(
            profile,
            pipe,
            physics,
            seed=seed,
            start_values=start_values,
            jitter=jitter,
            defects=switches.defects,
            more_defects=switches.more_defects(seed, chances[2:]),
        )
        self._turns = self.robot.turns(self._wire.one_value)
        self._line = SerialLine(serial.baud, switches, chances[0])
        self._boot = (serial.boot * _SHORTEST_BOOT, serial.boot, chances[1])
        self._cycle_s = profile.link.cycle
        self._echo_delay_s = profile.link.echo_delay
        stop_after_s = serial.stop_after if switches.dead_man else None
        self._stop_after_s = math.inf if stop_after_s is None else stop_after_s
        self._lapses_s = [math.inf, *sorted(switches.unconfigured_at_s, reverse=True)]
        self._cycles = 0
        self._world_s = self._cycle_s
        self._find_next_defect()
        self._booted_s = math.inf
        self.records: list[Record] = []
        self.last_array: Array | None = None
        self.last_applied: Array | None = None
        self._firmware: Firmware | None = self._set_up(0.0)

    @property
    def truth(self) -> FullTruth:
        """The robot's true position and state."""
        return self.robot.truth

    @property
    def duties(self) -> tuple[float, ...]:
        """Duties in force: of the joints at each wheel, then of the wheels."""
        return self.robot.duties

    @property
    def configured(self) -> bool:
        """Whether the firmware runs, has been asked for its topics, and publishes."""
        return self._firmware is not None and self._firmware.configured

    @property
    def overrun(self) -> int:
        """How many bytes of the host were lost to a full receive ring."""
        return self._line.overrun

    @property
    def due_s(self) -> float:
        """The time before which no frame is complete at the host if nothing is received."""
        due = self._line.due_s  # of the frame under way; others come after it
        return due if due < math.inf else self._next_s()

    def open(self, now_s: float) -> None:
        """Open the port, which resets the controller and starts its boot loader."""
        self._run(now_s)
        self._line.connected = True
        self._log(Record(now_s, "opened"))
        self._reset(now_s, "the port was opened")

    def close(self, now_s: float) -> None:
        """Close the port; the bay keeps running, and what it sends is lost."""
        self._run(now_s)
        self._line.hang_up()
        self._log(Record(now_s, "closed"))

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that the host has written in one call."""
        self._run(now_s)
        self._line.receive(data, now_s)

    def advance(self, now_s: float) -> bytes:
        """Run until this time; return the bytes that have reached the host since the last call.

        Args:
            now_s: Not earlier than in any earlier call.
        """
        self._run(now_s)
        return self._line.collect(now_s)

    def _next_s(self) -> float:
        firmware = self._firmware.due_s if self._firmware is not None else self._booted_s
        return min(firmware, self._defect_s, self._world_s)

    def _find_next_defect(self) -> None:
        """Find out when the next defect acts."""
        self._defect_s = min(self._lapses_s[-1], self.robot.due_s)

    def _run(self, now_s: float) -> None:
        while True:
            firmware = self._firmware
            own_s = firmware.due_s if firmware is not None else self._booted_s
            due = min(own_s, self._defect_s, self._world_s)
            if due > now_s:
                return
            if due == self._world_s:
                self._move(due)
            elif due < own_s:
                self._strike(due)
            elif firmware is not None:
                firmware.step()
            else:
                self._start(due)

    def _move(self, now_s: float) -> None:
        """Move the robot for one cycle."""
        self._cycles += 1
        self._world_s = (self._cycles + 1) * self._cycle_s
        turn = self._turns[self._firmware.turn if self._firmware is not None else 0]
        incidents = self.robot.step(now_s, turn)
        self.robot.meet_obstacles()
        if incidents:
            self._react_to(now_s, incidents)

    def _strike(self, now_s: float) -> None:
        """Let the defects act that are due between two cycles."""
        if now_s == self._lapses_s[-1]:
            self._lapses_s.pop()
            if self._firmware is not None:
                self._firmware.forget()
            self._log(Record(now_s, "unconfigured", detail="forgotten"))
        self._react_to(now_s, self.robot.strike(now_s))

    def _react_to(self, now_s: float, incidents: Sequence[Incident]) -> None:
        """Let the controller react to incidents of the robot."""
        for incident in incidents:
            if incident.what == "boards_restarted":
                self._reset(now_s, "a defect of the firmware")
            elif incident.what == "controller_restarted":
                self._reset(now_s, "the firmware started again by itself")
            elif incident.what == "motor_moves":
                self._log(Record(now_s, "spontaneous"))
            else:
                if self._firmware is not None:
                    self._firmware.stall(incident.until_s)
                self._log(Record(now_s, "hung", detail=f"until {incident.until_s:g} s"))
        self._find_next_defect()

    def _reset(self, now_s: float, why: str) -> None:
        """Restart the controller; motors keep their setpoints until it is set up."""
        self._line.restart(now_s)
        self._firmware = None
        least, most, rng = self._boot
        drawn = float(rng.uniform(least, most))
        self._booted_s = now_s + (drawn if self._switches.boot_s is None else self._switches.boot_s)
        self._log(Record(now_s, "reset", detail=why))

    def _start(self, now_s: float) -> None:
        """Finish the set-up: write initial setpoints and begin the loop."""
        self._booted_s = math.inf
        self._line.ignore(now_s)
        self.robot.electronics.rest()
        self._firmware = self._set_up(now_s)
        self._log(Record(now_s, "booted"))

    def _set_up(self, now_s: float) -> Firmware:
        return Firmware(
            *(self._wire, self._line, self.robot, self._switches),
            cycle_s=self._cycle_s,
            echo_delay_s=self._echo_delay_s,
            stop_after_s=self._stop_after_s,
            now_s=now_s,
            log=self._log,
        )

    def _log(self, record: Record) -> None:
        self.records.append(record)
        if record.setpoint_id is None:
            return
        if record.event == "received":
            self.last_array = Array(record.setpoint_id, record.counts)
        elif record.event in {"applied", "tripped"}:
            self.last_applied = Array(record.setpoint_id, record.counts)


# --- the port ------------------------------------------------------------------------------------


_EPOCH_S = 1.7e9


class Device(Protocol):
    """The emulated device; calls come in order of time."""

    @property
    def due_s(self) -> float:
        """When it may send something, if it receives nothing."""
        ...

    def open(self, now_s: float) -> None:
        """Handle that the host has opened the port."""
        ...

    def close(self, now_s: float) -> None:
        """Handle that the host has closed the port."""
        ...

    def receive(self, data: bytes, now_s: float) -> None:
        """Take in bytes that the host has written in one call."""
        ...

    def advance(self, now_s: float) -> bytes:
        """Return what the host has received since the last call."""
        ...


class VirtualPort:
    """A port whose guardian and device run in this process, in one virtual time.

    Args:
        device: The emulated device.
        silence_s: After this silence of the runner the guardian acts; infinite for no guardian.
        wanted: The robot's topics, for which the guardian asks after the cable was unplugged.

    Attributes:
        device: The emulated device.
        written: Time and bytes of each writing to the device.
        plugged: Whether the cable is plugged in.
    """

    name = "virtual"
    epoch_s = _EPOCH_S

    def __init__(
        self, device: Device, silence_s: float = inf, wanted: Sequence[Wanted] = ()
    ) -> None:
        self.device = device
        self._silence_s, self._wanted = silence_s, tuple(wanted)
        self._guard = Guard(Instructions(silence_s, tuple(wanted)), _EPOCH_S)
        self._now_s = 0.0
        self._data: deque[bytes] = deque()
        self._overruled = False
        self._connected = False
        self.written: list[tuple[float, bytes]] = []
        self.plugged = True

    def now(self) -> float:
        """Return the device's time, s."""
        return self._now_s

    def open(self) -> None:
        """Open the port."""
        self._do([Reopen()])

    def reopen(self) -> bool:
        """Open the port if the cable is plugged in; return whether it is."""
        self._notice_cable()
        if self.plugged and not self._connected:
            self.open()
        return self.plugged

    def write(self, data: bytes) -> None:
        """Put the bytes on the device's line, unless the guardian is acting."""
        self._need_cable()
        self._do(self._guard.hear(Note(NoteKind.WRITE, data), self._now_s))

    def read(self, until_s: float) -> bytes:
        """Return received bytes as soon as there are any."""
        self._need_cable()
        self._run(until_s, stop_at_data=True)
        return self._data.popleft() if self._data else b""

    def wait(self, until_s: float) -> None:
        """Let time pass until then; bytes received meanwhile stay readable."""
        self._run(until_s, stop_at_data=False)

    def beat(self, safe_frame: bytes) -> None:
        """Give the guardian a sign of life and the safe frame."""
        self._do(self._guard.hear(Note(NoteKind.BEAT, safe_frame), self._now_s))
        self._need_cable()  # a real guardian without a port reports this too

    def overruled(self) -> bool:
        """Return whether the guardian has acted; from now on it relays again."""
        overruled, self._overruled = self._overruled, False
        if overruled:
            self._do(self._guard.hear(Note(NoteKind.HEED), self._now_s))
        return overruled

    def remark(self) -> str:
        """Return an empty text: no other run can have had this port."""
        return ""

    def close(self, stopped: bool = False) -> None:
        """Let written bytes arrive; a guardian that stays acts while :meth:`wait` runs."""
        if not stopped:
            self._do(self._guard.runner_gone(self._now_s))
        self.wait(self._now_s + 0.1)
        if stopped or self._guard.confirmed or not self._guard.payload:
            self.device.close(self._now_s)

    def die(self, until_s: float) -> None:
        """Kill the runner, and give the guardian until then to act."""
        self._do(self._guard.runner_gone(self._now_s))
        self.wait(until_s)

    def abandon(self) -> None:
        """Kill the runner and the guardian: nobody writes any more."""
        self._guard = Guard(Instructions(inf, ()), _EPOCH_S)
        self.device.close(self._now_s)

    def next_port(self) -> VirtualPort:
        """Return the port of another program on the same device, at the same time."""
        port = VirtualPort(self.device, self._silence_s, self._wanted)
        port._now_s = self._now_s
        return port

    def _notice_cable(self) -> None:
        """Report to the guardian that the cable was unplugged."""
        self.now()  # the cable may be scheduled to be unplugged
        if self._connected and not self.plugged:
            self._connected = False
            self._do(self._guard.lost("the cable is out", self._now_s))

    def _need_cable(self) -> None:
        self._notice_cable()
        if not self.plugged:
            raise PortLostError("the cable is out")

    def _run(self, until_s: float, stop_at_data: bool) -> None:
        until_s = max(until_s, self._now_s)
        if until_s == inf and min(self.device.due_s, self._guard.due_s) == inf:
            raise PortLostError("nothing will ever come")
        while not (stop_at_data and self._data):
            due_s = min(self.device.due_s, self._guard.due_s)
            self._now_s = min(max(due_s, self._now_s), until_s)
            self._notice_cable()
            data = self.device.advance(self._now_s)
            if data and self.plugged:
                self._do(self._guard.receive(data, self._now_s))
            self._do(self._guard.tick(self._now_s))
            if self._now_s >= until_s:
                return

    def _do(self, actions: list[Action]) -> None:
        for action in actions:
            if isinstance(action, ToPort) and self.plugged:
                self.written.append((self._now_s, action.data))
                self.device.receive(action.data, self._now_s)
            elif isinstance(action, ToRunner) and action.note.kind == NoteKind.DATA:
                self._data.append(action.note.body)
            elif isinstance(action, ToRunner):
                self._overruled |= action.note.kind == NoteKind.OVERRULED
            elif isinstance(action, Reopen) and self.plugged:
                self.device.open(self._now_s)
                self._connected = True
                self._do(self._guard.opened(self._now_s))
