"""Compiled steps of the reduced physics: equations 3-4 and 3-6 with the friction law of fig. 4-3.

Each wheel is described by the speed of its rim, positive forward: u = r d ω. Its rotor and disk
count as the mass M = I / r², the motor as the force d τ / r. With the friction force F of the wheel
on the robot, at the slip speed s = u − v:

    m v' = −m g sin α + Σ F        M u' = d τ / r − F

Friction rises so steeply at low slip speed that an explicit step of 50 µs is at the edge of what is
stable. So each step solves for the slip speed at its end, with the law made linear: an arrow-shaped
system, solved in closed form.
"""

from __future__ import annotations

import numpy as np

from pirate_sm.simulation.arrays import Floats
from pirate_sm.simulation.machine_code import compiled

GRAVITY_M_S2 = 9.81
_FALLS_BY = 1.5
"""From the threshold to this many thresholds friction falls from static to kinetic (dynamics [D]:
fig. 4-3 gives the shape alone)."""


@compiled
def friction_coefficient(slip: float, static: float, kinetic: float, threshold: float) -> float:
    """Return μ at a slip speed: linear to static, down to kinetic, then constant (fig. 4-3).

    Args:
        slip: Slip speed, m/s, either way.
        static: Coefficient at the threshold.
        kinetic: Coefficient from 1.5 thresholds on.
        threshold: m/s.
    """
    share = abs(slip) / threshold
    if share <= 1.0:
        return static * share
    falling = min((share - 1.0) / (_FALLS_BY - 1.0), 1.0)
    return static + (kinetic - static) * falling


@compiled
def _creeping(slip: float, normal: float, law: Floats) -> tuple[float, float]:
    """Return the friction force at a slip speed, N, and its slope, N s/m."""
    force = np.sign(slip) * normal * friction_coefficient(slip, law[0], law[1], law[2])
    slope = normal * law[0] / law[2] if abs(slip) < law[2] else 0.0
    return force, slope


@compiled
def _sticking(
    slip: float, normal: float, law: Floats, bristle: float, step_s: float
) -> tuple[float, float]:
    """Return force and slope where the contact sticks: a bristle that gives way at its limit.

    Args:
        slip: Slip speed, m/s.
        normal: N.
        law: Static, kinetic, threshold, stiffness N/m and damping N s/m of the bristle.
        bristle: How far it is bent, m.
        step_s: Length of a step.
    """
    limit = normal * friction_coefficient(max(abs(slip), law[2]), law[0], law[1], law[2])
    force = law[3] * bristle + law[4] * slip
    if abs(force) >= limit:
        return np.sign(force) * limit, 0.0
    return force, law[4] + law[3] * step_s


@compiled
def _drive(
    ahead: float, gain: float, wanted: float, rim: Floats, noise: Floats, motor: Floats
) -> None:
    """Write the force of each motor at its rim, N: what it is fed forward with and its control."""
    for i in range(len(motor)):
        motor[i] = ahead + gain * (wanted - rim[i] - noise[i])


@compiled
def _note(row: Floats, rim: Floats, force: Floats, motor: Floats) -> None:
    """Write what is of the wheels into a row of the result."""
    count = len(rim)
    for i in range(count):
        row[2 + i] = rim[i]
        row[2 + count + i] = force[i]
        row[2 + 2 * count + i] = motor[i]


@compiled
def simulate(
    wheels: Floats,
    body: Floats,
    control: Floats,
    normals: Floats,
    noise: Floats,
    sticks: bool,
    steps: int,
    out: Floats,
    scratch: Floats,
) -> None:
    """Write place and speeds of the robot at each tick of its controller to `out`.

    Args:
        wheels: A row for each wheel: its law (static, kinetic, threshold, bristle's stiffness and
            damping).
        body: Mass kg, rotating mass of a wheel I/r² kg, gain K_p/r N s/m of the velocity law (eq.
            3-12 at the rim), length of a tick s.
        control: A row for each tick: wanted speed m/s, tilt rad, force N that each wheel is fed
            forward with (eq. 3-11).
        normals: Normal force of each wheel, N, a row for each tick.
        noise: What the measured rim speed of each wheel is off by, m/s, a row for each tick.
        sticks: Whether contacts stick, in place of the law of fig. 4-3.
        steps: Steps of the physics in a tick.
        out: A row for each tick: x m, v m/s, then of each wheel the rim's speed m/s, the friction
            force N and the motor's force at the rim N; changed.
        scratch: Memory, `(5, wheels)`, with zeros.
    """
    ticks, count = normals.shape
    rim, motor = scratch[0], scratch[1]
    force, slope, bristle = scratch[2], scratch[3], scratch[4]
    mass, rotor, gain, tick_s = body[0], body[1], body[2], body[3]
    step_s = tick_s / steps
    x = v = 0.0
    for tick in range(ticks):
        wanted, tilt, ahead = control[tick]
        _drive(ahead, gain, wanted, rim, noise[tick], motor)
        for _ in range(steps):
            pull = -mass * GRAVITY_M_S2 * np.sin(tilt)
            stiff = 0.0
            for i in range(count):
                slip = rim[i] - v
                if sticks:
                    force[i], slope[i] = _sticking(
                        slip, normals[tick, i], wheels[i], bristle[i], step_s
                    )
                else:
                    force[i], slope[i] = _creeping(slip, normals[tick, i], wheels[i])
                # The share of what the wheel gains in this step that reaches the robot immediately.
                share = slope[i] * step_s / (rotor + slope[i] * step_s)
                pull += force[i] + share * (motor[i] - force[i])
                stiff += share * rotor
            faster = step_s * pull / (mass + stiff)
            v += faster
            x += step_s * v
            for i in range(count):
                grip = slope[i] * step_s
                gained = (step_s * (motor[i] - force[i]) + grip * faster) / (rotor + grip)
                rim[i] += gained
                force[i] += slope[i] * (gained - faster)
                if sticks and slope[i] > 0.0:
                    bristle[i] += step_s * (rim[i] - v)
                elif sticks:
                    bristle[i] = force[i] / wheels[i, 3]
        if not sticks:  # what was solved for is the law made linear, not the law
            for i in range(count):
                force[i] = _creeping(rim[i] - v, normals[tick, i], wheels[i])[0]
        out[tick, 0], out[tick, 1] = x, v
        _note(out[tick], rim, force, motor)
