"""Resolve the body in a profile to the engine's chain of links."""

from __future__ import annotations

from pirate_sm.core._engine.sensing.body_spec import BodySpec, Imu, Vee
from pirate_sm.core._geometry.space import GRAVITY_M_S2
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model import derived as kinds
from pirate_sm.core._model import profile as model


def resolve_chain(signals: Signals) -> BodySpec:
    """Return the robot's chain; unknown names are left out, and reported elsewhere."""
    profile, body = signals.profile, signals.profile.body
    sign = -1 if signals.polarity == "mirrored" else 1
    roll = next((link.roll for link in body.links if link.roll is not None), None)
    joints = {joint.wheel: _number(signals, joint.name) for joint in body.joints}
    return BodySpec(
        lengths_m=tuple(link.length for link in body.links),
        joints=tuple(joints.get(wheel.name, -1) for wheel in body.wheels),
        sides=tuple(sign * wheel.direction for wheel in body.wheels),
        parts=tuple(_vee(profile, signals, name) for name in body.parts),
        wheel_radius_m=body.wheel_radius,
        roll_link=next((i for i, link in enumerate(body.links) if link.roll is not None), -1),
        imu=_imu(profile, signals),
        roll=_number(signals, roll) if roll else -1,
        weight_n=GRAVITY_M_S2
        * (sum(each.mass for each in body.wheels) + sum(each.mass for each in body.links)),
    )


def _vee(profile: model.Profile, signals: Signals, name: str) -> Vee:
    body = profile.body
    apex = body.apex_of(name)
    return Vee(
        tuple(index for index, wheel in enumerate(body.wheels) if wheel.part == name),
        _number(signals, apex.name) if apex else -1,
        _number(signals, profile.diameter_of(name)),
        apex.end_stop if apex else 0.0,
    )


def _imu(profile: model.Profile, signals: Signals) -> Imu | None:
    """Return the accelerometer from which roll or pitch is derived; None without one."""
    for derived in profile.derived.values():
        match derived:
            case kinds.PitchOf(pitch_of=sources) | kinds.RollOf(roll_of=sources):
                modules = [link.module for link in profile.body.links]
                module = next(
                    (
                        board.module
                        for board in profile.boards
                        if {channel.signal for channel in board.channels} >= set(sources)
                    ),
                    "",
                )
                if module not in modules:
                    return None
                link = modules.index(module)
                x, y, z = (_number(signals, source) for source in sources)
                roll = profile.body.links[link].roll
                return Imu(link, (x, y, z), _number(signals, roll) if roll else -1)
            case _:
                pass
    return None


def _number(signals: Signals, name: str) -> int:
    names = signals.vocabulary.numbers
    return names.index(name) if name in names else -1
