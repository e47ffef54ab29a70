"""Options of `pirate demo`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pirate_sm.cli.completion import named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option


@dataclass(frozen=True, kw_only=True)
class DemoOptions:
    """Play scenes of the gallery, with their reports.

    Without a name they are listed.

    Exit codes: 0 as the scene expects, 1 not so, 2 it cannot be played, 130 stopped by Ctrl-C.
    """

    scene: str | None = argument(
        "[SCENE]", named_files.scenes, "A scene's name, or a file of your own.", default=None
    )
    all: bool = flag("All scenes at full speed, with a page that lists them.", "--all")
    speed: str | None = common.a_speed("Mission time over wall time; else the scene's own.")
    output: Path = option(
        "DIR",
        named_files.folders,
        "Where the reports are written.",
        "--output",
        "-o",
        default=Path("runs/demo"),
    )
    overwrite: bool = common.overwrite()
    debug: bool = common.debug()
