"""Options of `pirate bay`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import flag, option


@dataclass(frozen=True, kw_only=True)
class BayOptions:
    """Emulate a robot's bay behind a serial port until Ctrl-C.

    The name of the port is printed first.
    """

    mission: Annotated[
        str | None,
        option("NAME", named_files.missions, "Robot, pipe and start are those of this mission."),
    ] = None
    robot: common.OneRobot = None
    pipe: Annotated[
        str | None, option("NAME", named_files.pipes, "Where it is; the first pipe shipped.")
    ] = None
    seed: common.Seed = 0
    link: Annotated[
        Path | None, option("PATH", named_files.files, "Make a symbolic link to the port here.")
    ] = None
    log: Annotated[
        Path | None, option("FILE", named_files.files, "JSON Lines of arrays and restarts.")
    ] = None
    overwrite: common.Overwrite = False
    loss: Annotated[str | None, option("SHARE", None, "Frames lost each way, such as 20%.")] = None
    loss_in: Annotated[
        str | None, option("SHARE", None, "In place of --loss: towards the bay.")
    ] = None
    loss_out: Annotated[str | None, option("SHARE", None, "In place of --loss: from the bay.")] = (
        None
    )
    never_two: Annotated[
        bool, flag("Never two frames of a topic lost in a row.", "--never-two")
    ] = False
    corruption: Annotated[str | None, option("SHARE", None, "Bytes changed on their way.")] = None
    delay: Annotated[float, typer.Option(help="Further seconds for every frame.")] = 0.0
    jitter: Annotated[float, typer.Option(help="Up to this many seconds more.")] = 0.0
    reset_at: Annotated[
        list[float] | None, typer.Option(help="Restart after this many seconds. Repeatable.")
    ] = None
    reset_every: Annotated[float, typer.Option(help="Mean seconds between restarts.")] = 0.0
    hang_at: Annotated[float | None, typer.Option(help="Stand still after these seconds.")] = None
    hang_for: Annotated[float | None, typer.Option(help="... for this many seconds.")] = None
    boot: Annotated[float | None, typer.Option(help="Seconds of boot loader and set-up.")] = None
    overrun: Annotated[bool, flag("Whether a full ring loses bytes.", "--overrun/--no-overrun")] = (
        True
    )
    stale_every: Annotated[
        float, typer.Option(help="Mean seconds between spells of repeated values.")
    ] = 0.0
    wrong_md5: Annotated[
        list[str] | None,
        option(
            "state|echo|setpoints",
            candidates.words("state", "echo", "setpoints"),
            "Announce a wrong md5. Repeatable.",
        ),
    ] = None
    unconfigured_at: Annotated[
        list[float] | None,
        typer.Option(help="Obey without echo after this many seconds. Repeatable."),
    ] = None
    spontaneous_at: Annotated[
        list[float] | None, typer.Option(help="A motor moves on its own. Repeatable.")
    ] = None
    motors_started: Annotated[
        bool, flag("Whether the actuators were started.", "--play/--no-play")
    ] = True
    sensors_started: Annotated[
        bool, flag("Whether the sensors were started.", "--set/--no-set")
    ] = True
    old_client: Annotated[
        bool, flag("Lose the host after an overrun (2014-2017).", "--old-client")
    ] = False
    dead_man: Annotated[
        bool, flag("Whether a silent host stops the motors.", "--dead-man/--no-dead-man")
    ] = True
    defects: common.Defects = None
    debug: common.Debug = False
