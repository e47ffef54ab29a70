"""The body of a robot: wheels on the joints of rigid links in a plane, motors, zeros of joints."""

from __future__ import annotations

from math import sqrt
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from pirate_sm.core._model.base import Condition, Frozen, Name, Sign
from pirate_sm.core._model.quantities import (
    Angle,
    AngularSpeed,
    Current,
    Inertia,
    Mass,
    Number,
    PositiveLength,
    Ratio,
    Stiffness,
    Torque,
)


class Wheel(Frozen):
    """A wheel on a node of the chain.

    Attributes:
        name: Name of the wheel.
        part: The part that it belongs to.
        direction: +1 where it touches side A when clamped, -1 for side B (thesis eq. 3-1).
        mass: Point mass at this wheel.
        angle: Signal of its angle.
        speed: Signal of its angular speed.
        absolute: Whether its angle, up to whole turns, is the same after its board was restarted.
    """

    name: Name
    part: Name
    direction: Sign
    mass: Annotated[Mass, Field(gt=0)]
    angle: Name
    speed: Name
    absolute: bool = False


class Link(Frozen):
    """A rigid link between two wheels; ``roll`` names the signal of a roll joint inside it.

    Attributes:
        module: The module that forms the link.
        length: Distance between its wheels.
        mass: Mass of the link.
        roll: Signal of the roll joint inside it, if there is one.
    """

    module: Name
    length: PositiveLength
    mass: Annotated[Mass, Field(gt=0)]
    roll: Name | None = None


class Joint(Frozen):
    """A driven bend joint at a wheel; it has the name of its angle signal.

    Attributes:
        name: Name of the joint, and of its angle signal.
        wheel: The wheel at the joint.
        part: The part that it belongs to.
        end_stop: Largest angle in either direction.
        torque: Signal of its torque.
    """

    name: Name
    wheel: Name
    part: Name
    end_stop: Annotated[Angle, Field(gt=0)]
    torque: Name | None = None


class Part(Frozen):
    """A part that clamps as a V; ``held`` is a condition on states, ``apex`` the V's joint.

    Attributes:
        apex: The joint at the tip of the V.
        held: Condition on states that is true while the part holds.
    """

    apex: Name
    held: Condition


class Body(Frozen):
    """The planar chain of wheels, joined by links in order.

    Attributes:
        wheel_radius: Radius of the wheels.
        wheel_width: Width of the wheels.
        body_half_thickness: Distance from the axis of a link to its surface.
        wheels: The wheels, front to rear.
        links: The links between adjacent wheels, front to rear.
        joints: The driven bend joints.
        parts: The clamping parts, by name.
    """

    wheel_radius: PositiveLength
    wheel_width: PositiveLength
    body_half_thickness: PositiveLength
    wheels: Annotated[tuple[Wheel, ...], Field(min_length=2)]
    links: Annotated[tuple[Link, ...], Field(min_length=1)]
    joints: Annotated[tuple[Joint, ...], Field(min_length=1)]
    parts: Annotated[dict[Name, Part], Field(min_length=1)]

    @property
    def first_behind_roll(self) -> int:
        """Return the index of the first wheel behind the roll joint; without one the last wheel."""
        return next((n + 1 for n, link in enumerate(self.links) if link.roll), len(self.links))

    @property
    def edge_lacks(self) -> float:
        """Return the share of its radius that a leaning wheel lacks on the edge of its tyre.

        It cannot lean farther, so this is the most that it lacks.
        """
        half = min(self.wheel_width / (2 * self.wheel_radius), 1.0)
        return 1.0 - sqrt(1.0 - half * half)

    def apex_of(self, part: Name) -> Joint | None:
        """Return the joint at the apex of a part's V."""
        apex = self.parts[part].apex
        return next((joint for joint in self.joints if joint.name == apex), None)

    @property
    def mass_kg(self) -> float:
        """Return the mass of the whole robot."""
        return sum(wheel.mass for wheel in self.wheels) + sum(link.mass for link in self.links)

    def legs_m(self, part: Name) -> tuple[float, ...]:
        """Return the lengths of the legs of a part's V; a link with a roll joint is none."""
        apex = self.apex_of(part)
        wheel = apex.wheel if apex else ""
        node = next((i for i, each in enumerate(self.wheels) if each.name == wheel), 0)
        beside = self.links[max(node - 1, 0) : node + 1] or self.links[-1:]
        legs = tuple(link.length for link in beside if link.roll is None)
        return legs or tuple(link.length for link in beside)


class PositionLoop(Frozen):
    """A proportional position controller that ends at duty 0 within its threshold (alg. 3).

    Attributes:
        gain: Duty cycle per rad of error.
        threshold: Largest error at which the joint has reached its angle.
        least_duty: Smallest duty cycle that turns the motor.
        limit: Largest duty cycle used.
        unmoved_limit: Largest duty cycle for a joint that ``limit`` has not moved.
    """

    gain: Annotated[Number, Field(gt=0)]
    threshold: Annotated[Angle, Field(gt=0)]
    least_duty: Annotated[Ratio, Field(ge=0, le=1)] = 0.0
    limit: Annotated[Ratio, Field(gt=0, le=1)] = 1.0
    unmoved_limit: Annotated[Ratio, Field(gt=0, le=1)] | None = None

    @model_validator(mode="before")
    @classmethod
    def _by_its_name(cls, given: Any) -> Any:
        """Take the name that the key has in some recordings."""
        if isinstance(given, dict) and "held_limit" in given:
            return {{"held_limit": "unmoved_limit"}.get(k, k): each for k, each in given.items()}
        return given


class VelocityLoop(Frozen):
    """A controller that keeps a wheel at a speed, with its no-load speed and an integral.

    Attributes:
        gain: Share of the error that each new frame corrects.
        limit: Largest duty cycle used.
    """

    gain: Annotated[Number, Field(gt=0, le=1)]
    limit: Annotated[Ratio, Field(gt=0, le=1)] = 1.0


class TorqueLoop(Frozen):
    """A controller that keeps a joint behind a self-locking worm at a torque.

    Attributes:
        gain: Duty cycle per Nm of error.
        dead: Error within which the motor stands: the worm holds.
        within: Error within which the joint counts as settled.
        least_duty: Duty cycle below which the worm would stand still.
        limit: Largest duty cycle used.
    """

    gain: Annotated[Number, Field(gt=0)]
    dead: Annotated[Torque, Field(gt=0)]
    within: Annotated[Torque, Field(gt=0)]
    least_duty: Annotated[Ratio, Field(ge=0, le=1)] = 0.0
    limit: Annotated[Ratio, Field(gt=0, le=1)] = 1.0

    @model_validator(mode="after")
    def _can_settle(self) -> TorqueLoop:
        if self.within < self.dead:
            raise ValueError("`within` must be at least `dead`: the motor stands inside of that")
        if self.least_duty > self.limit:
            raise ValueError("`least_duty` is more than `limit`: the worm would never move")
        return self


class Motor(Frozen):
    """A kind of motor with its limits; the loader checks which keys a kind requires.

    Attributes:
        kind: ``sprung_worm``: self-locking, behind a series spring. ``geared``: a wheel.
            ``position``: takes an angle, the board controls it. ``light``. ``none``.
        stall_torque: Torque at full duty at standstill.
        stall_current: Current at full duty at standstill.
        no_load_speed: Speed at full duty without load.
        hold_torque: Torque that turns a geared motor against its gearbox at duty 0.
        dead_drag: Drag torque of a failed geared motor.
        rotor_inertia: Moment of inertia of a geared motor's rotor, seen at the wheel: its own times
            the squared ratio of the gear.
        stiffness: Stiffness of the series spring.
        position_loop: The loop that drives a duty slot to an angle.
        velocity_loop: The loop that keeps a wheel at a speed; needs ``no_load_speed``.
        torque_loop: The loop that keeps a joint at a torque; needs ``kind: sprung_worm`` and
            ``stall_torque``. A wheel whose motor has ``stall_torque`` and ``no_load_speed`` needs
            none.
    """

    kind: Literal["sprung_worm", "geared", "position", "light", "none"]
    stall_torque: Torque | None = None
    stall_current: Current | None = None
    no_load_speed: AngularSpeed | None = None
    hold_torque: Torque | None = None
    dead_drag: Torque | None = None
    rotor_inertia: Inertia | None = None
    stiffness: Stiffness | None = None
    position_loop: PositionLoop | None = None
    velocity_loop: VelocityLoop | None = None
    torque_loop: TorqueLoop | None = None

    @property
    def least_duty(self) -> float:
        """Return the duty cycle below which the motor stands still, as its loops say."""
        loops = (self.position_loop, self.torque_loop)
        return max((loop.least_duty for loop in loops if loop is not None), default=0.0)

    @model_validator(mode="after")
    def _knows_its_speed(self) -> Motor:
        if self.velocity_loop is not None and not self.no_load_speed:
            raise ValueError("a `velocity_loop` needs the `no_load_speed` of the motor")
        if self.torque_loop is not None and (self.kind != "sprung_worm" or not self.stall_torque):
            raise ValueError("a `torque_loop` needs `kind: sprung_worm` and the `stall_torque`")
        return self
