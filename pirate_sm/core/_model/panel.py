"""Control panels: which buttons a MIDI controller has, and what each of them does."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints, Tag, model_validator

from pirate_sm.core._model.base import Format, Frozen, Name, by_key
from pirate_sm.core._model.quantities import Duration

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
