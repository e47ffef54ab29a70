"""The body of a robot: wheels on the joints of rigid links, in a plane."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from pirate_sm.core._model.base import Condition, Frozen, Name, Sign
from pirate_sm.core._model.quantities import Angle, Length, Mass

PositiveLength = Annotated[Length, Field(gt=0)]


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
