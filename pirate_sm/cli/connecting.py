"""The commands that connect to a robot without running a mission, and their options."""

from __future__ import annotations

from typing import Annotated

import typer

_PORT = typer.Option(metavar="PORT", help="/dev/ttyACM0, or a pyserial URL.")
_ROBOT = typer.Option(metavar="NAME", help="Which robot; the first one shipped.")
_BAUD = typer.Option(min=1, help="In place of the robot's own rate.")
GUARD_FOR = (
    "How long the port is guarded if the robot does not confirm that it has stopped; 10 min."
)
_GUARD_FOR = typer.Option(metavar="DURATION", help=GUARD_FOR)
_DEBUG = typer.Option("--debug", help="Show tracebacks.")


def doctor(
    port: Annotated[str, _PORT],
    robot: Annotated[str | None, _ROBOT] = None,
    baud: Annotated[int | None, _BAUD] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="How long to listen.")] = 5.0,
    move: Annotated[
        bool, typer.Option("--move", help="Send setpoints too: each wheel turns for a moment.")
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="With --move: the wheels are free to turn.")
    ] = False,
    guard_for: Annotated[str | None, _GUARD_FOR] = None,
    calibration: Annotated[
        bool,
        typer.Option("--calibration/--no-calibration", help="Whether its joint zeros are used."),
    ] = True,
    plain: Annotated[bool, typer.Option("--plain", help="Lines instead of live tables.")] = False,
    json: Annotated[bool, typer.Option("--json", help="One JSON object.")] = False,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Look at a connected robot: what it says, what is missing, go or no-go.

    Without --move nothing is sent to its motors. Opening the port restarts most controllers.

    Exit codes: 0 go, 1 no-go, 2 invalid files or arguments, 3 it cannot be connected to.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.doctor import DoctorWishes, run_doctor

        return run_doctor(
            DoctorWishes(
                port=port,
                robot=robot,
                baud=baud,
                seconds=seconds,
                move=move,
                yes=yes,
                guard_for=guard_for,
                plain=plain,
                json=json,
                calibration=calibration,
            )
        )

    raise typer.Exit(guarded(work, debug))


def calibrate(
    port: Annotated[str, _PORT],
    robot: Annotated[str | None, _ROBOT] = None,
    baud: Annotated[int | None, _BAUD] = None,
    seconds: Annotated[float, typer.Option(min=1.0, help="How long to measure.")] = 3.0,
    limit: Annotated[
        str | None,
        typer.Option(metavar="ANGLE", help="Refuse a zero beyond this, such as '10 deg'."),
    ] = None,
    skip: Annotated[
        list[str] | None,
        typer.Option(metavar="JOINT", help="Leave this joint out. Repeatable."),
    ] = None,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="The robot lies straight already; ask nothing.")
    ] = False,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Straighten the robot, and keep what its joints then show as their zeros.

    Exit codes: 0 kept, 1 not straight or not still, 2 invalid files or arguments, 3 it cannot be
    connected to.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.calibrate import CalibrateWishes, run_calibrate

        return run_calibrate(
            CalibrateWishes(
                port=port,
                robot=robot,
                baud=baud,
                seconds=seconds,
                limit=limit,
                skip=skip or [],
                yes=yes,
            )
        )

    raise typer.Exit(guarded(work, debug))
