"""The whole bay in virtual time: bytes go in and out, and nothing waits for a clock."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from pirate_sm.core.pipe import Pipe
from pirate_sm.core.profile import Profile
from pirate_sm.robot.rosserial.messages import Array, serial_of
from pirate_sm.simulation.acting_defect import Incident
from pirate_sm.simulation.bay.firmware import Firmware, Record
from pirate_sm.simulation.bay.line import SerialLine
from pirate_sm.simulation.bay.switches import Switches
from pirate_sm.simulation.bay.wire import Wire
from pirate_sm.simulation.full_truth import FullTruth
from pirate_sm.simulation.physics import MakePhysics
from pirate_sm.simulation.simulated_robot import SimulatedRobot
from pirate_sm.simulation.surroundings import NO_JITTER, Jitter
from pirate_sm.simulation.xpbd.kinematic import kinematic

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
        """Close the port; the bay goes on, and what it sends is lost."""
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
