"""The signals that a person watches, chosen by what the robot's profile declares."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import degrees, isnan
from typing import NamedTuple

from pirate_sm.model import derived as kinds
from pirate_sm.model import profile as model


class Gauge(NamedTuple):
    """A label, the signal behind it, and how its value is written."""

    label: str
    signal: str
    write: Callable[[float], str]

    def read(self, signals: Mapping[str, float]) -> str:
        """The value in words; a dash where it is unknown."""
        value = signals.get(self.signal, float("nan"))
        return "–" if isnan(value) else self.write(value)


def _angle(value: float) -> str:
    return f"{degrees(value):z.1f}°"


def _millimetres(value: float) -> str:
    return f"{value * 1e3:.1f} mm"


def _distance(value: float) -> str:
    return f"{value:z.3f} m"


def _speed(value: float) -> str:
    return f"{value * 1e3:z.0f} mm/s"


_WRITE: dict[type, Callable[[float], str]] = {
    kinds.DiameterOf: _millimetres,
    kinds.OdometryOf: _distance,
    kinds.SpeedOf: _speed,
    kinds.RollOf: _angle,
    kinds.PitchOf: _angle,
}


def gauges(profile: model.Profile) -> tuple[Gauge, ...]:
    """Joints, roll joints, diameters, odometry, speed, roll and pitch, as far as there are any."""
    found = [Gauge(joint.name, joint.name, _angle) for joint in profile.body.joints]
    found += [Gauge(link.roll, link.roll, _angle) for link in profile.body.links if link.roll]
    for kind, write in _WRITE.items():
        for name, derived in profile.derived.items():
            if isinstance(derived, kind):
                label = (
                    f"⌀ {derived.diameter_of}" if isinstance(derived, kinds.DiameterOf) else name
                )
                found.append(Gauge(label, name, write))
    return tuple(found)
