"""Numbers of a robot as the text of a file that its simulator loads."""

from __future__ import annotations

from collections.abc import Iterable

from pirate_sm.core.profile import Profile
from pirate_sm.lab.fitting.robot_numbers import RobotNumber


def twin_text(profile: Profile, numbers: Iterable[RobotNumber], source: str) -> str:
    """Return the file: what is known, and as comments what is not.

    Args:
        profile: Of the robot.
        numbers: What was estimated.
        source: What it was estimated from, for people.
    """
    lines = [
        f"# Numbers of one robot, estimated from {source} by `pirate fit --robot`.",
        "# The simulator takes them instead of the profile's: pirate-run MISSION --twin FILE",
        "format: 1",
        f"robot: {profile.robot}",
    ]
    numbers = list(numbers)
    known = [each for each in numbers if each.motor and each.estimate.known]
    if known:
        lines.append("motors:")
    for motor in dict.fromkeys(each.motor for each in known):
        lines.append(f"  {motor}:")
        for each in known:
            if each.motor == motor:
                low, high = each.estimate.low, each.estimate.high
                value = f"    {each.key}: {each.estimate.value:.4g} {each.unit}"
                lines.append(f"{value}    # 95 %: {low:.4g} to {high:.4g}")
    for each in numbers:
        if not each.estimate.known:
            what = f"{each.motor} {each.key}".strip()
            lines.append(f"# unknown: {what}: {each.estimate.reason}")
        elif not each.motor:
            lines.append(f"# {each.key}: {each.estimate.value:.3f}")
    kinetic = [each.estimate.value for each in numbers if not each.motor and each.estimate.known]
    if kinetic:
        assumed = profile.simulation.friction
        mean = sum(kinetic) / len(kinetic)
        static = mean * assumed.static / assumed.kinetic
        lines.append("# The simulator has one friction: the mean, static in the profile's ratio.")
        lines.append(f"friction: {{static: {static:.3f}, kinetic: {mean:.3f}}}")
    return "\n".join([*lines, ""])
