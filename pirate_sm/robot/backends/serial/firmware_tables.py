"""A robot's tables for the firmware in ``firmware/``: a header of C++, written from its files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple
from zlib import crc32

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Profile
from pirate_sm.robot.backends.serial.link.link_plan import LinkPlan
from pirate_sm.robot.rosserial.message_types import MessageType

_MOST_SLOTS = 32
"""The firmware keeps one bit per slot in a word."""

_MOST_BYTES = 120
"""The longest payload that the firmware takes or sends; ``firmware/src/frame.h``."""

_WIDEST = 4
"""Bytes of the widest number that an 8-bit controller is to handle."""

_MOST_SLOTS_OF_A_BOARD, _MOST_CHANNELS = 8, 24
"""What fits into a frame of the bus; ``firmware/src/rs485.h``."""

_MOST_COUNT = 2**31 - 1
"""The largest count that a board reports."""

Constants = Iterator[tuple[str, int | str]]
"""Constants of C++, each with its value."""


def firmware_header(profile: Profile, plan: LinkPlan) -> str:
    """Return the header of this robot.

    Raises:
        UsageError: The firmware cannot be that of this robot.
    """
    tables = _tables(profile, plan)
    name, total = profile.robot, _sum(tables)
    return "\n".join((
        f"// Tables of a robot, written by `pirate firmware {name} -o robot.h`: do not edit them.",
        *("#pragma once", "", "#include <stdint.h>", "", "namespace robot {", ""),
        f'constexpr char TABLES[] = "{total}";  // CRC-32 of what follows, without comments',
        f'constexpr char NAME_AND_TABLES[] = "{tables_of(profile, plan)}";',
        *("", tables, "", "}  // namespace robot", ""),
    ))  # fmt: skip


def tables_of(profile: Profile, plan: LinkPlan) -> str:
    """Return what a firmware with this robot's tables says of them.

    Any change of the robot's files that the firmware must know changes it.
    """
    try:
        total = _sum(_tables(profile, plan))
    except UsageError:  # it cannot be such a firmware
        total = "none"
    return f"robot {profile.robot}, tables {total}"


_GREETING = re.compile(r"firmware \S+ of (robot \S+, tables \S+)")


def said_tables(line: str) -> str:
    """Return the tables that a firmware names in this line of its log; empty if it names none."""
    found = _GREETING.fullmatch(line)
    return found[1] if found else ""


def _sum(tables: str) -> str:
    constants = (line for line in tables.splitlines() if not line.startswith("//"))
    return f"{crc32(''.join(constants).encode()):08x}"


def _tables(profile: Profile, plan: LinkPlan) -> str:
    lines = [
        *_written("The line, and times", _times(profile, plan)),
        *_written("Topics and their definitions", _topics(plan)),
        *_written(
            "The array of setpoints, and its echo, which has the same fields", _array(profile, plan)
        ),
        *_written("The state message", _state(profile, plan)),
        *_boards(profile),
    ]
    return "\n".join(lines)


def _written(title: str, constants: Constants) -> Iterator[str]:
    yield f"// {title}"
    yield from (f"constexpr {name} = {value};" for name, value in constants)
    yield ""


def _times(profile: Profile, plan: LinkPlan) -> Constants:
    stop_after = plan.serial.stop_after
    if stop_after is None:
        raise UsageError(
            f"{profile.robot}: this firmware has a dead man's switch; say in section 'serial' of "
            "the profile when it acts: stop_after, refresh_every"
        )
    yield "uint32_t BAUD", plan.serial.baud
    yield "uint16_t STOP_AFTER_MS", round(stop_after * 1e3)
    yield "uint32_t CYCLE_US", round(profile.link.cycle * 1e6)


def _topics(plan: LinkPlan) -> Constants:
    for name, wanted in zip(("ARRAY", "ECHO", "STATE"), plan.wanted, strict=True):
        yield f"char {name}_TOPIC[]", f'"{wanted.name}"'
        yield f"char {name}_TYPE[]", f'"{wanted.type}"'
        yield f"char {name}_MD5[]", f'"{wanted.md5}"'


# --- messages -------------------------------------------------------------------------------------


class _Place(NamedTuple):
    """Where a field is in a payload.

    Attributes:
        at: Its first byte, behind the count of an array that may have any count.
        bytes: Of one number.
        end: The byte after it.
        counted: Whether the count is there.
    """

    at: int
    bytes: int
    end: int
    counted: bool

    def constants(self, name: str) -> Constants:
        """Yield the constants that say so."""
        yield f"uint8_t {name}_AT", self.at
        yield f"uint8_t {name}_BYTES", self.bytes


_NOWHERE = _Place(0, 0, 0, counted=False)


def _places(kind: MessageType, any_count: int) -> dict[str, _Place]:
    """Return the places of a message's fields; arrays of any count have ``any_count`` numbers."""
    found: dict[str, _Place] = {}
    end = 0
    for name in kind.fields:
        number, size = kind.field(name)
        width, counted = np.dtype(number).itemsize, size == 0
        at = end + 4 * counted
        end = at + width * (1 if size is None else size or any_count)
        found[name] = _Place(at, width, end, counted)
        if width > _WIDEST:
            raise UsageError(f"{kind.name}.msg: the firmware knows no {number} as '{name}' has")
    if end > _MOST_BYTES:
        raise UsageError(f"{kind.name}.msg: the firmware has no room for its {end} bytes")
    return found


def _array(profile: Profile, plan: LinkPlan) -> Constants:
    codec, echo, topic = plan.messages.setpoints, plan.messages.echo, plan.serial.setpoints
    again = plan.serial.echo
    if (topic.id, topic.values, topic.hold, list(codec.type.fields.items())) != (
        *(again.id, again.values, again.hold),
        list(echo.type.fields.items()),
    ):
        raise UsageError(f"{echo.type.name}.msg must have the fields of {codec.type.name}.msg")
    slots, zero = profile.slots, set(profile.safe_state.zero)
    if len(slots) > _MOST_SLOTS:
        raise UsageError(f"the firmware handles {_MOST_SLOTS} slots, not {len(slots)}")
    places = _places(codec.type, len(slots))
    values, hold = places[topic.values], places.get(topic.hold, _NOWHERE)
    limits = [round(slot.limit / slot.resolution) for slot in plan.slots]
    if max(limits) > np.iinfo(np.int16).max:
        raise UsageError("the firmware handles setpoints of 16 bits: make the resolution coarser")
    yield "uint8_t SLOTS", len(slots)
    yield "uint8_t ARRAY_BYTES", max(place.end for place in places.values())
    yield from places[topic.id].constants("ARRAY_ID")
    yield from values.constants("ARRAY_VALUES")
    yield "bool ARRAY_COUNTED", _boolean(values.counted)
    yield from hold.constants("ARRAY_HOLD")
    yield "uint8_t ARRAY_HOLD_SHIFT", codec.id_bits if topic.hold == topic.id else 0
    yield "uint32_t HELD_WITHOUT_MASK", _bits(slot.name not in zero for slot in slots)
    yield "uint32_t OWN_CONTROLLER", _bits(slot.unit == "angle" for slot in slots)
    yield "int16_t LIMITS[]", _listed(limits)


def _state(profile: Profile, plan: LinkPlan) -> Constants:
    kind, topic = plan.messages.state.type, plan.serial.state
    one = topic.layout == "value"
    places = _places(kind, 1 if one else max(plan.channels.values(), default=0))
    name = topic.value if one else topic.values
    values, end = places[name], max(place.end for place in places.values())
    if values.counted and values.end < end:
        raise UsageError(f"{kind.name}.msg: '{name}' may have any count, so it must be the last")
    number = np.dtype(kind.field(name).kind)
    limits = np.iinfo(number) if number.kind in "iu" else None
    yield "bool STATE_ONE_VALUE", _boolean(one)
    yield "uint8_t STATE_BYTES", end
    yield from places[topic.board].constants("STATE_BOARD")
    yield from (places[topic.channel] if one else _NOWHERE).constants("STATE_CHANNEL")
    yield from values.constants("STATE_VALUES")
    yield "bool STATE_COUNTED", _boolean(values.counted)
    yield "bool STATE_IS_FLOAT", _boolean(limits is None)
    yield "int32_t STATE_LEAST", max(limits.min, -_MOST_COUNT) if limits else 0
    yield "int32_t STATE_MOST", min(limits.max, _MOST_COUNT) if limits else 0


# --- boards ---------------------------------------------------------------------------------------


def _boards(profile: Profile) -> Iterator[str]:
    rows: list[tuple[int, int, int, int]] = []
    first = 0
    for board in profile.boards:
        channels = len(board.channels) if board in profile.heard else 0
        if board.fitted:
            rows.append((board.id, first, len(board.slots), channels))
        first += len(board.slots)
    slots, most = max(row[2] for row in rows), max(row[3] for row in rows)
    if slots > _MOST_SLOTS_OF_A_BOARD or most > _MOST_CHANNELS:
        raise UsageError(
            f"a board of this firmware has at most {_MOST_SLOTS_OF_A_BOARD} slots and "
            f"{_MOST_CHANNELS} channels"
        )
    yield "// The boards on the bus, in the order in which they are read"
    yield "struct Board {"
    yield "  uint8_t id, first_slot, slots, channels;"
    yield "};"
    yield f"constexpr uint8_t BOARD_COUNT = {len(rows)};"
    yield f"constexpr uint8_t MOST_SLOTS = {slots};"
    yield f"constexpr uint8_t MOST_CHANNELS = {most};"
    yield "constexpr Board BOARDS[] = {"
    yield from (f"    {_listed(row)}," for row in rows)
    yield "};"


def _boolean(value: bool) -> str:
    return str(value).lower()


def _bits(values: Iterable[bool]) -> str:
    return f"0x{sum(value << at for at, value in enumerate(values)):x}"


def _listed(values: Iterable[int]) -> str:
    return f"{{{', '.join(map(str, values))}}}"
