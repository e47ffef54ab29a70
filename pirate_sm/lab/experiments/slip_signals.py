"""Slip, forces and friction of a recorded run, processed as in section 5-5 of the thesis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pirate_sm.api import Run
from pirate_sm.core.errors import UsageError
from pirate_sm.core.geometry import height_m, span_m
from pirate_sm.core.profile import Profile, Wheel
from pirate_sm.core.profile import derived as kinds
from pirate_sm.lab.experiments.mission_setups import PostProcessing
from pirate_sm.lab.fitting.columns import column
from pirate_sm.simulation.arrays import Floats


@dataclass
class SlipSignals:
    """The signals of a run at even steps of time, smoothed.

    Attributes:
        run: The run, with true places of its wheels.
        processing: How its signals are made comparable.
        seen: When a camera saw the robot, and where along the pipe; None: where it truly was.
    """

    run: Run
    processing: PostProcessing
    seen: tuple[Floats, Floats] | None = None

    @cached_property
    def _columns(self) -> dict[str, Floats]:
        return {name: np.array(values) for name, values in self.run.signals.items()}

    @cached_property
    def _profile(self) -> Profile:
        return self.run.loaded.loaded_robot.profile

    @cached_property
    def times_s(self) -> Floats:
        """Even steps of time."""
        times: Floats = np.arange(0.0, self._columns["time_s"][-1], self.processing.step)
        return times

    @cached_property
    def speed_m_s(self) -> Floats:
        """Of the robot along the pipe, as the camera has seen it, or by the truth.

        Raises:
            UsageError: Nobody knew where the robot was.
        """
        if self.seen is not None:
            return self._rate(*self.seen)
        poses = self.run.poses()
        if poses is None:
            raise UsageError("the backend does not know where the robot is: experiments need it")
        along = np.array([sum(x for x, _ in points) / len(points) for points in poses.points])
        return self._rate(np.array(poses.times_s), along)

    def rim_m_s(self, wheel: Wheel) -> Floats:
        """Return the wheel's rim speed, from differences of its angle (eq. 5-1)."""
        angle = column(self._columns, wheel.angle)
        return self._profile.body.wheel_radius * wheel.direction * self._rate(*self._first(angle))

    def slip_m_s(self, wheel: Wheel) -> Floats:
        """Return the slip speed r d ω − v."""
        return self.rim_m_s(wheel) - self.speed_m_s

    def ratio(self, wheel: Wheel) -> Floats:
        """Return the slip ratio (eq. 3-1); NaN where the robot is all but still."""
        moving = np.abs(self.speed_m_s) >= self.processing.still_below
        ratio: Floats = -self.slip_m_s(wheel) / np.where(moving, self.speed_m_s, np.nan)
        return ratio

    def joint_torque(self, joint: str) -> Floats:
        """Return the torque of a joint, smoothed."""
        name = next(each.torque for each in self._profile.body.joints if each.name == joint)
        return self._smooth(*self._first(column(self._columns, name or joint)))

    def normal_n(self, wheel: Wheel) -> Floats:
        """Return the normal force as the thesis takes it: from the apex of the part (eq. 3-3)."""
        body = self._profile.body
        apex = body.parts[wheel.part].apex
        leg_m = min(body.legs_m(wheel.part))
        joint = next(each for each in body.joints if each.name == apex)
        angle = self._smooth(*self._first(column(self._columns, apex)))
        lever = np.array([span_m(leg_m, height_m(leg_m, each)) for each in angle])
        share = 2.0 if joint.wheel == wheel.name else 1.0
        normal: Floats = (
            share * np.abs(self.joint_torque(apex)) / np.where(lever > 0, lever, np.nan)
        )
        return normal

    def friction_n(self, wheel: Wheel) -> Floats:
        """Return the friction force from the motor's current (eq. 5-3)."""
        slots = {slot.wheel: slot.name for slot in self._profile.slots if slot.wheel}
        derived = self._profile.derived.items()
        name = next(
            name
            for name, each in derived
            if isinstance(each, kinds.TorqueOf) and each.slot == slots[wheel.name]
        )
        torque = self._smooth(*self._first(column(self._columns, name)))
        return np.abs(torque) / self._profile.body.wheel_radius

    def friction(self, wheel: Wheel) -> Floats:
        """Return the friction coefficient in use; NaN where nothing presses."""
        normal = self.normal_n(wheel)
        used: Floats = self.friction_n(wheel) / np.where(normal > 0.5, normal, np.nan)
        return used

    def _first(self, values: Floats) -> tuple[Floats, Floats]:
        """Return times and values without repetitions and without what is unknown."""
        known = np.isfinite(values)
        times, values = self._columns["time_s"][known], values[known]
        fresh = np.concatenate([[True], np.diff(values) != 0])
        return times[fresh], values[fresh]

    def _smooth(self, times: Floats, values: Floats) -> Floats:
        """Return the values at even steps, in a moving average that is centred."""
        if not len(times):
            return np.full(len(self.times_s), np.nan)
        even = np.interp(self.times_s, times, values)
        count = max(round(self.processing.window / self.processing.step), 1)
        padded = np.pad(even, (count // 2, count - 1 - count // 2), mode="edge")
        total = np.cumsum(np.concatenate([[0.0], padded]))
        smoothed: Floats = (total[count:] - total[:-count]) / count
        return smoothed

    def _rate(self, times: Floats, values: Floats) -> Floats:
        rate: Floats = np.gradient(self._smooth(times, values), self.processing.step)
        return rate
