"""The settings that there are, and a setting in force."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pirate_sm.palette import THEMES, USUAL

if TYPE_CHECKING:
    from pirate_sm.loading.problems import Place, Problem

BUILT_IN = "built in"
"""Where a setting comes from that nobody has set."""


@dataclass(frozen=True)
class Setting:
    """What a file may set.

    Attributes:
        about: One line about it.
        usual: Its value without any file; empty: there is none.
        names: Returns the valid names; None: any text.
        only_user: Whether a project's file may not set it at all.
    """

    about: str
    usual: str = ""
    names: Callable[[], Collection[str]] | None = None
    only_user: bool = False


def _backends() -> Collection[str]:
    from pirate_sm.backends import known
    from pirate_sm.registry import points_of

    return sorted({*known.ABOUT, *(point.name for point in points_of(known.GROUP))})


SETTINGS: Mapping[str, Setting] = {
    "robot": Setting("the robot where neither a mission nor an option names one"),
    "backend": Setting("what runs a mission, and the console", "sim", _backends),
    "port": Setting("the port of the real robot"),
    "runs": Setting("the folder for recordings", "runs"),
    "theme": Setting("the console's colours", USUAL, lambda: THEMES),
    "trusted": Setting("folders whose pirate.toml may reach a robot", only_user=True),
}


def expanded(path: str) -> str:
    """Return a path with the person's home instead of `~`; as it is if nobody has that home."""
    try:
        return str(Path(path).expanduser()) if path.startswith("~") else path
    except RuntimeError:
        return path


class Value(NamedTuple):
    """A setting in force.

    Attributes:
        value: Its value; for ``trusted`` the folders.
        source: Where it comes from: ``FILE:LINE``, a variable, or ``built in``.
        refused: Why it must not be used; empty if it may.
        project: Whether a project's file sets it.
        place: Where a file sets it; None: no file does.
        excerpt: That line of the file.
    """

    value: Any
    source: str
    refused: str = ""
    project: bool = False
    place: Place | None = None
    excerpt: str = ""

    def problem(self, code: str, message: str, expected: str = "") -> Problem:
        """Return a problem with this value, at its place."""
        from pirate_sm.loading.problems import Place, Problem

        place = self.place or Place(self.source)
        return Problem(code, place, message, expected, excerpt=self.excerpt)
