"""`pirate schema`: what editors complete and explain files with."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.errors import UsageError
from pirate_sm.loading import library
from pirate_sm.loading.robot import load_robot
from pirate_sm.schemas.writing import mission_schema_text, schema_text


def print_schema(kind: str, robot: str | None) -> int:
    """The JSON Schema stands on standard output.

    Args:
        kind: Of which files.
        robot: Name or path of the robot whose names a mission may use; of any without one.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: There is no such robot, or the kind is the same for all robots.
    """
    if robot is None:
        text = schema_text(kind)
    elif kind == "mission":
        text = mission_schema_text(load_robot(library.find_robot(robot, Path.cwd())))
    else:
        raise UsageError(f"the schema of a {kind} is the same for all robots: leave out --robot")
    print(text, end="")
    return 0
