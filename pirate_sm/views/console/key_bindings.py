"""Every key of the console: those with a meaning of their own, and those made from names.

A key means one thing, so a key that answers a question never moves the robot. A letter means the
same in both cases, so Caps Lock does no harm.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from functools import lru_cache
from string import ascii_lowercase

from pirate_sm.core.robot import RobotSpec, StoppedSpec, at_rest_in

LEAVE, MISSIONS = "q", "m"
YES, NO = "y", "n"
CONTROLS: Mapping[str, str] = {
    "go": "r",
    "pause": "p",
    "step": ".",
    "skip": "k",
    "hand_back": "h",
    "abort": "x",
}
"""Keys of the controls of a mission."""

ANSWERS = frozenset([YES, NO, LEAVE, "escape", "enter", *"123456789"])
"""Keys that answer a question; no command, control or word of a detector has one of them."""

RESERVED = frozenset([*ANSWERS, MISSIONS, *CONTROLS.values()])
"""Keys that no command and no word of a detector gets."""

_SIGNS = ",;'[]"
"""Keys for names when there are no more letters."""


def letters_for(names: Sequence[str]) -> dict[str, str]:
    """Return a lower-case letter for each name, in order, as far as there are letters and signs.

    The first that is free of: the capitals of the name, its other letters, the rest of the
    alphabet from its end, some signs.
    """
    free = [key for key in ascii_lowercase + _SIGNS if key not in RESERVED]
    found: dict[str, str] = {}
    for name in names:
        capitals = [letter.lower() for letter in name if letter.isupper()]
        wanted = (*capitals, *name.lower(), *reversed(ascii_lowercase), *_SIGNS)
        letter = next((each for each in wanted if each in free), None)
        if letter is None:
            break
        free.remove(letter)
        found[name] = letter
    return found


def both_cases(letter: str) -> str:
    """Return the keys of a letter in both cases, for a binding; of a sign its name."""
    if letter.isalpha():
        return f"{letter},{letter.upper()}"
    return unicodedata.name(letter).lower().replace("-", "_").replace(" ", "_")


def arrows_for(robot: RobotSpec) -> dict[str, str]:
    """Return the command of each arrow key: up and down drive, left and right brake."""
    found: dict[str, str] = {}
    for command in robot.commands:
        if isinstance(command.done, StoppedSpec):
            found.setdefault("left", command.name)
            found.setdefault("right", command.name)
    for name, way in ways(robot).items():
        found.setdefault("up" if way > 0 else "down", name)
    return found


@lru_cache(maxsize=8)
def ways(robot: RobotSpec) -> dict[str, int]:
    """Return the commands that drive: 1 forward, -1 backward."""
    found: dict[str, int] = {}
    for index, command in enumerate(robot.commands):
        for here in range(len(robot.table.configurations)):
            target = robot.table.follow(here, index)
            if robot.driven[target].keys() - robot.driven[here].keys():
                travel = robot.travel(at_rest_in(robot, target).values)
                if travel:
                    found.setdefault(command.name, travel)
    return found
