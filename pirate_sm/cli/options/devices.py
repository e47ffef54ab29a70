"""Options of the commands for connected devices, cameras and the emulated bay."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal

from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options import common
from pirate_sm.cli.options.common import of_run
from pirate_sm.cli.options.declaring import CommandOptions, argument, flag, option, typed


@dataclass(frozen=True, kw_only=True)
class DoctorOptions(CommandOptions):
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


@dataclass(frozen=True, kw_only=True)
class CalibrateOptions(CommandOptions):
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


@dataclass(frozen=True, kw_only=True)
class PanelOptions(CommandOptions):
    """Show what each control of a panel sends, until Ctrl-C. Nothing moves.

    Without a name: which panels and which MIDI devices there are.

    Exit codes: 0 shown, 2 invalid files or arguments, 3 the panel was lost.
    """

    name: str | None = argument(
        "[NAME[:DEVICE]|DEVICE]",
        candidates.panels,
        "A panel's name, or a file; a MIDI device alone shows bare numbers.",
        default=None,
    )


@dataclass(frozen=True, kw_only=True)
class BayOptions(CommandOptions):
    """Emulate a robot's bay behind a serial port until Ctrl-C.

    The name of the port is printed first.
    """

    mission: str | None = option(
        "NAME", candidates.missions, "Robot, pipe and start are those of this mission."
    )
    robot: str | None = common.one_robot()
    pipe: str | None = common.a_pipe("Pipe it is in (default: the first bundled one).")
    seed: int = of_run("seed")
    link: Path | None = option("PATH", candidates.files, "Make a symbolic link to the port here.")
    log: Path | None = option("FILE", candidates.files, "JSON Lines of arrays and restarts.")
    overwrite: bool = common.overwrite()
    loss: str | None = option("SHARE", None, "Frames lost each way, such as 20%.")
    loss_in: str | None = option("SHARE", None, "Instead of --loss: towards the bay.")
    loss_out: str | None = option("SHARE", None, "Instead of --loss: from the bay.")
    never_two: bool = flag("Never two frames of a topic lost in a row.", "--never-two")
    corruption: str | None = option("SHARE", None, "Bytes changed on their way.")
    delay: float = typed("Further seconds for every frame.", default=0.0)
    jitter: float = typed("Up to this many seconds more.", default=0.0)
    reset_at: list[float] | None = typed("Restart after this many seconds. Repeatable.")
    reset_every: float = typed("Mean seconds between restarts.", default=0.0)
    hang_at: float | None = typed("Hang the firmware after this many seconds.")
    hang_for: float | None = typed("... for this many seconds.")
    boot: float | None = typed("Seconds of boot loader and set-up.")
    overrun: bool = flag(
        "Lose bytes when the ring is full.", "--overrun/--no-overrun", default=True
    )
    stale_every: float = typed("Mean seconds between spells of repeated values.", default=0.0)
    wrong_md5: list[str] | None = option(
        "state|echo|setpoints",
        candidates.words("state", "echo", "setpoints"),
        "Announce a wrong md5. Repeatable.",
    )
    unconfigured_at: list[float] | None = typed(
        "Obey without echo after this many seconds. Repeatable."
    )
    spontaneous_at: list[float] | None = typed("A motor moves on its own. Repeatable.")
    motors_started: bool = flag("Start with actuators on.", "--play/--no-play", default=True)
    sensors_started: bool = flag("Start with sensors on.", "--set/--no-set", default=True)
    old_client: bool = flag("Lose the host after an overrun (2014-2017).", "--old-client")
    dead_man: bool = flag(
        "Stop the motors when the host is silent.", "--dead-man/--no-dead-man", default=True
    )
    defects: list[str] | None = of_run("defects")


camera_file = partial(argument, "CAMERA", candidates.cameras, "Name or path of a camera's file.")
inside = partial(option, "NxM", None, "Corners inside of the chessboard.", "--board", default="9x6")
square_sides = partial(option, "LENGTH", None, "Sides of its squares.", default="25 mm")
pictures = partial(
    option, "FILES", candidates.files, "Images instead of the camera, such as 'seen/*.png'."
)
writes = partial(flag, "Write it into the camera's file.", "--write/--no-write", default=True)


@dataclass(frozen=True, kw_only=True)
class PrintOptions(CommandOptions):
    """Write the chessboard and the tags as sheets to print.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    output: Path = option(
        "FOLDER", candidates.files, "Where they are written.", "--output", "-o", default=Path()
    )
    board: str = inside()
    square: str = square_sides()
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class CalibrateCameraOptions(CommandOptions):
    """Measure the lens by a chessboard held before the camera.

    It wants at least 15 sharp boards in all parts of the picture, tilted to each side.

    Exit codes: 0 measured, 1 these boards are not enough, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    images: str | None = pictures()
    board: str = inside()
    square: str = square_sides()
    model: Literal["fisheye", "brown"] | None = typed(
        "Of the lens; otherwise that in the file, else fisheye."
    )
    boards: int = typed("How many to collect.", min=15, default=25)
    seconds: float = typed("How long a live camera looks for them.", min=1.0, default=180.0)
    write: bool = writes()


@dataclass(frozen=True, kw_only=True)
class SurveyOptions(CommandOptions):
    """Find where the camera hangs, by tags or points.

    Exit codes: 0 found, 1 what is seen fits no place of it, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    images: str | None = pictures()
    write: bool = writes()


@dataclass(frozen=True, kw_only=True)
class LookOptions(CommandOptions):
    """Show what is found in a picture of the camera.

    Exit codes: 0 the robot is seen, 1 it is not, 2 invalid files or arguments.
    """

    camera: str = camera_file()
    images: str | None = pictures()
    robot: str | None = common.one_robot()
    pipe: str = common.a_pipe("In which a synthetic camera sees the robot.", default="mitre_90")
    output: Path | None = option(
        "OUT", candidates.files, "Write the picture: .png or .jpg.", "--output", "-o"
    )
    overwrite: bool = common.overwrite()
