"""A small rosserial device and a line to it, in virtual time; made for the tests of the driver."""

from __future__ import annotations

import heapq
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from math import inf
from random import Random

from pirate_sm.core.errors import BackendError
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.backends.serial.port import PortLostError
from pirate_sm.robot.rosserial.frames import Decoder, encode

NUMBERS = {"setpoints": 100, "state": 125, "echo": 126}


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def introduction(number: int, name: str, kind: str, md5: str, room: int = 512) -> bytes:
    return struct.pack("<H", number) + text(name) + text(kind) + text(md5) + struct.pack("<i", room)


@dataclass
class Device:
    """Says what a bay says, does nothing else.

    Attributes:
        applied: (time, wire id, counts) of every array that was executed.
        boards: Raw values by board; what it reports in turn.
        received: (time, topic, payload) of every frame.
    """

    plan: LinkPlan
    boot_s: float = 1.0
    echo_s: float = 0.05
    cycle_s: float = 0.016
    md5: dict[str, str] = field(default_factory=dict)
    topics: tuple[str, ...] = ("state", "echo", "setpoints")
    boards: dict[int, list[float]] = field(default_factory=dict)
    speaks: bool = True
    before_frame: Callable[[float], None] = lambda now: None

    def __post_init__(self) -> None:
        self.applied: list[tuple[float, int, tuple[int, ...]]] = []
        self.received: list[tuple[float, int, bytes]] = []
        self.requests = 0
        self.boards = self.boards or {b: [0.0] * n for b, n in self.plan.channels.items()}
        self.reset(0.0)

    def reset(self, now: float) -> None:
        self.up_s = now + self.boot_s
        self.configured = False
        self.decoder = Decoder()
        self.next_s = self.up_s + self.cycle_s
        self.turn = 0
        self.echoes: list[tuple[float, bytes]] = []
        self.hung_until_s = -inf

    @property
    def due_s(self) -> float:
        due = min([self.next_s] + [at for at, _ in self.echoes])
        return max(due, self.hung_until_s)

    def receive(self, data: bytes, now: float) -> list[bytes]:
        if now < self.up_s or now < self.hung_until_s:
            return []
        out: list[bytes] = []
        for topic, payload in self.decoder.feed(data):
            self.received.append((now, topic, payload))
            if topic == 0:
                self.requests += 1
                self.configured = True
                out += self.introduce()
            elif topic == NUMBERS["setpoints"]:
                number, counts, _ = self.plan.messages.setpoints.unpack(payload)
                self.applied.append((now, number, counts))
                if self.configured:
                    self.echoes.append((now + self.echo_s, payload))
            elif topic == 11:
                self.configured = False
        return out

    def introduce(self) -> list[bytes]:
        serial, messages = self.plan.serial, self.plan.messages
        out = [encode(10, bytes(8))]
        known = {
            "state": (0, serial.state.topic, messages.state.type),
            "echo": (0, serial.echo.topic, messages.echo.type),
            "setpoints": (1, serial.setpoints.topic, messages.setpoints.type),
        }
        for name in self.topics:
            way, topic, kind = known[name]
            md5 = self.md5.get(name, kind.md5)
            out.append(encode(way, introduction(NUMBERS[name], topic, kind.name, md5)))
        return out

    def run(self, now: float) -> list[bytes]:
        """What it says at a time that is due."""
        out: list[bytes] = []
        if now < self.hung_until_s:
            return out
        while self.next_s <= now:
            self.next_s = max(self.next_s + self.cycle_s, now - self.cycle_s)
            if self.configured and self.speaks and self.boards:
                self.before_frame(now)
                out.append(encode(NUMBERS["state"], self.state()))
        for at, payload in self.echoes:
            if at <= now and self.configured:
                out.append(encode(NUMBERS["echo"], payload))
        self.echoes = [(at, payload) for at, payload in self.echoes if at > now]
        return out

    def state(self) -> bytes:
        self.turn += 1
        if self.plan.serial.state.layout == "value":
            places = [(b, c) for b, values in self.boards.items() for c in range(len(values))]
            board, channel = places[self.turn % len(places)]
            return struct.pack("<BBf", board, channel, self.boards[board][channel])
        board = sorted(self.boards)[self.turn % len(self.boards)]
        noise = self.turn // len(self.boards) % 2  # a live sensor's last digit is never still
        values = [*(value + noise for value in self.boards[board]), *[0.0] * 9][:9]
        return struct.pack("<B9f", board, *values)


class VirtualPort:
    """A line to a device, with loss, damage and delay from a seed."""

    name = "virtual"
    epoch_s = 1.7e9

    def __init__(
        self,
        device: Device | None,
        *,
        seed: int = 0,
        loss: float = 0.0,
        damage: float = 0.0,
        jitter_s: float = 0.0,
        baud: int = 57600,
    ) -> None:
        self.device = device
        self.random = Random(seed)
        self.loss, self.damage, self.jitter_s = loss, damage, jitter_s
        self.byte_s = 10 / baud
        self.time_s = 0.0
        self.free_s = {"host": 0.0, "device": 0.0}
        self.mail: list[tuple[float, int, str, bytes]] = []
        self.count = 0
        self.written: list[tuple[float, bytes]] = []
        self.deaf_until_s = -inf
        self.plugged = True
        self.opened = 0
        self.closed = self.stopped = False
        self.safe_frame = b""
        self.noise = b""
        self.refuses: str = ""

    def now(self) -> float:
        return self.time_s

    def open(self) -> None:
        if self.refuses:
            raise BackendError(self.refuses)
        self.opened += 1
        if self.device is not None:
            self.device.reset(self.time_s)

    def reopen(self) -> bool:
        if self.plugged:
            self.open()
        return self.plugged

    def write(self, data: bytes) -> None:
        if not self.plugged:
            raise PortLostError("unplugged")
        self.written.append((self.time_s, data))
        self.post("device", data)

    def read(self, until_s: float) -> bytes:
        if not self.plugged:
            raise PortLostError("unplugged")
        return self.run(until_s)

    def wait(self, until_s: float) -> None:
        data = b"-"
        while data:
            data = self.run(until_s)

    def beat(self, safe_frame: bytes) -> None:
        self.safe_frame = safe_frame
        if not self.plugged:
            raise PortLostError("unplugged")

    def overruled(self) -> bool:
        return False

    def remark(self) -> str:
        return ""

    def close(self, stopped: bool = False) -> None:
        self.closed, self.stopped = True, stopped
        self.wait(self.time_s + 0.1)

    def post(self, whom: str, data: bytes) -> None:
        starts = max(self.time_s, self.free_s[whom])
        arrives = self.free_s[whom] = starts + len(data) * self.byte_s
        arrives += self.random.uniform(0.0, self.jitter_s)
        if self.random.random() < self.loss or self.time_s < self.deaf_until_s:
            return
        if self.damage:
            data = bytes(
                self.random.randrange(256) if self.random.random() < self.damage else byte
                for byte in data
            )
        self.count += 1
        heapq.heappush(self.mail, (arrives, self.count, whom, data))

    def run(self, until_s: float) -> bytes:
        while True:
            mail_s = self.mail[0][0] if self.mail else inf
            device_s = self.device.due_s if self.device is not None else inf
            next_s = min(mail_s, device_s)
            if next_s > until_s:
                assert until_s < inf, "nothing will ever happen"
                self.time_s = max(self.time_s, until_s)
                return b""
            self.time_s = max(self.time_s, next_s)
            if mail_s <= device_s:
                _, _, whom, data = heapq.heappop(self.mail)
                if whom == "host" and self.plugged:
                    return data
                if whom == "device" and self.device is not None:
                    for answer in self.device.receive(data, self.time_s):
                        self.post("host", answer)
            elif self.device is not None:
                for said in self.device.run(self.time_s):
                    self.post("host", said)
