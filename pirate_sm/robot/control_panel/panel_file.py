"""Control panels: their files, with what each button does, checked against a robot."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints, Tag, model_validator

from pirate_sm.core import library
from pirate_sm.core.documents import Document, LoadError, Problems, read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.fields import Duration, Format, Frozen, Name, by_key
from pirate_sm.core.loading import LoadedRobot, load_robot, validate

RunAction: TypeAlias = Literal["stop", "go", "pause", "step", "skip", "abort"]
"""What a button can do with the run itself."""

Combination: TypeAlias = Annotated[
    str,
    StringConstraints(pattern=r"^[A-Za-z][A-Za-z0-9_]*(\+[A-Za-z][A-Za-z0-9_]*)*$", max_length=128),
]
"""A button, or buttons joined by ``+``: the last one is pressed while the others are held."""


class _Button(Frozen):
    hold: Annotated[Duration, Field(ge=0, le=10)] = 0.0
    twice: bool = False


class RunButton(_Button):
    """A button that acts on the run.

    Attributes:
        do: ``stop``: the safe stop, at once. ``go``: start or resume. ``pause``. ``step``: one
            step, then pause. ``skip``: end the present wait. ``abort``: end the mission in the safe
            state.
        hold: How long the button must be held down; by default it acts when pressed.
        twice: Whether it must be pressed again within 3 s, because the first press only asks.
    """

    do: RunAction

    @model_validator(mode="after")
    def _stops_at_once(self) -> RunButton:
        if self.do == "stop" and (self.hold or self.twice):
            raise ValueError("a stop acts immediately: neither `hold` nor `twice`")
        return self


class CommandButton(_Button):
    """A button that gives the robot a command, as an operator does.

    Attributes:
        command: Name of the command.
        hold: How long the button must be held down; by default it acts when pressed.
        twice: Whether it must be pressed again within 3 s, because the first press only asks.
    """

    command: Name


class WordButton(_Button):
    """A button that says a word of the detector, where no other detector speaks.

    Attributes:
        word: The word.
        hold: How long the button must be held down; by default it acts when pressed.
        twice: Whether it must be pressed again within 3 s, because the first press only asks.
    """

    word: Name


class AnswerButton(_Button):
    """A button that gives the answer with this number to what the operator is asked.

    Attributes:
        answer: Number of the answer, from 1.
        hold: How long the button must be held down; by default it acts when pressed.
        twice: Whether it must be pressed again within 3 s, because the first press only asks.
    """

    answer: Annotated[int, Field(ge=1, le=9, strict=True)]


Button: TypeAlias = Annotated[
    Annotated[RunButton, Tag("do")]
    | Annotated[CommandButton, Tag("command")]
    | Annotated[WordButton, Tag("word")]
    | Annotated[AnswerButton, Tag("answer")],
    by_key(
        ("do", "command", "word", "answer"),
        custom_error_type="button",
        custom_error_message="expected what the button does: "
        "{do: stop}, {command: NAME}, {word: NAME} or {answer: 1}",
    ),
]


class Panel(Frozen):
    """A control panel.

    Attributes:
        format: Version of this format.
        panel: Name of the panel.
        description: One-line description.
        robot: The robot whose commands and words it names, for ``pirate check``; a run checks the
            names against its own robot.
        device: Text in the name of the controller's sound card, in ``/proc/asound/cards``.
        channel: The MIDI channel of its control changes, counted from 1.
        controls: Number of the control change that each control sends.
        buttons: What each button does. ``SET+R8`` is R8 while SET is held down. A control that is
            not named here does nothing.
    """

    format: Format
    panel: Name
    description: str = ""
    robot: str | None = None
    device: Annotated[str, Field(min_length=1, max_length=100)]
    channel: Annotated[int, Field(ge=1, le=16, strict=True)] = 1
    controls: Annotated[
        dict[Name, Annotated[int, Field(ge=0, le=127, strict=True)]], Field(min_length=1)
    ]
    buttons: Annotated[dict[Combination, Button], Field(min_length=1)]


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
