"""Options of the commands for connected devices: `doctor`, `calibrate` and `panel`."""

from __future__ import annotations

from dataclasses import dataclass

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option, typed
from pirate_sm.cli.options.of_runs import of_run


@dataclass(frozen=True, kw_only=True)
class DoctorOptions:
    """Examine a connected robot: what it reports, go or no-go.

    Without --move nothing is sent to its motors. Opening the port restarts most controllers.

    Exit codes: 0 go, 1 no-go, 2 invalid files or arguments, 3 it cannot be connected to.
    """

    port: str | None = common.port()
    robot: str | None = common.one_robot()
    baud: int | None = of_run("baud")
    seconds: float = typed("How long to listen.", min=1.0, default=5.0)
    move: bool = flag("Send setpoints too: each wheel turns for a moment.", "--move")
    yes: bool = flag("With --move: the wheels are free to turn.", "--yes", "-y")
    guard_for: str | None = of_run("guard_for_s")
    calibration: bool = of_run("calibration")
    plain: bool = flag("Lines instead of live tables.", "--plain")
    json: bool = flag("One JSON object.", "--json")
    debug: bool = common.debug()


@dataclass(frozen=True, kw_only=True)
class CalibrateOptions:
    """Straighten the robot and keep what its joints show as zeros.

    Exit codes: 0 kept, 1 not straight or not still, 2 invalid files or arguments, 3 it cannot be
    connected to.
    """

    port: str | None = common.port()
    robot: str | None = common.one_robot()
    baud: int | None = of_run("baud")
    seconds: float = typed("How long to measure.", min=1.0, default=3.0)
    limit: str | None = option("ANGLE", None, "Refuse a zero beyond this, such as '10 deg'.")
    skip: list[str] | None = option("JOINT", candidates.joints, "Leave this joint out. Repeatable.")
    yes: bool = flag("The robot lies straight already; ask nothing.", "--yes", "-y")
    debug: bool = common.debug()


@dataclass(frozen=True, kw_only=True)
class PanelOptions:
    """Show what each control of a panel sends, until Ctrl-C. Nothing moves.

    Without a name: which panels and which MIDI devices there are.

    Exit codes: 0 shown, 2 invalid files or arguments, 3 the panel was lost.
    """

    name: str | None = argument(
        "[NAME[:DEVICE]|DEVICE]",
        named_files.panels,
        "A panel's name, or a file; a MIDI device alone shows bare numbers.",
        default=None,
    )
    debug: bool = common.debug()
