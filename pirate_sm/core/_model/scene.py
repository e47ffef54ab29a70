"""Scenes of the gallery: command lines of this program, and what should come of each."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints

from pirate_sm.core._model.base import FaultCode, Format, Frozen, Name
from pirate_sm.core._model.quantities import Flag

Line: TypeAlias = Annotated[str, StringConstraints(min_length=1, max_length=400)]
Extra: TypeAlias = Literal["physics", "serial", "vision"]
"""An extra that a scene needs; without it the scene is left out."""


class Expected(Frozen):
    """What should come of a step.

    The last setpoints of every recorded run must let the wheels stand; this needs no key.

    Attributes:
        exit: The exit code.
        ended: How the recorded run ends.
        says: Text in the reason of its end, or in the output of a command that records nothing.
        faults: Faults that the run reports, at least these.
        held: Whether the robot is held at the end of a recorded run, by the simulator's truth.
    """

    exit: Annotated[int, Field(ge=0, le=255)] = 0
    ended: Literal["succeeded", "failed", "interrupted", "fault"] | None = None
    says: str = ""
    faults: tuple[FaultCode, ...] = ()
    held: Flag = True


class SceneStep(Frozen):
    """A step of a scene.

    Attributes:
        about: What happens now, in a sentence.
        command: A command line of this program. ``{out}`` is the scene's folder for output,
            ``{here}`` the folder of the scene's file. A run gets the scene's speed; one that is to
            be judged has ``--record``.
        power_cut_in: A phase of the recorded mission in which the run is killed, as by a power cut.
            Nothing else is expected of the step then.
        expect: What should come of it.
    """

    about: Line | None = None
    command: Line
    power_cut_in: Name | None = None
    expect: Expected = Expected()


class Scene(Frozen):
    """A scene of the gallery, played by ``pirate demo``.

    Attributes:
        format: Version of this format.
        scene: Name of the scene, as its file.
        title: What happens, in a line.
        look_at: What to look at, in some sentences.
        needs: Extras that must be installed.
        speed: Mission seconds per second while somebody watches.
        steps: What is done, in order.
    """

    format: Format
    scene: Name
    title: Line
    look_at: Annotated[str, StringConstraints(min_length=1, max_length=1_000)]
    needs: tuple[Extra, ...] = ()
    speed: Annotated[float, Field(gt=0, le=100)] = 2.0
    steps: Annotated[tuple[SceneStep, ...], Field(min_length=1)]
