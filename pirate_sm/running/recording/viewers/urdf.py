"""A robot's URDF from its profile: links, joints with their limits, masses.

The first link's frame is the root. Frames are those of :mod:`pirate_sm.core.geometry`:
bend joints turn about z, the roll joint inside a link about its x axis, wheels about z by their
encoder's angle. A link with a roll joint becomes two, each half as long.
"""

from __future__ import annotations

from xml.etree import ElementTree as Xml

from pirate_sm.core.models import Body, Link, Profile


def urdf(profile: Profile) -> str:
    """Return the robot as URDF 1.0, indented."""
    root = Xml.Element("robot", name=profile.robot)
    body = profile.body
    parent = ""
    for number, link in enumerate(body.links):
        name = link.module
        length = link.length if link.roll is None else link.length / 2
        _link(root, name, length, link.mass if link.roll is None else link.mass / 2, body)
        if parent:
            _bend(root, profile, number, parent, name)
        _wheel(root, body, number, name, 0.0)
        parent = name
        if link.roll is not None:
            parent = f"{name}_rear"
            _link(root, parent, length, link.mass / 2, body)
            _roll(root, profile, link.roll, name, parent, length)
    last = body.links[-1]
    _wheel(root, body, len(body.links), parent, -_reach(last))
    Xml.indent(root)
    return '<?xml version="1.0"?>\n' + Xml.tostring(root, encoding="unicode") + "\n"


def _reach(link: Link) -> float:
    """Return the distance from a link's last frame to the link's end, m."""
    return link.length if link.roll is None else link.length / 2


def _link(root: Xml.Element, name: str, length: float, mass: float, body: Body) -> None:
    link = Xml.SubElement(root, "link", name=name)
    thick = 2 * body.body_half_thickness
    for kind in ("visual", "collision"):
        shape = Xml.SubElement(link, kind)
        _origin(shape, -length / 2)
        box = Xml.SubElement(Xml.SubElement(shape, "geometry"), "box")
        box.set("size", _triple(length, thick, thick))
    _inertial(link, mass, (length, thick, thick), -length / 2)


def _inertial(
    link: Xml.Element, mass: float, size: tuple[float, float, float], x: float = 0.0
) -> None:
    """Add mass and inertia of a solid box of uniform density."""
    inertial = Xml.SubElement(link, "inertial")
    _origin(inertial, x)
    Xml.SubElement(inertial, "mass", value=_number(mass))
    a, b, c = (each * each for each in size)
    moments = {"ixx": b + c, "iyy": a + c, "izz": a + b}
    inertia = {name: _number(mass / 12 * sum_) for name, sum_ in moments.items()}
    Xml.SubElement(inertial, "inertia", {**inertia, "ixy": "0", "ixz": "0", "iyz": "0"})


def _bend(root: Xml.Element, profile: Profile, number: int, parent: str, child: str) -> None:
    """Add the joint at a wheel, between the link ahead and the one behind."""
    body = profile.body
    ahead, wheel = body.links[number - 1], body.wheels[number].name
    joint = next((each for each in body.joints if each.wheel == wheel), None)
    name, kind = (joint.name, "revolute") if joint else (f"{child}_fixed", "fixed")
    element = _joint(root, name, kind, parent, child, -_reach(ahead))
    if joint is not None:
        _axis(element, "0 0 1")
        motor = _motor(profile, "joint", joint.name)
        _limit(element, joint.end_stop, motor)


def _roll(
    root: Xml.Element, profile: Profile, name: str, parent: str, child: str, length: float
) -> None:
    element = _joint(root, name, "revolute", parent, child, -length)
    _axis(element, "1 0 0")
    slot = next((each for each in profile.slots if each.roll == name), None)
    limit = getattr(slot, "limit", None)
    _limit(element, float(limit) if limit else 3.1416, _motor(profile, "roll", name))


def _wheel(root: Xml.Element, body: Body, number: int, parent: str, x: float) -> None:
    wheel = body.wheels[number]
    link = Xml.SubElement(root, "link", name=wheel.name)
    shape = Xml.SubElement(link, "visual")
    cylinder = Xml.SubElement(Xml.SubElement(shape, "geometry"), "cylinder")
    cylinder.set("radius", _number(body.wheel_radius))
    cylinder.set("length", _number(body.wheel_width))
    across = 2 * body.wheel_radius
    _inertial(link, wheel.mass, (across, across, body.wheel_width))
    element = _joint(root, wheel.angle, "continuous", parent, wheel.name, x)
    _axis(element, "0 0 1")


def _joint(
    root: Xml.Element, name: str, kind: str, parent: str, child: str, x: float
) -> Xml.Element:
    element = Xml.SubElement(root, "joint", name=name, type=kind)
    Xml.SubElement(element, "parent", link=parent)
    Xml.SubElement(element, "child", link=child)
    _origin(element, x)
    return element


def _origin(element: Xml.Element, x: float) -> None:
    Xml.SubElement(element, "origin", xyz=_triple(x, 0.0, 0.0), rpy="0 0 0")


def _axis(element: Xml.Element, xyz: str) -> None:
    Xml.SubElement(element, "axis", xyz=xyz)


def _limit(element: Xml.Element, angle_rad: float, motor: tuple[float, float]) -> None:
    torque_nm, speed_rad_s = map(_number, motor)
    ends = {"lower": _number(-angle_rad), "upper": _number(angle_rad)}
    Xml.SubElement(element, "limit", {**ends, "effort": torque_nm, "velocity": speed_rad_s})


def _motor(profile: Profile, kind: str, name: str) -> tuple[float, float]:
    """Return stall torque (N m) and no-load speed (rad/s) of its motor; 0 without a motor."""
    for slot in profile.slots:
        if getattr(slot, kind, None) == name:
            motor = profile.motors[slot.motor]
            return (
                getattr(motor, "stall_torque", 0.0) or 0.0,
                getattr(motor, "no_load_speed", 0.0) or 0.0,
            )
    return 0.0, 0.0


def _triple(x: float, y: float, z: float) -> str:
    return f"{_number(x)} {_number(y)} {_number(z)}"


def _number(value: float) -> str:
    return f"{value:.9g}"
