"""The firmware's binary in a simulated controller, between a host and a simulated robot's boards.

It takes the place of :class:`pirate_sm.simulation.bay.virtual.VirtualBay`: in virtual time behind a
``VirtualPort``, in real time behind a pseudo-terminal by ``serve``.
"""

from __future__ import annotations

import subprocess
from binascii import crc_hqx
from collections.abc import Sequence
from math import inf
from pathlib import Path
from struct import pack, unpack_from
from typing import NamedTuple

import numpy as np

from pirate_sm.core.models import Pipe, Profile
from pirate_sm.robot.rosserial.messages import Array
from pirate_sm.simulation.acting_defect import Incident
from pirate_sm.simulation.bay.firmware import Record
from pirate_sm.simulation.bay.node_handle import Wire, message_texts
from pirate_sm.simulation.kinematic.world import kinematic
from pirate_sm.simulation.physics import MakePhysics
from pirate_sm.simulation.simulated_robot import CycleReading, SimulatedRobot

HERTZ = 16_000_000
LOOK_S = 0.002
"""How often a host looks for bytes."""

_TURNS_ROUND_S = 50e-6  # what a board needs before it answers [assumed]


class Built(NamedTuple):
    """What the firmware's Makefile has built.

    Attributes:
        host: The simulated controller.
        elf: The firmware, for one robot.
        end: The address behind what it has in memory.
    """

    host: Path
    elf: Path
    end: int


class Controller:
    """The process of the simulated controller; see ``firmware/simulated/host.c``."""

    def __init__(self, built: Built) -> None:
        self._process = subprocess.Popen(
            [built.host, built.elf],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            bufsize=1,
        )

    def does(self, command: str) -> str:
        """Return the answer to a command."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(f"{command}\n")
        answer = self._process.stdout.readline()
        assert answer, f"the simulated controller has ended at '{command}'"
        return answer

    def close(self) -> None:
        """End the process."""
        self._process.terminate()
        self._process.communicate()

    __del__ = close


class Noise:
    """Loses and changes bytes of one direction of the line.

    Args:
        lost: Share of bytes that are lost.
        flipped: Share of bytes that are changed.
        seed: Of the random numbers.
    """

    def __init__(self, lost: float = 0.0, flipped: float = 0.0, seed: int = 0) -> None:
        self._lost, self._flipped = lost, flipped
        self._rng = np.random.default_rng(seed)

    def damage(self, data: bytes) -> bytes:
        """Return what arrives of these bytes."""
        if not self._lost and not self._flipped:
            return data
        fates = self._rng.random(len(data))
        kept = [
            byte ^ int(self._rng.integers(1, 256)) if fate < self._lost + self._flipped else byte
            for byte, fate in zip(data, fates, strict=True)
            if fate >= self._lost
        ]
        return bytes(kept)


class AvrBay:
    """A bay whose controller is the binary that is flashed.

    Args:
        built: The simulated controller, and its firmware.
        profile: The robot's profile.
        folder: The robot's folder.
        pipe: The pipe.
        seed: Seed of all random numbers.
        start_values: Setpoints of the configuration at the start, one per slot.
        defects: Defects of the profile, as text with their numbers.
        physics: Makes the physics that moves the robot.
        towards: What happens to bytes on their way to the bay; ``back``, to the host; ``bus``, from
            its boards.

    Attributes:
        robot: The simulated robot.
        counts: What each slot's board has in force, as integers of the wire.
        in_force: When boards were written to, and all slots' counts then.
        dead: Boards that answer nothing.
        still_since_s: Since when every wheel has been at zero; infinite while one is driven.
        records: Stays empty.
    """

    def __init__(
        self,
        built: Built,
        profile: Profile,
        folder: Path,
        pipe: Pipe,
        *,
        seed: int = 0,
        start_values: Sequence[float] | None = None,
        defects: Sequence[str] = (),
        physics: MakePhysics = kinematic,
        towards: Noise | None = None,
        back: Noise | None = None,
        bus: Noise | None = None,
    ) -> None:
        self._wire = Wire(profile, message_texts(folder, profile))
        self.robot = SimulatedRobot(
            profile, pipe, physics, seed=seed, start_values=start_values, defects=defects
        )
        self._readings = {each.board.board: each for each in self.robot.turns(one_value=False)}
        slots = iter(range(len(profile.slots)))
        self._slots = {board.id: [next(slots) for _ in board.slots] for board in profile.boards}
        steps = self._wire.values(Array(0, (1,) * len(profile.slots)))
        values = start_values or (0.0,) * len(profile.slots)
        self.counts = [round(value / step) for value, step in zip(values, steps, strict=True)]
        self.in_force: list[tuple[float, tuple[int, ...]]] = []
        self.wheels = [at for at, slot in enumerate(profile.slots) if slot.wheel is not None]
        self.still_since_s = 0.0
        self._cycle_s = self._world_s = profile.link.cycle
        self._turn = next(iter(self._readings.values()))
        self._towards, self._back, self._bus = (each or Noise() for each in (towards, back, bus))
        self.controller = Controller(built)
        self._end = built.end
        self.unused_stack()
        self.connected = False
        self.dead: set[int] = set()
        self.records: list[Record] = []
        self._now_s = 0.0
        self._to_host: list[tuple[int, int]] = []
        self._to_boards = b""

    @property
    def due_s(self) -> float:
        """When to look for bytes again."""
        return self._now_s + LOOK_S

    def unused_stack(self) -> int:
        """Return how many bytes the stack has never reached since the last call."""
        return int(self.controller.does(f"stack {self._end}"))

    def open(self, now_s: float) -> None:
        """Open the port, which restarts the controller."""
        self.advance(now_s)
        self.connected = True
        self.controller.does("reset")

    def close(self, now_s: float) -> None:
        """Close the port; the bay keeps running, and what it sends is lost."""
        self.advance(now_s)
        self.connected = False

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes that the host has written in one call."""
        self.advance(now_s)
        if arriving := self._towards.damage(data):
            self.controller.does(f"host {_cycles(now_s)} {arriving.hex()}")

    def advance(self, now_s: float) -> bytes:
        """Run until this time; return the bytes that have reached the host since the last call."""
        until = _cycles(now_s)
        cycle = _cycles(self._now_s)
        while cycle < until:
            *sent, time = self.controller.does(f"run {until}").split()
            cycle = int(time)
            for each in sent:
                at, _, byte = each[1:].partition(":")
                if each[0] == "h":
                    self._to_host.append((int(at), int(byte, 16)))
                elif each[0] == "b":
                    self._to_boards += bytes.fromhex(byte)
                elif self._to_boards:  # the bus was released
                    self._answer(self._to_boards, cycle / HERTZ)
                    self._to_boards = b""
        self._now_s = max(self._now_s, now_s)
        self._move(self._now_s)
        ready = sum(at <= until for at, _ in self._to_host)
        data = bytes(byte for _, byte in self._to_host[:ready])
        del self._to_host[:ready]
        return self._back.damage(data) if self.connected else b""

    # --- the robot and its boards -----------------------------------------------------------------

    def _move(self, now_s: float) -> None:
        while self._world_s <= now_s:
            for incident in self.robot.step(self._world_s, self._turn):
                self._react_to(incident)
            self.robot.meet_obstacles()
            self._world_s += self._cycle_s

    def _react_to(self, incident: Incident) -> None:
        """Let the controller react to an incident of the robot."""
        if incident.what in {"boards_restarted", "controller_restarted"}:
            self.controller.does("reset")
        elif incident.what == "controller_hangs":
            self.controller.does("hang")

    def _answer(self, frame: bytes, now_s: float) -> None:
        """Let the board answer that was asked."""
        self._move(now_s)
        if crc_hqx(frame[:-2], 0xFFFF) != int.from_bytes(frame[-2:], "little"):
            return  # cut off by a restart
        mark, board, kind, count = frame[:4]
        assert (mark, len(frame)) == (0xB5, 4 + count + 2)
        if board in self.dead:
            return
        slots = self._slots[board]
        if kind == ord("W"):
            self._write(slots, frame[4], unpack_from(f"<{len(slots)}h", frame, 5), now_s)
        in_force = [self.counts[slot] for slot in slots]
        data = pack(f"<{len(slots)}h", *in_force)
        if kind == ord("R"):
            self._turn = self._readings[board]
            counts = self._read(self._turn, now_s)
            if counts is None:
                return
            data += pack(f"<{len(counts)}i", *(round(count) for count in counts))
        answer = bytes((mark, board, kind + 32, len(data))) + data
        answer += crc_hqx(answer, 0xFFFF).to_bytes(2, "little")
        if arriving := self._bus.damage(answer):
            self.controller.does(f"bus {_cycles(now_s + _TURNS_ROUND_S)} {arriving.hex()}")

    def _write(self, slots: Sequence[int], mask: int, counts: Sequence[int], now_s: float) -> None:
        for at, (slot, count) in enumerate(zip(slots, counts, strict=True)):
            if mask >> at & 1:
                self.counts[slot] = count
        self.in_force.append((now_s, tuple(self.counts)))
        self.robot.set_values(self._wire.values(Array(0, tuple(self.counts))))
        if any(self.counts[slot] for slot in self.wheels):
            self.still_since_s = inf
        else:
            self.still_since_s = min(self.still_since_s, now_s)

    def _read(self, turn: CycleReading, now_s: float) -> list[float] | None:
        self.robot.electronics.read(turn.first, turn.last)
        return self.robot.read(now_s, turn)


def _cycles(time_s: float) -> int:
    return round(time_s * HERTZ)
