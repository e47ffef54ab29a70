"""Options of the commands that connect to a robot, `pirate doctor` and `pirate calibrate`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import flag, option


@dataclass(frozen=True, kw_only=True)
class DoctorOptions:
    """Examine a connected robot: what it reports, go or no-go.

    Without --move nothing is sent to its motors. Opening the port restarts most controllers.

    Exit codes: 0 go, 1 no-go, 2 invalid files or arguments, 3 it cannot be connected to.
    """

    port: common.Port = None
    robot: common.OneRobot = None
    baud: common.Baud = None
    seconds: Annotated[float, typer.Option(min=1.0, help="How long to listen.")] = 5.0
    move: Annotated[bool, flag("Send setpoints too: each wheel turns for a moment.", "--move")] = (
        False
    )
    yes: Annotated[bool, flag("With --move: the wheels are free to turn.", "--yes", "-y")] = False
    guard_for: common.GuardFor = None
    calibration: common.Calibration = True
    plain: Annotated[bool, flag("Lines instead of live tables.", "--plain")] = False
    json: Annotated[bool, flag("One JSON object.", "--json")] = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class CalibrateOptions:
    """Straighten the robot and keep what its joints show as zeros.

    Exit codes: 0 kept, 1 not straight or not still, 2 invalid files or arguments, 3 it cannot be
    connected to.
    """

    port: common.Port = None
    robot: common.OneRobot = None
    baud: common.Baud = None
    seconds: Annotated[float, typer.Option(min=1.0, help="How long to measure.")] = 3.0
    limit: Annotated[
        str | None, option("ANGLE", None, "Refuse a zero beyond this, such as '10 deg'.")
    ] = None
    skip: Annotated[
        list[str] | None, option("JOINT", candidates.joints, "Leave this joint out. Repeatable.")
    ] = None
    yes: Annotated[bool, flag("The robot lies straight already; ask nothing.", "--yes", "-y")] = (
        False
    )
    debug: common.Debug = False
