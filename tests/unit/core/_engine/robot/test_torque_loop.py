"""A torque loop by itself, and with a spring behind a worm whose frames come late."""

from __future__ import annotations

from collections import deque
from math import nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.core._engine.robot.actuation_spec import TorqueSpec
from pirate_sm.core._engine.robot.loops import Circumstances, RunningTorqueLoop

SPEC = TorqueSpec(
    gain=1.2,
    dead_nm=0.03,
    within_nm=0.04,
    least_duty=0.15,
    limit=0.7,
    stall_torque_nm=1.0,
    torque=0,
)
FRAME_S = 0.112
TORQUES = st.floats(-2, 2)


def after(loop: RunningTorqueLoop, *torques: float) -> RunningTorqueLoop:
    for torque in torques:
        loop = loop.heard(Circumstances((torque,)))
    return loop


def test_it_stands_before_it_has_heard_anything():
    assert RunningTorqueLoop(2, SPEC, 0.5).duty((0.0,)) == 0


@pytest.mark.parametrize("way", [1, -1])
def test_a_motor_that_winds_the_spring_also_gets_the_duty_that_bears_the_torque(way):
    winding = after(RunningTorqueLoop(2, SPEC, 0.5 * way), 0.2 * way)

    assert winding.duty(()) == pytest.approx(way * (1.2 * 0.3 + 0.2 / 1.0))


@pytest.mark.parametrize("way", [1, -1])
def test_a_motor_that_unwinds_it_does_not(way):
    unwinding = after(RunningTorqueLoop(2, SPEC, 0.1 * way), 0.5 * way)

    assert unwinding.duty(()) == pytest.approx(-way * 1.2 * 0.4)


@pytest.mark.parametrize("torque", [0.475, 0.5, 0.525])
def test_it_stands_where_the_error_is_small(torque):
    assert after(RunningTorqueLoop(2, SPEC, 0.5), 0.1, torque).duty(()) == 0


def test_it_stands_while_the_torque_is_unknown():
    lost = after(RunningTorqueLoop(2, SPEC, 0.5), 0.1, nan)

    assert lost.duty(()) == 0
    assert not lost.settled((nan,))
    assert after(lost, 0.1).duty(()) == pytest.approx(1.2 * 0.4 + 0.1)


def test_a_duty_that_is_too_small_becomes_a_push_of_one_frame():
    pushed = after(RunningTorqueLoop(2, SPEC, 0.1), 0.2)
    waited = after(pushed, 0.2)

    assert pushed.duty(()) == -0.15
    assert waited.duty(()) == 0, "what the push did shows in the frame after this one"
    assert after(waited, 0.2).duty(()) == -0.15


def test_a_duty_that_moves_the_worm_lasts():
    assert [after(RunningTorqueLoop(2, SPEC, 0.5), *[0.1] * n).duty(()) for n in (1, 2, 3)] == (
        pytest.approx([1.2 * 0.4 + 0.1] * 3)
    )


@pytest.mark.parametrize(("torque", "duty"), [(0.0, 0.7), (2.0, -0.7)])
def test_its_duty_has_a_limit(torque, duty):
    assert after(RunningTorqueLoop(2, SPEC, 0.9), torque).duty(()) == duty


@pytest.mark.parametrize(("torque", "settled"), [(0.465, True), (0.535, True), (0.455, False)])
def test_a_joint_is_settled_that_bears_its_torque(torque, settled):
    assert RunningTorqueLoop(2, SPEC, 0.5).settled((torque,)) is settled


@given(TORQUES, st.floats(0.01, 5), st.floats(0.2, 1), st.lists(TORQUES | st.just(nan)))
def test_whatever_it_hears_the_duty_stays_within_its_limit(target, gain, limit, torques):
    loop = after(RunningTorqueLoop(2, SPEC._replace(gain=gain, limit=limit), target), *torques)

    assert abs(loop.duty(())) <= limit


@given(TORQUES, st.lists(TORQUES | st.just(nan)), TORQUES)
def test_nothing_winds_up(target, torques, torque):
    """All that lasts is a push, for one frame."""
    old, new = (
        after(RunningTorqueLoop(2, SPEC, target), *torques),
        RunningTorqueLoop(2, SPEC, target),
    )

    assert after(old, nan, torque) == after(new, torque)


class Joint:
    """A blocked joint behind a series spring, a worm that is never driven back, and a late frame.

    Attributes:
        torque: That the joint bears, Nm.
        most: The largest that it has borne.
    """

    def __init__(self, torque: float, no_load_rad_s: float, delay: int) -> None:
        self.torque, self.most = torque, abs(torque)
        self._no_load_rad_s = no_load_rad_s
        self._frames = deque([torque] * delay, maxlen=delay)

    def frame(self) -> float:
        """Return the torque of so many frames ago."""
        self._frames.append(self.torque)
        return self._frames[0]

    def turn(self, duty: float) -> None:
        """A duty is in force until the next frame."""
        for _ in range(56):
            way = 1.0 if duty > 0 else -1.0
            load = max(way * self.torque / SPEC.stall_torque_nm, 0.0)  # what helps drives no worm
            push = max(abs(duty) - load, 0.0) if abs(duty) >= SPEC.least_duty else 0.0
            self.torque += 2.635 * way * push * self._no_load_rad_s * FRAME_S / 56
            self.most = max(self.most, abs(self.torque))


@given(
    start=st.floats(-0.6, 0.6),
    size=st.floats(0.1, 0.6),
    way=st.sampled_from([1, -1]),
    no_load_rad_s=st.sampled_from([1.0, 0.36]),
    delay=st.integers(1, 3),
)
def test_a_joint_comes_to_its_torque_although_frames_are_late(
    start, size, way, no_load_rad_s, delay
):
    joint, target = Joint(start, no_load_rad_s, delay), way * size
    loop, borne = RunningTorqueLoop(2, SPEC, target), []

    for _ in range(160):
        loop = loop.heard(Circumstances((joint.frame(),)))
        joint.turn(loop.duty(()))
        borne.append(joint.torque)

    assert borne[-20:] == pytest.approx([target] * 20, abs=SPEC.within_nm)
    assert joint.most <= min(max(abs(start), size) + 0.2, SPEC.limit * SPEC.stall_torque_nm)
