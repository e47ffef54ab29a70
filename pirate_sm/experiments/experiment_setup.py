"""What the files of all experiments say."""

from __future__ import annotations

from pirate_sm.experiments.thesis_rows import ThesisRow
from pirate_sm.model.base import Format, Frozen, Name
from pirate_sm.model.quantities import Count
from pirate_sm.model.simulation import DefectText


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
