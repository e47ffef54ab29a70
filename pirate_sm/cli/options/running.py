"""Options of the commands that run missions, `pirate run`, `pirate console` and `pirate demo`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option, typed
from pirate_sm.model.fidelity import USUAL, Fidelity
from pirate_sm.palette import USUAL as USUAL_THEME
from pirate_sm.palette import Theme


@dataclass(frozen=True, kw_only=True)
class _RobotRunOptions:
    """Options of the commands that run a robot: which one, where, and what watches it."""

    backend: str = option(
        "NAME",
        candidates.backends,
        "sim: the kinematic simulator; physics: MuJoCo; bay: the serial link to an emulated "
        "robot; trace: nothing moves; serial: the real robot; others: pirate list backends.",
        default="sim",
    )
    robot: str | None = common.a_robot("Robot to use instead of the mission's.", "--robot")
    pipe: str | None = common.a_pipe("Pipe to use instead of the mission's.", "--pipe")
    settings: list[str] | None = common.settings()
    states: list[str] | None = option(
        "REGION=STATE",
        candidates.states,
        "The robot is in this state, instead of starts_in.",
        "--state",
    )
    seed: int = common.seed()
    defects: list[str] | None = common.defects()
    fidelity: Fidelity = typed(
        "Of sim; fast computes half the iterations and is coarser.", "--fidelity", default=USUAL
    )
    view: bool = flag("Show the backend physics in MuJoCo's own viewer.", "--view")
    port: str | None = common.a_port(
        "Of the real robot: /dev/ttyACM0, or a pyserial URL.", "--port"
    )
    baud: int | None = common.baud()
    guard_for: str | None = common.guard_for()
    detector: str | None = option(
        "sim|odometry|vision:CAMERA|NAME",
        candidates.detectors,
        "What reports where the robot is. For sim: sim, for serial: odometry.",
    )
    also: str | None = option(
        "DETECTOR",
        candidates.detectors,
        "A second detector, to compare: its words are logged and do nothing.",
    )
    panel: str | None = option(
        "NAME[:DEVICE]",
        named_files.panels,
        "A MIDI control panel, with its stop; others: pirate panel.",
        "--panel",
    )
    adopt: bool = flag("Adopt a robot that is clamped already, as its sensors show it.", "--adopt")
    ruler: bool = flag("In sim: a ruler outside measures the robot's speed, for slip.", "--ruler")
    start_at: str | None = option("LENGTH", None, "Where the first wheel begins, for odometry.")
    calibration: bool = common.calibration()
    check: bool = common.check()
    twin: str | None = option(
        "FILE",
        named_files.twins,
        "Numbers of the simulated robot, from pirate fit --robot.",
        "--twin",
    )
    fitted: str | None = option(
        "FILE", named_files.twins, "Numbers of its motors to judge it by, from pirate fit."
    )
    start_phase: str | None = option("PHASE", candidates.phases, "Begin with this phase.", "--from")
    no_record: bool = flag("Record nothing.", "--no-record")
    live: bool = flag("Stream to Foxglove or Lichtblick on this machine.", "--live")


@dataclass(frozen=True, kw_only=True)
class RunOptions(_RobotRunOptions):
    """Run a mission.

    Exit codes: 0 succeeded, 1 mission failed, 2 invalid files or arguments (nothing moved),
    3 backend or link fault, 4 an internal error, 5 succeeded but the recording that was asked
    for is incomplete, 129/130/141/143 stopped from outside; the robot is brought to its safe state
    on every way out.
    """

    mission: str | None = argument(
        "[MISSION]", named_files.missions, "A shipped mission's name, or a file.", default=None
    )
    resume: str | None = option("RUN.mcap", named_files.recordings, "Resume an interrupted run.")
    at: str | None = option(
        "PHASE", candidates.phases, "With --resume: continue with this phase.", "--at"
    )
    look: bool = flag("With --resume: only check whether it can continue.", "--look")
    accept: bool = flag("With --resume: continue without asking, if all is seen.", "--accept")
    speed: str | None = common.a_speed("Mission time over wall time. On a terminal 4, else max.")
    jitter: list[str] | None = option(
        "NAME=VALUE",
        candidates.words("start=", "friction=", "diameter="),
        "How far a simulated run may differ: start=20mm, friction=20%, diameter=2mm.",
        "--jitter",
    )
    line: list[str] | None = option(
        "NAME=VALUE",
        candidates.words(
            "loss_in=",
            "loss_out=",
            "corruption=",
            "delay=",
            "jitter=",
            "reset_every=",
            "cut_after=",
        ),
        "Of bay: loss_in, loss_out, corruption, delay, jitter, reset_every, cut_after.",
        "--line",
    )
    fire: list[str] | None = option(
        "TRIGGER[=SECONDS]",
        candidates.triggers,
        "In a trace: the trigger that a wait takes. Repeatable, in order.",
    )
    script: str | None = option(
        "FILE", named_files.scripts, "In a trace: a YAML list of {phase, trigger, after}."
    )
    record: str | None = option(
        "FILE.mcap", named_files.files, "Where the run is recorded, instead of runs/."
    )
    yes: bool = flag("Give the first answer to every question.", "--yes", "-y")
    plain: bool = flag("Lines instead of the live view.", "--plain")
    json: bool = flag("JSON Lines on standard output.", "--json")
    quiet: bool = flag("Print only the result.", "--quiet", "-q")
    debug: bool = common.debug()
    version: bool = common.version()


@dataclass(frozen=True, kw_only=True)
class ConsoleOptions(_RobotRunOptions):
    """See the robot and steer it by hand, or take over a mission.

    A mission begins paused. Space brings the robot to its safe state at any time, and so does
    every way out of the console.
    """

    mission: str | None = argument(
        "[MISSION|RUN.mcap]",
        named_files.missions_or_recordings,
        "A shipped mission's name, or a file; a recording to look through.",
        default=None,
    )
    resume: str | None = option("RUN.mcap", named_files.recordings, "Take over an interrupted run.")
    at: str | None = option(
        "PHASE", candidates.phases, "With --resume: continue with this phase.", "--at"
    )
    speed: str = common.a_speed("Mission time over wall time.", default="realtime")
    theme: Theme = typed("Its colours. NO_COLOR in the environment: none.", default=USUAL_THEME)
    debug: bool = common.debug()


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
