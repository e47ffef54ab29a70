"""What the files of all experiments say, and of those that run missions in the simulator."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pirate_sm.core.profile import Format, Frozen, Name
from pirate_sm.core.quantities import Angle, Count, Duration, Length, Number, Speed
from pirate_sm.core.simulation import DefectText
from pirate_sm.lab.experiments.thesis_rows import ThesisRow


class ExperimentSetup(Frozen):
    """An experiment of a thesis.

    Attributes:
        format: Version of this file's format.
        experiment: Its number in the thesis.
        title: What it is about.
        rows: The thesis's values and claims.
    """

    format: Format
    experiment: Count
    title: str
    rows: tuple[ThesisRow, ...] = ()


class MissionSetup(ExperimentSetup):
    """An experiment that runs missions in the simulator.

    Attributes:
        missions: By the parts of the experiment.
        defects: That the robot had.
        seen: Parts that are run once more as a camera sees them, with the name of the camera; the
            values are named after the part and ``seen``.
    """

    missions: dict[str, Name]
    defects: tuple[DefectText, ...] = ()
    seen: dict[str, Name] = {}  # noqa: RUF012 - pydantic copies it


class PostProcessing(Frozen):
    """How signals are made comparable (thesis section 5-5).

    Attributes:
        step: Of the time to which all is interpolated.
        window: Of the moving average.
        still_below: Below this speed of the robot the slip ratio is unknown.
        driving_above: Above this speed of the robot it drives.
        most_ratio: A slip ratio beyond this, either way, does not count in the first statistic.
        every: Each point of this number is used for fits: 10 is every tenth.
    """

    step: Annotated[Duration, Field(gt=0)]
    window: Annotated[Duration, Field(gt=0)]
    still_below: Annotated[Speed, Field(gt=0)]
    driving_above: Annotated[Speed, Field(gt=0)]
    most_ratio: Annotated[Number, Field(gt=0)]
    every: Annotated[Count, Field(ge=1)]


class FurtherRun(Frozen):
    """A part of an experiment once more, on another backend and in another pipe.

    Attributes:
        backend: Name of the backend.
        pipe: Name of the pipe.
    """

    backend: Name
    pipe: Name


class StraightPipeSetup(MissionSetup):
    """An experiment that drives up and down a straight pipe.

    Attributes:
        wheels: Those that were measured.
        shown: The part whose figures are drawn.
        processing: How signals are made comparable.
        again: Parts that are run once more; the values are named after part and backend.
    """

    wheels: tuple[Name, ...]
    shown: str
    processing: PostProcessing
    again: dict[str, FurtherRun] = {}  # noqa: RUF012 - pydantic copies it


class TiltedMission(Frozen):
    """A mission that is run at each tilt.

    Attributes:
        mission: Its name.
        holds: How long before its end it must have stood still; 0: it need not.
    """

    mission: Name
    holds: Annotated[Duration, Field(ge=0)] = 0.0


class TiltSearch(Frozen):
    """Raise the tilt until a mission fails.

    Attributes:
        of: The part of the experiment that it belongs to.
        missions: Missions by the name of the value that each gives.
        begin: First tilt.
        to: Last tilt.
        step: Between two.
        slides: A wheel that is carried farther while it should stand still does not hold.
    """

    of: str
    missions: dict[Name, TiltedMission]
    begin: Annotated[Angle, Field(alias="from", ge=0)]
    to: Angle
    step: Annotated[Angle, Field(gt=0)]
    slides: Annotated[Length, Field(gt=0)]


class BendSetup(MissionSetup):
    """An experiment that moves through a bend.

    Attributes:
        snapshots: States that must be seen in this order, each by its region.
        tilts: The search for the largest tilt.
    """

    snapshots: dict[str, tuple[str, ...]] = {}  # noqa: RUF012 - pydantic copies it
    tilts: TiltSearch
