"""Control loops that compute duty cycles from signals, as a closed union.

Every loop has a ``slot``. ``heard`` returns the loop after a new frame of the board that measures
its signal; ``duty`` returns the duty cycle for the slot.
"""

from __future__ import annotations

from math import copysign, cos, isnan, nan, sin
from typing import NamedTuple, TypeAlias

from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.actuation_spec import (
    GripSpec,
    PositionSpec,
    SlotSpec,
    TorqueSpec,
    VelocitySpec,
    WheelTorqueSpec,
    Write,
)
from pirate_sm.core._engine.robot.duty_cycles import position_duty
from pirate_sm.core._engine.sensing.board_spec import BoardSpec
from pirate_sm.core._geometry.chain import HELD_SAFETY


class Circumstances(NamedTuple):
    """The signals after a frame, and what else loops go by.

    Attributes:
        numbers: Signals in SI; NaN is unknown.
        pitch_rad: How steep the pipe climbs ahead of the robot; NaN is unknown.
        now_s: When it is.
    """

    numbers: Numbers
    pitch_rad: float = nan
    now_s: float = nan


# --- how hard a clamped part must press (thesis eq. 3-16 to 3-25) -----------------------------


LEAST_MARGIN = HELD_SAFETY
"""With less than this factor between what friction can bear and the weight the grip is exhausted,
while the part presses as hard as it may [decided]."""

LEAST_FRICTION = 1e-3
"""Less than any wall has: an estimate of zero asks for more torque than there is."""


class Gripping(NamedTuple):
    """What is remembered of the grip of a part, which presses so that friction bears the robot.

    Attributes:
        torque_nm: Size of the torque that is asked of the apex.
        friction: The friction that was last known; NaN before it ever was.
        since_s: When the torque was last set.
        exhausted: Whether friction may not bear the robot although the part presses all it may.
    """

    torque_nm: float
    friction: float = nan
    since_s: float = nan
    exhausted: bool = False


def gripping(spec: GripSpec) -> Gripping:
    """Return the grip at first: as hard as it may be, until friction and tilt are known."""
    return Gripping(spec.at_most_nm, spec.friction)


def gripping_after(
    spec: GripSpec, before: Gripping, seen: Circumstances, *, presses: bool = False
) -> Gripping:
    """Return the grip after a fresh frame.

    It is raised at once, also when a wheel slips, and lowered slowly.

    Args:
        spec: How hard the part presses.
        before: The grip before the frame.
        seen: The signals with the frame in them.
        presses: Whether the apex bears all that it may.
    """
    numbers = seen.numbers
    known = [numbers[index] for index in spec.estimates if not isnan(numbers[index])]
    friction = min(known, default=before.friction) if isnan(spec.friction) else spec.friction
    needed_nm = torque_nm(spec, friction, numbers[spec.angle], seen.pitch_rad)
    wanted_nm = spec.at_most_nm if isnan(needed_nm) else min(needed_nm, spec.at_most_nm)
    if any(abs(numbers[index]) > spec.alarm_m_s for index in spec.slip_speeds):
        wanted_nm = spec.at_most_nm
    elapsed_s = 0.0 if isnan(before.since_s) else seen.now_s - before.since_s
    lowered_nm = before.torque_nm - spec.lower_nm_s * elapsed_s
    size_nm = max(wanted_nm, spec.at_least_nm, lowered_nm)
    exhausted = needed_nm * LEAST_MARGIN / spec.safety > spec.at_most_nm
    return Gripping(size_nm, friction, seen.now_s, exhausted or (presses and _carried(spec, seen)))


def _carried(spec: GripSpec, seen: Circumstances) -> bool:
    """Return whether all wheels of the part are carried downhill, beyond what they roll.

    However little is known of the friction, it does not bear the robot then. While the tilt is
    unknown it is enough that the robot moves beyond what they roll.
    """
    numbers, downhill = seen.numbers, sin(seen.pitch_rad)
    slips = [numbers[index] for index in spec.slip_speeds]
    return bool(slips) and all(
        abs(slip) > spec.alarm_m_s and slip * numbers[spec.speed] < 0 and not downhill * slip <= 0
        for slip in slips
    )


def torque_nm(spec: GripSpec, friction: float, angle_rad: float, pitch_rad: float) -> float:
    """Return the size of the torque at the apex that holds the robot; NaN where it is unknown.

    A part's wheels press with N_d = safety * m g |sin| / (wheels * friction) beside the share of
    the weight that lies across the pipe; an apex with torque tau presses its wheels by 2 tau
    divided by the length of a leg along the pipe (eq. 3-16 and 3-25).
    """
    reach_m = spec.leg_m * cos(angle_rad / 2)
    along_n = spec.safety * spec.weight_n * abs(sin(pitch_rad)) / spec.wheels
    across_n = spec.weight_n * abs(cos(pitch_rad)) / spec.wheels
    return spec.share * 0.5 * reach_m * (across_n + along_n / max(friction, LEAST_FRICTION))


# --- the loops --------------------------------------------------------------------------------


class RunningPositionLoop(NamedTuple):
    """A proportional loop that drives a joint to an angle (thesis section 4-2-3).

    Attributes:
        slot: The slot that it writes.
        angle: Number index of the controlled angle; ``rate`` is the index of its rate.
        torque: Number index of the torque at the joint.
        target_rad: The angle to reach.
    """

    slot: int
    angle: int
    rate: int
    torque: int
    spec: PositionSpec
    target_rad: float

    def heard(self, seen: Circumstances) -> RunningPositionLoop:
        """Return the loop after a fresh frame: it remembers nothing."""
        return self

    def arrived(self, numbers: Numbers) -> bool:
        """Return whether the angle is within the threshold; False while it is unknown."""
        return abs(self.target_rad - numbers[self.angle]) <= self.spec.threshold_rad

    def unmoved(self, numbers: Numbers, origin: Numbers, moved_rad: float) -> bool:
        """Return whether the joint has neither arrived nor turned so far; an unknown turn is 0."""
        moved = bool(origin) and abs(numbers[self.angle] - origin[self.angle]) >= moved_rad
        return moved_rad > 0 and not moved and not self.arrived(numbers)

    def harder(self) -> RunningPositionLoop:
        """Return the loop with the limit for a joint that has not moved."""
        limit = max(self.spec.limit, self.spec.unmoved_limit)
        return self._replace(spec=self.spec._replace(limit=limit))

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle of the controller, given the share of reports that is lost."""
        return position_duty(self.target_rad - numbers[self.angle], loss, *self.spec[:4])

    def pushed_nm(self, duty: float, share: float, least_nm: float) -> float:
        """Return the torque that a pushed joint exceeds at this duty."""
        return max(least_nm, share * abs(duty) * self.spec.stall_torque_nm)


class RunningVelocityLoop(NamedTuple):
    """A loop that keeps a wheel at a speed: u = target / no-load speed + integral.

    The speed of a geared motor follows its duty within one frame, so the plant is nearly static.
    The loop therefore has no proportional term; each new frame corrects the integral.

    Attributes:
        slot: Whose duty it sets.
        target_rad_s: The speed that the wheel shall have.
        assist_nm: Torque by which the wheel bears its share of the weight in an upright pipe; 0
            without gravity compensation.
        integral: What has been learned to be missing, as a duty cycle.
        weight: The duty cycle that bears the wheel's share of the weight in this pipe.
    """

    slot: int
    spec: VelocitySpec
    target_rad_s: float
    assist_nm: float = 0.0
    integral: float = 0.0
    weight: float = 0.0

    def heard(self, seen: Circumstances) -> RunningVelocityLoop:
        """Return the loop after a fresh frame of the wheel's board.

        The integral grows by ``gain`` times the error. It does not change while the speed is
        unknown, and it stops at the limit of the duty (anti-windup).
        """
        loop = self
        if self.assist_nm and not isnan(seen.pitch_rad):
            weight_nm = self.assist_nm * sin(seen.pitch_rad)
            loop = self._replace(weight=weight_nm / self.spec.stall_nm)
        return loop._corrected(seen.numbers[self.spec.speed])

    def _corrected(self, speed: float) -> RunningVelocityLoop:
        if isnan(speed):
            return self
        error = (self.target_rad_s - speed) / self.spec.no_load_rad_s
        wanted = self._limited(self._expected + self.integral + self.spec.gain * error)
        return self._replace(integral=wanted - self._expected)

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle; it changes with new frames only and ignores its arguments."""
        return self._limited(self._expected + self.integral)

    @property
    def _expected(self) -> float:
        """Return the duty cycle at which the motor has its speed under the weight alone."""
        return self.target_rad_s / self.spec.no_load_rad_s + self.weight

    def _limited(self, duty: float) -> float:
        return min(max(duty, -self.spec.limit), self.spec.limit)


class RunningTorqueLoop(NamedTuple):
    """A loop that keeps a joint behind a self-locking worm at a torque, by its duty.

    The series spring is the sensor and the worm is the memory: at duty 0 it keeps the torque
    without a current. A motor that winds the spring needs the duty that bears the torque, and one
    for the error.

    Attributes:
        slot: Whose duty it sets.
        asked_nm: The torque that its state asks for.
        grip: What the size of the torque follows from; None: it is what the state asks for.
        gripping: What is remembered of that.
        output: The duty cycle until the next frame.
        pushing: Whether that is a push, after which the loop waits for one frame.
    """

    slot: int
    spec: TorqueSpec
    asked_nm: float
    grip: GripSpec | None = None
    gripping: Gripping | None = None
    output: float = 0.0
    pushing: bool = False

    @property
    def asks(self) -> tuple[float, GripSpec | None]:
        """Return what its state asks for, whatever has been learned since."""
        return self.asked_nm, self.grip

    @property
    def target_nm(self) -> float:
        """Return the torque that the joint shall bear now."""
        if self.gripping is None:
            return self.asked_nm
        return copysign(self.gripping.torque_nm, self.asked_nm)

    @property
    def exhausted(self) -> bool:
        """Return whether friction may not bear the robot although the part presses all it may."""
        return self.gripping is not None and self.gripping.exhausted

    def heard(self, seen: Circumstances) -> RunningTorqueLoop:
        """Return the loop after a fresh frame of the joint's board.

        The duty is ``gain * error``, and ``torque / stall torque`` more while the motor winds the
        spring. In place of a duty that is too small to move the worm comes a push of one frame,
        then 0 until the frame after that shows what the push did. The duty is 0 where the error
        is small or the torque is unknown: the worm holds.
        """
        if self.grip is not None:
            least_nm = self.grip.at_most_nm - self.spec.within_nm
            presses = abs(seen.numbers[self.spec.torque]) >= least_nm
            before = self.gripping or gripping(self.grip)
            now = gripping_after(self.grip, before, seen, presses=presses)
            return self._replace(gripping=now)._driven(seen.numbers)
        return self._driven(seen.numbers)

    def _driven(self, numbers: Numbers) -> RunningTorqueLoop:
        spec, torque = self.spec, numbers[self.spec.torque]
        error = self.target_nm - torque
        if isnan(error) or abs(error) <= spec.dead_nm or self.pushing:
            return self._replace(output=0.0, pushing=False)
        way = 1.0 if error > 0 else -1.0
        winds = way * torque >= 0
        wanted = abs(error) * spec.gain + (way * torque / spec.stall_torque_nm if winds else 0.0)
        size = min(max(wanted, spec.least_duty), spec.limit)
        return self._replace(output=way * size, pushing=wanted < spec.least_duty)

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle; neither the signals nor lost reports matter between frames."""
        return self.output

    def settled(self, numbers: Numbers) -> bool:
        """Whether the joint bears its torque; an unknown torque is not it."""
        return abs(self.target_nm - numbers[self.spec.torque]) <= self.spec.within_nm


class WheelTorqueLoop(NamedTuple):
    """A loop that keeps the torque of a wheel: u = target / stall torque + speed / no-load speed.

    By its characteristic a motor gives ``stall torque * (u - speed / no-load speed)``, so the loop
    makes up for the speed that the last frame showed.

    Attributes:
        slot: Whose duty it sets.
        target_nm: The torque that the motor shall give, behind its gears.
        assist_nm: Torque by which the wheel bears its share of the weight in an upright pipe; 0
            without gravity compensation.
        weight_nm: The same in this pipe.
        speed_rad_s: The speed of the wheel at the last frame that showed it.
    """

    slot: int
    spec: WheelTorqueSpec
    target_nm: float
    assist_nm: float = 0.0
    speed_rad_s: float = 0.0
    weight_nm: float = 0.0

    def heard(self, seen: Circumstances) -> WheelTorqueLoop:
        """Return the loop after a fresh frame; it keeps the last speed while that is unknown."""
        after = self
        if self.assist_nm and not isnan(seen.pitch_rad):
            after = after._replace(weight_nm=self.assist_nm * sin(seen.pitch_rad))
        speed = seen.numbers[self.spec.speed]
        return after if isnan(speed) else after._replace(speed_rad_s=speed)

    def duty(self, numbers: Numbers, loss: float = 0.0) -> float:
        """Return the duty cycle, within its limits."""
        spec = self.spec
        torque_nm = self.target_nm + self.weight_nm
        duty = torque_nm / spec.stall_torque_nm + self.speed_rad_s / spec.no_load_rad_s
        return min(max(duty, -1.0), 1.0)


# --- all of them ------------------------------------------------------------------------------


Loop: TypeAlias = RunningPositionLoop | RunningVelocityLoop | RunningTorqueLoop | WheelTorqueLoop
Loops: TypeAlias = tuple[Loop, ...]


def begun(write: Write, slot: SlotSpec, numbers: Numbers, running: Loop | None) -> Loop | None:
    """Return the loop that a write starts or continues, None where it needs no loop.

    Args:
        write: What a stage does to the slot.
        slot: The slot that is written.
        numbers: Signals; an angle given as a share is computed from the angle measured now.
        running: The loop that runs on the slot. It continues, with its integral, if the write
            asks for the same loop.
    """
    match write.how:
        case "seek":
            return _seeking(write, slot, numbers, running)
        case "turn":
            if slot.velocity is None:
                return None
            new = RunningVelocityLoop(write.slot, slot.velocity, write.value, write.assist_nm)
            same = isinstance(running, RunningVelocityLoop) and running[:4] == new[:4]
            return running if same else new
        case "bear":
            return _bearing(write, slot, numbers, running)
        case "set" | "keep" | "level":
            return None


def _seeking(write: Write, slot: SlotSpec, numbers: Numbers, running: Loop | None) -> Loop | None:
    """Return the position loop of a write; None for a slot without one.

    The running loop continues while its angle is the one wanted now to within its threshold: the
    loop sees no smaller difference, and a joint that moves the other one would chase its own
    angle. It also continues while the other joint's angle is unknown.
    """
    if slot.position is None:
        return None
    share = 1.0 if write.share_of < 0 else numbers[write.share_of]
    target_rad = write.value * share
    new = RunningPositionLoop(
        write.slot, slot.angle, slot.rate, slot.torque, slot.position, target_rad
    )
    if not isinstance(running, RunningPositionLoop):
        return new
    away_rad = abs(target_rad - running.target_rad)
    moves = away_rad > new.spec.threshold_rad
    return running._replace(target_rad=target_rad) if moves else running


def _bearing(write: Write, slot: SlotSpec, numbers: Numbers, running: Loop | None) -> Loop | None:
    if slot.held_torque is not None:
        loop = RunningTorqueLoop(write.slot, slot.held_torque, write.value, write.grip)
        same = isinstance(running, RunningTorqueLoop) and running.asks == loop.asks
        return running if same else loop.heard(Circumstances(numbers))
    if slot.wheel_torque is not None:
        wheel = WheelTorqueLoop(write.slot, slot.wheel_torque, write.value, write.assist_nm)
        return wheel.heard(Circumstances(numbers))
    return None


def signal_of(loop: Loop) -> int:
    """Return the number index of the signal by which the loop controls its slot."""
    match loop:
        case RunningPositionLoop():
            return loop.angle
        case RunningTorqueLoop():
            return loop.spec.torque
        case RunningVelocityLoop() | WheelTorqueLoop():
            return loop.spec.speed


def ends_with_command(loop: Loop) -> bool:
    """Return whether the loop ends with its command; others run until a state writes the slot."""
    return isinstance(loop, RunningPositionLoop)


def loops_after(board: BoardSpec, loops: Loops, seen: Circumstances) -> Loops:
    """Return the loops after a frame of the board; it tells those of other boards nothing.

    Args:
        board: The board that reported.
        loops: The running loops.
        seen: The signals with the frame in them, and what else loops go by.
    """
    after = tuple(
        [each.heard(seen) if signal_of(each) in board.number_set else each for each in loops]
    )
    return loops if after == loops else after
