"""`pirate schema`: prints the JSON Schemas for editors."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.cli.options.files import SchemaOptions
from pirate_sm.cli.schema_files import mission_schema_text, schema_text
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_robot


def print_schema(options: SchemaOptions) -> int:
    """Print the JSON Schema of a kind of file; return the exit code.

    Raises:
        LoadError: The robot's files cannot be used.
        UsageError: There is no such robot, or the kind is the same for all robots.
    """
    kind, robot = options.files, options.robot
    if robot is None:
        text = schema_text(kind)
    elif kind == "mission":
        text = mission_schema_text(load_robot(library.find_robot(robot, Path.cwd())))
    else:
        raise UsageError(f"the schema of a {kind} is the same for all robots: leave out --robot")
    print(text, end="")
    return 0
