"""A control of a robot in words, with what it takes over from the controls that it extends."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.core.profile import Control, Grip, Profile
from pirate_sm.views.drawing.robot.robot_page import given, most


def control_text(profile: Profile, name: str) -> str:
    """Return what a control of the profile does, line by line."""
    chain = list(_extended(profile, name))
    title = f"{name} (control of {profile.robot})"
    about = profile.controls[name].description
    lines = [f"{title}: {about}" if about else title, ""]
    if len(chain) > 1:
        lines.append(f"It extends {', which extends '.join(other for other, _ in chain[1:])}.")
    stages = {
        (region, state): each
        for _, control in reversed(chain)
        for region, states in control.actuation.items()
        for state, each in states.items()
    }
    lines += [
        f"{region}.{state}: {given(profile, each)}" for (region, state), each in stages.items()
    ]
    compensates = (control.gravity_compensation for _, control in chain)
    if next((each for each in compensates if each is not None), False):
        lines.append("Wheels that are kept at a speed or a torque also bear the weight.")
    grip = next((control.grip for _, control in chain if control.grip is not None), None)
    if grip is not None:
        lines.append(_grip_text(grip))
    lines += [
        "All other states are actuated as usual.",
        "",
        "At the head of a mission, or as a step:",
        "",
    ]
    lines += [f"  control: {name}", f"  do: [{{control: {name}}}]"]
    return "\n".join(lines)


def _extended(profile: Profile, name: str) -> Iterator[tuple[str, Control]]:
    """Yield a control and those that it extends, itself first."""
    other: str | None = name
    while other is not None:
        yield other, profile.controls[other]
        other = profile.controls[other].extends


def _grip_text(grip: Grip) -> str:
    friction = grip.friction
    known = (
        "that slipping wheels show"
        if friction == "estimate"
        else ", ".join(f"{value:g} ({part})" for part, value in friction.items())
    )
    return (
        f"Clamps press as tilt and friction ask for, up to {most(grip)}: friction"
        f" {known}, safety {grip.safety:g}."
    )
