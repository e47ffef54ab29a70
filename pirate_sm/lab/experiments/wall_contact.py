"""The contact of the thesis's own simulation: a wheel pressed on a wall of springs and dampers.

Its simulated robot bounced fiercely in bends and clipped through walls (section 6-4). A mass m on a
spring k and a damper c swings only where c / (2 sqrt(k m)) is below 1. In explicit steps h the
damper alone reverses a speed from h > m / c on, and increases it from h > 2 m / c on.
"""

from __future__ import annotations

from math import isnan, log, nan, sqrt

from pirate_sm.core.models import Profile
from pirate_sm.lab.experiments.reduced_traction import lever_m, mass_kg
from pirate_sm.lab.experiments.setups import ExperimentResult, TractionSetup, WallContact

_MOST_STEPS = 100_000


def contact_values(profile: Profile, setup: TractionSetup, result: ExperimentResult) -> None:
    """Add what the contact does under a wheel, a link with its wheel, and the whole robot."""
    wall, body = setup.wall, profile.body
    if wall is None:
        return
    part = next(iter(body.parts))
    pressed_n = 2 * setup.control.fixed / lever_m(profile, setup, part)  # at its apex, eq. 3-3
    result.values["contact.depth"] = pressed_n / wall.stiffness
    wheel = min(each.mass for each in body.wheels)
    masses = {"wheel": wheel, "link": wheel + min(each.mass for each in body.links)}
    for name, mass in (masses | {"robot": mass_kg(profile)}).items():
        step_s = bouncing_step_s(wall, mass)
        result.values[f"contact.{name}.step"] = step_s
        result.values[f"contact.{name}.damping"] = wall.damping / (2 * sqrt(wall.stiffness * mass))
        result.values[f"contact.{name}.rebound"] = rebound_m(wall, mass, wall.step)
        result.notes.append(
            f"walls of {wall.stiffness:g} N/m and {wall.damping:g} kg/s under {mass * 1000:.0f} g:"
            f" damping {result.values[f'contact.{name}.damping']:.1f}, "
            + (
                "no step from which it bounces without end was found"
                if isnan(step_s)
                else f"bounces without end in explicit steps from {step_s * 1000:.2f} ms"
            )
        )


def rebound_m(wall: WallContact, mass_kg: float, step_s: float) -> float:
    """Return how high a mass that was dropped on the wall still leaves it in the second half.

    Args:
        wall: The contact; it pushes and never pulls.
        mass_kg: What drops.
        step_s: Of explicit integration: the speed first, then the place with it.
    """
    place_m, speed_m_s, highest_m = wall.drop, 0.0, 0.0
    steps = round(wall.lasting / step_s)
    for step in range(steps):
        push_n = -(wall.stiffness * place_m + wall.damping * speed_m_s) if place_m < 0 else 0.0
        speed_m_s += step_s * (max(push_n, 0.0) / mass_kg - 9.81)
        place_m += step_s * speed_m_s
        if step > steps // 2:
            highest_m = max(highest_m, place_m)
    return highest_m


def bouncing_step_s(wall: WallContact, mass_kg: float) -> float:
    """Return the first of growing steps, each by 5 %, in which the mass never comes to rest.

    NaN if there is none among those that divide the time of watching into 4 to 100,000 (assumed),
    or if the mass already bounces in the shortest, which no step of integration explains.
    """
    shortest_s = max(0.1 * mass_kg / wall.damping, wall.lasting / _MOST_STEPS)
    numbers = range(int(log(max(wall.lasting / 4 / shortest_s, 1.0), 1.05)) + 1)
    tried = (shortest_s * 1.05**number for number in numbers)
    found = next((step_s for step_s in tried if rebound_m(wall, mass_kg, step_s) > 0), nan)
    return nan if found == shortest_s else found
