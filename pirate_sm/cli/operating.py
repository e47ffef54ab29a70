"""The command `pirate console` and its options."""

from __future__ import annotations

from typing import Annotated

import typer

from pirate_sm.cli.connecting import GUARD_FOR


def console(
    mission: Annotated[
        str | None,
        typer.Argument(
            metavar="[MISSION|RUN.mcap]",
            help="A shipped mission's name, or a file; a recording to look through.",
        ),
    ] = None,
    backend: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="sim: the kinematic simulator; trace: nothing moves; serial: the real robot; "
            "others: pirate list backends.",
        ),
    ] = "sim",
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="In place of the mission's own.")
    ] = None,
    pipe: Annotated[
        str | None, typer.Option(metavar="NAME", help="In place of the mission's own.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter's value. Repeatable."),
    ] = None,
    states: Annotated[
        list[str] | None,
        typer.Option(
            "--state",
            metavar="REGION=STATE",
            help="The robot is in this state, in place of starts_in.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of everything random.")] = 0,
    speed: Annotated[
        str,
        typer.Option(metavar="max|realtime|FACTOR", help="Mission time over wall time."),
    ] = "realtime",
    defects: Annotated[
        list[str] | None,
        typer.Option("--defect", metavar="NAME", help="Switch on a known defect. Repeatable."),
    ] = None,
    port: Annotated[
        str | None,
        typer.Option(metavar="PORT", help="Of the real robot: /dev/ttyACM0, or a pyserial URL."),
    ] = None,
    baud: Annotated[
        int | None, typer.Option(min=1, help="In place of the robot's own rate.")
    ] = None,
    guard_for: Annotated[
        str | None,
        typer.Option(metavar="DURATION", help=GUARD_FOR),
    ] = None,
    detector: Annotated[
        str | None,
        typer.Option(
            metavar="sim|odometry|operator|socket:ADDRESS",
            help="Who says where the robot is. For sim: sim, for serial: odometry.",
        ),
    ] = None,
    start_at: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Where odometry takes the first wheel to begin."),
    ] = None,
    calibration: Annotated[
        bool,
        typer.Option("--calibration/--no-calibration", help="Whether its joint zeros are used."),
    ] = True,
    check: Annotated[
        bool, typer.Option("--check/--no-check", help="Whether a faulty mission is refused.")
    ] = True,
    no_record: Annotated[bool, typer.Option("--no-record", help="Nothing is kept.")] = False,
    live: Annotated[
        bool, typer.Option("--live", help="Serve Foxglove and Lichtblick on this machine.")
    ] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """See the robot and steer it: by hand, or with a mission that one can take over.

    A mission begins paused. Space brings the robot to its safe state at any time, and so does
    every way out of the console.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.console import open_console
        from pirate_sm.cli.recording import RecordingWishes
        from pirate_sm.cli.run import read_duration, read_length, read_pairs, read_speed
        from pirate_sm.wiring import Order

        order = Order(
            mission=mission or "",
            backend=backend,
            robot=robot,
            pipe=pipe,
            settings=read_pairs("--set", settings or [], "NAME=VALUE"),
            states=read_pairs("--state", states or [], "REGION=STATE") or None,
            seed=seed,
            defects=tuple(dict.fromkeys(defects or [])),
            port=port,
            baud=baud,
            guard_for_s=read_duration("--guard-for", guard_for),
            detector=detector,
            start_at_m=read_length("--start-at", start_at),
            calibration=calibration,
            check=check,
        )
        recording = RecordingWishes(None, no_record, live)
        return open_console(order, read_speed(speed, 1.0), recording, debug=debug)

    raise typer.Exit(guarded(work, debug))
