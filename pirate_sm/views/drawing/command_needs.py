"""What a command requires in general, and where it leads: from the table of all configurations."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import product
from math import prod
from typing import NamedTuple, TypeAlias

from pirate_sm.core.robot import RobotSpec, RobotState, StageSpec, Write, refusal

States: TypeAlias = tuple[str, ...]

Need: TypeAlias = Mapping[int, States]
"""The allowed states by region; a region that is not listed may be in any state."""


class Needs(NamedTuple):
    """The configurations in which a command is possible while every clamp is confirmed.

    Attributes:
        any_of: The command is possible where one of these holds; empty: it is never possible.
        unless: If given, the command is possible everywhere but here.
        partly: Whether the command is refused in some configurations that ``any_of`` describes.
    """

    any_of: tuple[Need, ...]
    unless: Need | None = None
    partly: bool = False


class RegionChange(NamedTuple):
    """The effect of a command on one region.

    Attributes:
        before: States from which the command leads to ``after``.
        after: The state that follows.
        sometimes: Whether it depends on the other regions that the region changes at all.
        slots: Slots that get another value or a target angle.
    """

    region: int
    before: States
    after: str
    sometimes: bool
    slots: tuple[int, ...]


def taken_in(robot: RobotSpec, command: int) -> tuple[int, ...]:
    """Return the configurations in which the command is possible with every clamp confirmed."""
    return tuple(
        index
        for index in range(len(robot.table.configurations))
        if not refusal(robot, RobotState(index, ()), command)  # whatever the setpoints are
    )


def needs(robot: RobotSpec, command: int) -> Needs:
    """Return what a command requires, as the shortest exact description."""
    accepted = set(taken_in(robot, command))
    if not accepted:
        return Needs(())
    whole = _box(robot, accepted)
    if _exact(robot, whole, accepted):
        return Needs((_told(robot, whole),))
    refused = set(range(len(robot.table.configurations))) - accepted
    outside = _box(robot, refused)
    if _exact(robot, outside, refused):
        return Needs(({},), _told(robot, outside))
    found = [
        groups
        for region in range(len(robot.regions))
        if (groups := _grouped(robot, region, accepted)) is not None
    ]
    if not found:
        return Needs((_told(robot, whole),), partly=True)
    return Needs(tuple(_told(robot, box) for box in min(found, key=len)))


def changes(robot: RobotSpec, command: int) -> tuple[RegionChange, ...]:
    """Return the effects of the command on the regions, in the order of the chart."""
    table = robot.table
    moves: dict[tuple[int, str, str], None] = {}
    for index in taken_in(robot, command):
        after = table.configurations[table.follow(index, command)]
        for region, before in enumerate(table.configurations[index]):
            moves[region, before, after[region]] = None
    found = []
    for region, names in enumerate(table.states):
        for target in names:
            sources = [name for name in names if (region, name, target) in moves and name != target]
            stays = [name for name in sources if (region, name, name) in moves]
            for sometimes, some in ((False, [n for n in sources if n not in stays]), (True, stays)):
                if some:
                    slots = _moved(robot.actuation[region], some, target)
                    found.append(RegionChange(region, tuple(some), target, sometimes, slots))
    return tuple(found)


def _moved(
    actuation: Mapping[str, tuple[StageSpec, ...]], before: Iterable[str], after: str
) -> tuple[int, ...]:
    """Return the slots that a state writes differently from the states before it."""
    writes = [write for stage in actuation[after] for write in stage]
    slots: set[int] = set()
    for state in before:
        left = {write.slot: _left(write) for write in actuation[state][-1]}
        slots |= {
            write.slot
            for write in writes
            if write.how == "seek" or (write.how != "keep" and _left(write) != left[write.slot])
        }
    return tuple(sorted(slots))


def _left(write: Write) -> tuple[str, float]:
    """Return what is active once its command is done: a value, a level, or a kept speed."""
    left = write.how in ("set", "turn", "bear", "level")
    return (write.how, write.value) if left else ("set", 0.0)


def _box(robot: RobotSpec, accepted: Collection[int]) -> tuple[States, ...]:
    """Return for each region its states in these configurations."""
    seen = [robot.table.configurations[each] for each in accepted]
    return tuple(
        tuple(name for name in names if any(states[region] == name for states in seen))
        for region, names in enumerate(robot.table.states)
    )


def _exact(robot: RobotSpec, box: Sequence[States], accepted: Collection[int]) -> bool:
    """Return whether the configurations inside the box are exactly the accepted ones."""
    if prod(map(len, box)) <= len(robot.table.configurations):
        inside = {robot.table.index_of(states) for states in product(*box)} - {None}
        return inside == set(accepted)
    return all(
        index in accepted
        for index, states in enumerate(robot.table.configurations)
        if all(name in names for name, names in zip(states, box, strict=True))
    )


def _grouped(
    robot: RobotSpec, region: int, accepted: Collection[int]
) -> list[tuple[States, ...]] | None:
    """Return exact boxes, one for each group of states of the region; None if there are none."""
    groups: dict[tuple[States, ...], list[str]] = {}
    for name in robot.table.states[region]:
        some = {each for each in accepted if robot.table.configurations[each][region] == name}
        if not some:
            continue
        box = _box(robot, some)
        if not _exact(robot, box, some):
            return None
        groups.setdefault((*box[:region], *box[region + 1 :]), []).append(name)
    return [(*rest[:region], tuple(names), *rest[region:]) for rest, names in groups.items()]


def _told(robot: RobotSpec, box: Sequence[States]) -> Need:
    """Return the regions that a box restricts, with their allowed states."""
    return {
        region: names
        for region, names in enumerate(box)
        if len(names) < len(robot.table.states[region])
    }
