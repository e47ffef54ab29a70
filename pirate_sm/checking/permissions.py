"""What a file of somebody else may ask for; one list for files of all kinds.

Scenes, campaigns, a project's `pirate.toml`, missions and recordings may come from anybody. None of
them may reach a robot, listen to a network, open a camera or write outside its own folder, unless
the person at the command line says so. docs/settings.md has the same for users.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from pirate_sm.core.on_disk import resolved

SIMULATED: Final = ("bay", "physics", "sim", "trace")
"""Backends that reach nothing outside this program. [decided]"""

_DEVICE: Final = re.compile(r"/dev/(serial/by-(id|path)/)?\w[\w.:+-]*|COM\d+|")

_RUNS = """mission backend robot pipe settings states seed defects fidelity detector also adopt
    ruler start_at_m calibration check twin numbers fitted record no_record resume look at accept
    forecast start_phase speed jitter line fire script yes plain json quiet"""

SCENES: Final[Mapping[str, frozenset[str]]] = {
    command: frozenset(options.split())
    for command, options in {
        "run": _RUNS,
        "check": "paths format fail_on robot pipe settings",
        "compare": "first second",
        "diff": "old new format robot settings",
        "explain": "code robot",
        "export": "recording csv parquet viewers ros2 urdf lichtblick plotjuggler overwrite",
        "fit": "runs robot slip friction torque normal radius threshold write output csv overwrite",
        "graph": "file format output overwrite path counterexample calls settings",
        "list": "what robot",
        "map": "recording output overwrite start_at",
        "plan": "robot to to_phase begin json",
        "repair": "recording output",
        "replay": "recording mission robot pipe begin until",
        "report": "recordings output forecast",
    }.items()
}
"""The commands that a scene may run, with the options that it may give them."""

WRITES: Final[Mapping[str, tuple[str, ...]]] = {
    "run": ("record",),
    "export": ("csv", "parquet", "viewers", "ros2", "urdf", "lichtblick", "plotjuggler"),
    "fit": ("write", "output", "csv"),
    "graph": ("output",),
    "map": ("output",),
    "repair": ("recording", "output"),
    "report": ("recordings", "output"),
}
"""Their options that name what is written, or next to what it is written."""


def is_device(port: str) -> bool:
    """Return whether a port is a device of this machine, or none.

    Addresses of pyserial can be anything: `spy://` writes files, `socket://` reaches a network.
    """
    return _DEVICE.fullmatch(port) is not None


def is_below(place: Path, folder: Path) -> bool:
    """Return whether a path leads to something in a folder, with all links followed."""
    try:
        return resolved(place).is_relative_to(resolved(folder))
    except (OSError, RuntimeError, ValueError):
        return False
