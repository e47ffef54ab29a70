"""A loaded robot as seen by the rules: moves of commands, writes of states, places."""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from pirate_sm.checking.findings import Finding, at
from pirate_sm.engine.robot.command_spec import Write
from pirate_sm.loading.problems import Path
from pirate_sm.loading.robot import LoadedRobot
from pirate_sm.model.motor import Motor
from pirate_sm.model.profile import Profile, Slot


class Written(NamedTuple):
    """A write of a state to a slot, with its path in the profile."""

    region: int
    state: str
    stage: int
    write: Write
    path: Path


@dataclass(frozen=True)
class RobotView:
    """A loaded robot in normal polarity."""

    loaded: LoadedRobot

    @property
    def profile(self) -> Profile:
        """Return the robot's profile."""
        return self.loaded.profile

    @cached_property
    def slots(self) -> tuple[tuple[Slot, Path], ...]:
        """Return all slots in the order of the wire, with their paths."""
        return tuple(
            (slot, ("boards", number, "slots", place))
            for number, board in enumerate(self.profile.boards)
            for place, slot in enumerate(board.slots)
        )

    @cached_property
    def written(self) -> tuple[Written, ...]:
        """Return all writes of all states."""
        found = []
        robot = self.loaded.normal
        for region, states in enumerate(robot.actuation):
            for state, stages in states.items():
                at_state: Path = ("actuation", robot.regions[region], state)
                for number, stage in enumerate(stages):
                    path = (*at_state, number) if len(stages) > 1 else at_state
                    for write in stage:
                        name = robot.slots[write.slot].name
                        found.append(Written(region, state, number, write, (*path, name)))
        return tuple(found)

    def motor(self, slot: int) -> Motor:
        """Return the motor of a slot."""
        return self.profile.motors[self.profile.slots[slot].motor]

    def moves(self, command: int) -> Iterator[tuple[int, int]]:
        """Yield each configuration that the command changes, with the one that follows."""
        for before, row in enumerate(self.loaded.table.following):
            if row[command] != before:
                yield before, row[command]

    def writes(self, configuration: int, slot: int) -> list[Written]:
        """Return the writes of a configuration's states to a slot, one for each stage."""
        states = self.loaded.table.configurations[configuration]
        return [each for each in self._by_slot.get(slot, ()) if states[each.region] == each.state]

    def duty(self, configuration: int, slot: int) -> float:
        """Return the largest possible duty cycle of a slot in a configuration."""
        found = [0.0]
        for each in self.writes(configuration, slot):
            spec = self.loaded.normal.slots[slot]
            match each.write.how:
                case "set":
                    found.append(abs(each.write.value))
                case "seek":
                    found.append(spec.position.limit if spec.position else 1.0)
                case "turn":
                    found.append(spec.velocity.limit if spec.velocity else 1.0)
                case "bear":
                    found.append(spec.held_torque.limit if spec.held_torque else 1.0)
                case "keep":
                    found.append(1.0)  # what another state has written
        return max(found)

    @cached_property
    def heard(self) -> frozenset[int]:
        """Return the indexes of numbers that fitted boards report, and those derived from them."""
        robot = self.loaded.normal
        told = {index for board in robot.boards.values() for index in board.numbers}
        told |= {index for index, _ in robot.outside.values()}
        told |= set(robot.traction.targets if robot.traction else ())
        return frozenset(told | {robot.odometry, robot.speed})

    @cached_property
    def _by_slot(self) -> dict[int, list[Written]]:
        found: dict[int, list[Written]] = {}
        for each in self.written:
            found.setdefault(each.write.slot, []).append(each)
        return found

    def configurations(self, regions: Set[str]) -> list[tuple[str, ...]]:
        """Return one reached configuration for each combination of the states of these regions."""
        table = self.loaded.table
        places = [number for number, name in enumerate(table.regions) if name in regions]
        found = {tuple(row[place] for place in places): row for row in table.configurations}
        return list(found.values())

    def at(
        self, path: Path, code: str, message: str, *, key: bool = False, offset: int | None = None
    ) -> Finding:
        """Return a finding at a value, or a key, of the profile."""
        document = self.loaded.documents[0]
        place = document.place_of(path, key=key, offset=offset)
        return at(document, place, code, message)
