"""The settings: defaults of options from a user's file and a project's, read when needed.

``docs/settings.md`` says what can be set, and who may set what.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pirate_sm.checking.permissions import SIMULATED, is_below
from pirate_sm.core.on_disk import is_there
from pirate_sm.core.palette import THEMES, USUAL

if TYPE_CHECKING:
    from pirate_sm.core.documents import Place, Problem
    from pirate_sm.core.errors import PirateError


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
    from pirate_sm.core.registry import points_of
    from pirate_sm.robot import part_names

    return sorted(
        {*part_names.BACKENDS, *(point.name for point in points_of(part_names.BACKEND_GROUP))}
    )


SETTINGS: Mapping[str, Setting] = {
    "robot": Setting("the robot where neither a mission nor an option names one"),
    "backend": Setting("what runs a mission, and the console", "sim", _backends),
    "port": Setting("the port of the real robot"),
    "runs": Setting("the folder for recordings", "runs"),
    "theme": Setting("the console's colours", USUAL, lambda: THEMES),
    "trusted": Setting("folders whose pirate.toml may reach a robot", only_user=True),
}


def expanded(path: str) -> str:
    """Return a path with the user's home instead of `~`; as it is if nobody has that home."""
    try:
        return str(Path(path).expanduser()) if path.startswith("~") else path
    except RuntimeError:
        return path


class SettingValue(NamedTuple):
    """An active setting.

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
        from pirate_sm.core.documents import Place, Problem

        place = self.place or Place(self.source)
        return Problem(code, place, message, expected, excerpt=self.excerpt)


PROJECT_FILE = "pirate.toml"
USER_FILE = "config.toml"
RUNS_VARIABLE = "PIRATE_SM_RUNS"
"""Names the folder for recordings, before any file; empty: no recording by default."""

ROBOT_BY_OPTION = frozenset({"doctor", "calibrate", "bay", "camera calibrate", "camera survey"})
"""Commands whose option ``--robot`` says which robot it is, instead of the first one shipped."""

RUNNING = frozenset({"run", "console"})


def user_file() -> Path:
    """Return the path of the user's own file, which may not exist."""
    from platformdirs import user_config_path

    return user_config_path("pirate_sm", appauthor=False) / USER_FILE


def project_file() -> Path | None:
    """Return the file of the project: in the working folder or the nearest one above it."""
    try:
        here = Path.cwd()
    except OSError:  # the working folder is gone
        return None
    files = (folder / PROJECT_FILE for folder in (here, *here.parents))
    # A folder or a broken link of this name is reported by whoever reads the file.
    return next((file for file in files if is_there(file)), None)


def values() -> dict[str, SettingValue]:
    """Return every setting with where it comes from: environment, project, person, built in.

    Raises:
        LoadError: A file has faults; it lists those of both.
    """
    user, project = user_file(), project_file()
    found = {name: SettingValue(each.usual, BUILT_IN) for name, each in SETTINGS.items()}
    found["trusted"] = SettingValue((), BUILT_IN)
    if is_there(user) or project is not None:
        from pirate_sm.cli.settings_file import read_settings

        of_user, of_project = read_settings(user, project)
        found |= of_user
        if project is not None:
            found |= {
                name: each._replace(
                    project=True, refused=_refused(name, each.value, project, found["trusted"])
                )
                for name, each in of_project.items()
            }
    runs = _runs_of_environment()
    return found if runs is None else found | {"runs": runs}


def _runs_of_environment() -> SettingValue | None:
    """Return the folder for recordings that the environment names; None if it names none."""
    given = os.environ.get(RUNS_VARIABLE)
    return None if given is None else SettingValue(expanded(given), RUNS_VARIABLE)


def _refused(name: str, value: str, project: Path, trusted: SettingValue) -> str:
    """Return why a project's value must not be used; empty if it may be.

    What comes with files of others must not reach a robot, nor write outside of its folder.
    """
    folder = project.parent
    if any(is_below(folder, Path(expanded(each))) for each in trusted.value):
        return ""
    if name == "port" or (name == "backend" and value not in SIMULATED):
        return "reaches a robot"
    if name == "robot" and not _is_shipped(value):
        return "is not a bundled robot, which a real one would be driven by"
    if name == "runs" and not is_below(Path(value), folder):
        return "is outside of the project"
    return ""


def _is_shipped(robot: str) -> bool:
    from pirate_sm.core import library

    return robot in {path.name for path in library.robots()} and not is_there(Path(robot))


def used(names: Collection[str], found: Mapping[str, SettingValue]) -> dict[str, str]:
    """Return the values of settings for a command that uses them, and say what a project sets.

    Raises:
        LoadError: A project's file sets some that it may not; it lists all.
    """
    from pirate_sm.cli.errors import say

    refuse(names, found)
    for name in names:
        if found[name].project:
            say(f"{name} = '{found[name].value}', from {found[name].source}")
    return {name: str(found[name].value) for name in names}


def refuse(names: Collection[str], found: Mapping[str, SettingValue]) -> None:
    """Refuse settings that a project's file must not set.

    Raises:
        LoadError: There are some; it lists all.
    """
    from pirate_sm.core.documents import LoadError

    if problems := refused(names, found):
        raise LoadError(problems)


def refused(names: Collection[str], found: Mapping[str, SettingValue]) -> list[Problem]:
    """Return the problems with settings that a project's file must not set."""
    return [
        found[name].problem(
            "settings.untrusted",
            f"{name} = '{found[name].value}' {found[name].refused}, and this folder is not "
            f"trusted: give it on the command line, or add the folder to `trusted` in "
            f"{user_file()}",
        )
        for name in names
        if found[name].refused
    ]


def runs() -> SettingValue:
    """Return the folder for recordings, and say it if a project sets it; empty: none are kept.

    Raises:
        LoadError: A file of settings has faults, or a project's may not set it.
    """
    given = _runs_of_environment()
    if given is not None:
        return given
    found = values()
    used(["runs"], found)
    return found["runs"]


def unusable_runs(found: SettingValue, why: str, otherwise: str) -> PirateError:
    """Return the error for a folder that somebody has set and that cannot be written to.

    Args:
        found: The setting.
        why: Why it cannot be written to.
        otherwise: The option that does without it, and what it does.
    """
    from pirate_sm.core.documents import LoadError

    message = f"recordings cannot be kept in '{found.value}': {why}; nothing has moved"
    expected = f"a folder that can be written to; {otherwise}"
    return LoadError([found.problem("settings.runs", message, expected)])


def with_settings(
    command: str, given: Mapping[str, Any], is_given: Callable[[str], bool]
) -> dict[str, Any]:
    """Return the options of a command, with settings for those that are not on its command line.

    Args:
        command: Its name.
        given: All its options with their values.
        is_given: Whether an option is on the command line.

    Raises:
        LoadError: A file of settings has faults, or a project's sets what it may not.
    """
    options = dict(given)
    wanted = [name for name in _options_set(command, given) if not is_given(name)]
    if not wanted:
        return options
    found = {name: each for name, each in values().items() if each.source != BUILT_IN}
    chosen = [name for name in wanted if name in found]
    if "backend" in chosen:
        options["backend"] = found["backend"].value
    if _simulates(options):
        chosen = [name for name in chosen if name != "port"]
    kept = ["runs"] if "runs" in found and _is_recorded(command, given) else []
    refuse([*chosen, *kept], found)
    return options | used(chosen, found)


def _options_set(command: str, given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the options of a command that settings fill; the backend comes before the port."""
    resumes = given.get("resume") is not None  # the recording says what is run
    if command in RUNNING and not resumes:
        yield "backend"
    if "theme" in given:
        yield "theme"
    if "port" in given and not resumes:
        yield "port"
    by_hand = command == "console" and given.get("mission") is None and not resumes
    if command in ROBOT_BY_OPTION or by_hand:
        yield "robot"


def _is_recorded(command: str, given: Mapping[str, Any]) -> bool:
    """Return whether the command writes to the folder for recordings."""
    by_hand = command == "console" and given.get("mission") is None and not given.get("resume")
    named = given.get("record") is not None or given.get("no_record")
    return command in RUNNING and not named and not by_hand


def _simulates(options: Mapping[str, Any]) -> bool:
    return options.get("backend") in SIMULATED
