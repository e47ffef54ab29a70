"""Read panel files, and check the names in them against a robot."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.core.documents import Document, LoadError, Problems, read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.files import library
from pirate_sm.core.loading import LoadedRobot, load_robot, validate
from pirate_sm.core.panel import Button, CommandButton, Panel, RunButton, WordButton


def load_panel(path: Path, robot: LoadedRobot) -> Panel:
    """Return the panel in a file, for this robot.

    Raises:
        LoadError: The file has faults, or the robot lacks a command or a word; holds all of them.
    """
    panel, document, problems = read_panel(path)
    check_names(panel, robot, problems.about(document))
    problems.raise_errors()
    return panel.model_copy(update={"buttons": _without_aliases(panel, robot)})


def read_panel(path: Path) -> tuple[Panel, Document, Problems]:
    """Return the panel in a file, the file's document, and what is wrong with it by itself.

    Raises:
        LoadError: The file does not have the form of a panel; holds all faults.
    """
    document = read_document(path)
    panel = validate(document, Panel)
    problems = Problems(document)
    _check_controls(panel, problems)
    return panel, document, problems


def robot_of(
    panel: Panel, beside: Path, problems: Problems, *, instead: str | None
) -> LoadedRobot | None:
    """Return the robot of a panel, to check its names against; None if there is none to load.

    Args:
        panel: The panel.
        beside: Folder of its file.
        problems: Takes an unknown name.
        instead: Name or path of a robot instead of the panel's own.
    """
    name = instead or panel.robot
    if name is None:
        return None
    try:
        return load_robot(library.find_robot(name, Path.cwd() if instead else beside))
    except UsageError as error:
        problems.add("panel.robot", ("robot",), str(error))
    except LoadError:
        pass  # reported for the robot
    return None


def check_names(panel: Panel, robot: LoadedRobot, problems: Problems) -> None:
    """Report commands and words that the robot does not have."""
    profile = robot.profile
    commands, words = [*profile.commands, *profile.aliases], list(profile.detector.words)
    for name, button in panel.buttons.items():
        if isinstance(button, CommandButton) and button.command not in commands:
            path = ("buttons", name, "command")
            message = f"{profile.robot} has no command '{button.command}'"
            problems.add_unknown(
                "panel.command", path, "command", button.command, profile.commands, message=message
            )
        if isinstance(button, WordButton) and button.word not in words:
            path = ("buttons", name, "word")
            message = f"the detector of {profile.robot} has no word '{button.word}'"
            problems.add_unknown("panel.word", path, "word", button.word, words, message=message)


def _check_controls(panel: Panel, problems: Problems) -> None:
    """Report buttons that the panel does not have, and a panel that cannot stop the robot."""
    first: dict[int, str] = {}
    for name, number in panel.controls.items():
        other = first.setdefault(number, name)
        if other != name:
            message = f"{other} sends the control change {number} already"
            problems.add("panel.control", ("controls", name), message)
    for combination in panel.buttons:
        parts = combination.split("+")
        for part in parts:
            if part not in panel.controls:
                path = ("buttons", combination)
                problems.add_unknown(
                    "panel.button", path, "control", part, panel.controls, key=True
                )
        if len(set(parts)) < len(parts):
            message = "a button cannot be held down and pressed"
            problems.add("panel.button", ("buttons", combination), message, key=True)
    stops = [name for name, button in panel.buttons.items() if _stops(button)]
    for name in stops:
        if "+" in name:
            message = "a stop needs one button alone"
            problems.add("panel.stop", ("buttons", name), message, key=True)
    if not stops:
        message = "no button stops the robot"
        problems.add("panel.stop", ("buttons",), message, expected="STOP: {do: stop}", key=True)


def _stops(button: Button) -> bool:
    return isinstance(button, RunButton) and button.do == "stop"


def _without_aliases(panel: Panel, robot: LoadedRobot) -> dict[str, Button]:
    """Return the buttons with the robot's own names of commands."""
    aliases = robot.profile.aliases
    return {
        name: button.model_copy(update={"command": aliases.get(button.command, button.command)})
        if isinstance(button, CommandButton)
        else button
        for name, button in panel.buttons.items()
    }
