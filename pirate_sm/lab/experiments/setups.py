"""The files of experiments, and what repeating gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Literal

from pydantic import Field

from pirate_sm.core.fields import (
    Angle,
    AngularSpeed,
    Count,
    Damping,
    Duration,
    Flag,
    Format,
    Frozen,
    Inertia,
    Length,
    Name,
    Number,
    Speed,
    SpringRate,
    Torque,
    VelocityGain,
)
from pirate_sm.core.models import DefectText, Friction
from pirate_sm.lab.experiments.needed_extras import is_missing
from pirate_sm.lab.experiments.thesis_rows import ThesisRow
from pirate_sm.views.drawing.svg.plot import Plot

# --- missions in the simulator -------------------------------------------------------------------


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


class ClampReadings(Frozen):
    """Torques that a thesis read at the joints of a clamped robot.

    Attributes:
        duty: Of the motors that clamp.
        torques: The readings, by joint.
    """

    duty: Annotated[Number, Field(gt=0, le=1)]
    torques: dict[Name, Torque]


class StraightPipeSetup(MissionSetup):
    """An experiment that drives up and down a straight pipe.

    Attributes:
        clamp: What is to be explained of its clamp torques.
        wheels: Those that were measured.
        shown: The part whose figures are drawn.
        processing: How signals are made comparable.
        again: Parts that are run once more; the values are named after part and backend.
    """

    wheels: tuple[Name, ...]
    shown: str
    clamp: ClampReadings | None = None
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
        slides: A wheel that is carried farther while it should be at rest does not hold.
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


# --- traction ------------------------------------------------------------------------------------


Moment = Annotated[Duration, Field(ge=0)]
PositiveNumber = Annotated[Number, Field(gt=0)]


class Bristle(Frozen):
    """How a contact that sticks gives way before it slides.

    Attributes:
        stiffness: Along the pipe.
        damping: Along the pipe.
    """

    stiffness: Annotated[SpringRate, Field(gt=0)]
    damping: Annotated[Damping, Field(gt=0)]


class ReducedPhysics(Frozen):
    """The reduced physics; mass, radius and links are those of the robot's profile.

    Attributes:
        diameter: Inner diameter of the pipe.
        friction: Between the wheels of a part and the wall, by part.
        threshold: Slip speed of static friction in the law of fig. 4-3.
        rotor: Inertia of a wheel's motor at the wheel.
        disk: Inertia of a wheel.
        bristle: Of the contacts, where friction sticks.
        step: Of the physics.
        tick: Of the controller; a whole number of steps.
    """

    diameter: Annotated[Length, Field(gt=0)]
    friction: dict[Name, Friction]
    threshold: Annotated[Speed, Field(gt=0)]
    rotor: Annotated[Inertia, Field(ge=0)]
    disk: Annotated[Inertia, Field(gt=0)]
    bristle: Bristle
    step: Annotated[Duration, Field(gt=0)]
    tick: Annotated[Duration, Field(gt=0)]


class TractionControl(Frozen):
    """The traction controller (thesis section 3-4-2).

    Attributes:
        gain: K_p of eq. 3-12.
        speed: Wanted speed of the robot while it drives.
        fixed: Torque of every clamp's apex that is not controlled.
        friction: Kinetic friction that the clamp control reckons with, by part.
        safety: How many times the friction that is needed the clamp control provides for.
        share: The torque of eq. 3-24 as printed, or twice it, which the outer wheels need.
    """

    gain: Annotated[VelocityGain, Field(gt=0)]
    speed: Annotated[Speed, Field(gt=0)]
    fixed: Annotated[Torque, Field(gt=0)]
    friction: dict[Name, PositiveNumber]
    safety: PositiveNumber
    share: Literal["as_printed", "corrected"] = "as_printed"


class Drive(Frozen):
    """A stretch of driving.

    Attributes:
        begin: When it begins.
        to: When the wheels are braked.
        way: Which way.
    """

    begin: Annotated[Moment, Field(alias="from")]
    to: Moment
    way: Literal["forward", "backward"]


class GravityTurn(Frozen):
    """Gravity turns from across the pipe to along it.

    Attributes:
        begin: When it begins to.
        to: When it has turned.
        tilt: The pipe's tilt afterwards.
    """

    begin: Annotated[Moment, Field(alias="from")]
    to: Moment
    tilt: Angle


class TractionTimeline(Frozen):
    """What happens when, the same for every variant.

    Attributes:
        clamp: When each part clamps.
        compensate: From when on gravity is compensated, where a variant does.
        drives: When the robot drives; its wheels are braked in between.
        turn: Of gravity.
        grip: From when on clamps are controlled, where a variant does.
        end: When it is over.
    """

    clamp: dict[Name, Moment]
    compensate: Moment
    drives: tuple[Drive, ...]
    turn: GravityTurn
    grip: Moment
    end: Annotated[Duration, Field(gt=0)]


class NoiseLevel(Frozen):
    """Standard deviations of white noise at each tick of the controller.

    Attributes:
        speed: Of each wheel's measured angular speed.
        tilt: Of the measured tilt.
    """

    speed: Annotated[AngularSpeed, Field(ge=0)] = 0.0
    tilt: Annotated[Angle, Field(ge=0)] = 0.0


class Variant(Frozen):
    """Which parts of the controller work.

    Attributes:
        compensated: Gravity is fed forward (eq. 3-11).
        gripped: The clamp is controlled (eq. 3-24).
        about: One line for people.
    """

    compensated: Flag
    gripped: Flag
    about: str


class SlipCurves(Frozen):
    """The run that slip curves are fitted to, one apart: with little noise hardly a wheel slips.

    Attributes:
        of: Its variant.
        noise: Its level of noise.
        wheels: Those whose curves are fitted.
    """

    of: str
    noise: Name
    wheels: tuple[Name, ...]


class OwnLoops(Frozen):
    """The variants as missions, driven by the engine's own loops.

    Attributes:
        backend: That runs them; their values are named after part and backend.
        missions: By variant.
        since: The command with whose first use the way and the odometry begin.
    """

    backend: Name
    missions: dict[str, Name]
    since: Name


class WallContact(Frozen):
    """The walls of the thesis's own simulation (table 4-1), as explicit steps see them.

    Attributes:
        stiffness: Of a contact.
        damping: Of a contact.
        step: Of explicit integration in which rebounds are judged.
        drop: How high above the wall a mass is let go.
        lasting: How long it is watched.
    """

    stiffness: Annotated[SpringRate, Field(gt=0)]
    damping: Annotated[Damping, Field(gt=0)]
    step: Annotated[Duration, Field(gt=0)]
    drop: Annotated[Length, Field(gt=0)]
    lasting: Annotated[Duration, Field(gt=0)]


class Sensitivity(Frozen):
    """Numbers that are not printed, each changed alone; values are named after them.

    Attributes:
        of: The variant.
        noise: The level of noise.
        speed: Other wanted speeds.
        gain: Other gains.
        noise_speed: Other noise of each wheel's measured angular speed.
    """

    of: str
    noise: Name
    speed: dict[Name, Speed] = {}  # noqa: RUF012 - pydantic copies it
    gain: dict[Name, VelocityGain] = {}  # noqa: RUF012 - pydantic copies it
    noise_speed: dict[Name, AngularSpeed] = {}  # noqa: RUF012 - pydantic copies it


class TractionSetup(ExperimentSetup):
    """A traction experiment.

    Attributes:
        physics: The reduced physics.
        control: The controller.
        timeline: What happens when.
        noise: Levels of noise by name.
        variants: By their names in the thesis.
        curves: Of slip and friction.
        loops: The same once more, by the engine's own loops.
        wall: The contact that ended the thesis's simulation of bends.
        sensitivity: What the odometry error owes to numbers that are not printed.
    """

    physics: ReducedPhysics
    control: TractionControl
    timeline: TractionTimeline
    noise: dict[Name, NoiseLevel]
    variants: dict[str, Variant]
    curves: SlipCurves
    loops: OwnLoops | None = None
    wall: WallContact | None = None
    sensitivity: Sensitivity | None = None


# --- results -------------------------------------------------------------------------------------


Watch = Callable[[float], None]
"""Receives the share of the work that is done, from 0 to 1."""


@dataclass
class ExperimentResult:
    """What came of it.

    Attributes:
        values: Ours by name, SI units; rows of the thesis refer to them.
        figures: Those of the thesis, with our curves.
        notes: Lines for people.
    """

    values: dict[str, float] = field(default_factory=dict)
    figures: list[Plot] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def can_run(self, title: str, extra: str) -> bool:
        """Return whether an extra is installed; without it, note that this is not run, and why."""
        why = is_missing(extra)
        if why:
            self.notes.append(f"{title}: not run, {why}")
        return not why
