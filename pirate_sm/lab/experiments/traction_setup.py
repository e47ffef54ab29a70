"""What the file of a traction experiment may say: physics, controller, timeline and noise."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pirate_sm.core.profile import Frozen, Name
from pirate_sm.core.quantities import quantities as si
from pirate_sm.core.simulation import Friction
from pirate_sm.lab.experiments.mission_setups import ExperimentSetup

Moment = Annotated[si.Duration, Field(ge=0)]
PositiveNumber = Annotated[si.Number, Field(gt=0)]


class Bristle(Frozen):
    """How a contact that sticks gives way before it slides.

    Attributes:
        stiffness: Along the pipe.
        damping: Along the pipe.
    """

    stiffness: Annotated[si.SpringRate, Field(gt=0)]
    damping: Annotated[si.Damping, Field(gt=0)]


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

    diameter: Annotated[si.Length, Field(gt=0)]
    friction: dict[Name, Friction]
    threshold: Annotated[si.Speed, Field(gt=0)]
    rotor: Annotated[si.Inertia, Field(ge=0)]
    disk: Annotated[si.Inertia, Field(gt=0)]
    bristle: Bristle
    step: Annotated[si.Duration, Field(gt=0)]
    tick: Annotated[si.Duration, Field(gt=0)]


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

    gain: Annotated[si.VelocityGain, Field(gt=0)]
    speed: Annotated[si.Speed, Field(gt=0)]
    fixed: Annotated[si.Torque, Field(gt=0)]
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
    tilt: si.Angle


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
    end: Annotated[si.Duration, Field(gt=0)]


class NoiseLevel(Frozen):
    """Standard deviations of white noise at each tick of the controller.

    Attributes:
        speed: Of each wheel's measured angular speed.
        tilt: Of the measured tilt.
    """

    speed: Annotated[si.AngularSpeed, Field(ge=0)] = 0.0
    tilt: Annotated[si.Angle, Field(ge=0)] = 0.0


class Variant(Frozen):
    """Which parts of the controller work.

    Attributes:
        compensated: Gravity is fed forward (eq. 3-11).
        gripped: The clamp is controlled (eq. 3-24).
        about: One line for people.
    """

    compensated: si.Flag
    gripped: si.Flag
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
    """

    physics: ReducedPhysics
    control: TractionControl
    timeline: TractionTimeline
    noise: dict[Name, NoiseLevel]
    variants: dict[str, Variant]
    curves: SlipCurves
    loops: OwnLoops | None = None
