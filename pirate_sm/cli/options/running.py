"""Options of the commands that run missions, `pirate run` and `pirate console`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import typer

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option
from pirate_sm.model.fidelity import USUAL
from pirate_sm.palette import USUAL as USUAL_THEME
from pirate_sm.palette import Theme


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """Run a mission.

    Exit codes: 0 succeeded, 1 mission failed, 2 invalid files or arguments (nothing moved),
    3 backend or link fault, 4 a fault in this program, 5 succeeded but the recording that was asked
    for is incomplete, 129/130/141/143 stopped from outside; the robot is brought to its safe state
    on every way out.
    """

    mission: Annotated[
        str | None,
        argument("[MISSION]", named_files.missions, "A shipped mission's name, or a file."),
    ] = None
    resume: Annotated[
        str | None, option("RUN.mcap", named_files.recordings, "Go on with a run that was cut off.")
    ] = None
    look: Annotated[bool, flag("With --resume: only see whether it can go on.", "--look")] = False
    at: Annotated[
        str | None,
        option("PHASE", candidates.phases, "With --resume: go on with this phase.", "--at"),
    ] = None
    accept: Annotated[
        bool, flag("With --resume: go on without asking, if all is seen.", "--accept")
    ] = False
    adopt: common.Adopt = False
    backend: common.Backend = "sim"
    robot: common.RobotOfMission = None
    pipe: common.PipeOfMission = None
    settings: common.Settings = None
    start_phase: Annotated[
        str | None, option("PHASE", candidates.phases, "Begin with this phase.", "--from")
    ] = None
    states: common.States = None
    seed: common.Seed = 0
    speed: Annotated[
        str | None,
        option(
            "max|realtime|FACTOR",
            candidates.words("max", "realtime"),
            "Mission time over wall time. On a terminal 4, else max.",
        ),
    ] = None
    defects: common.Defects = None
    jitter: common.Jitter = None
    line: common.LineFault = None
    fidelity: common.FidelityOfSim = USUAL
    view: common.View = False
    fire: Annotated[
        list[str] | None,
        option(
            "TRIGGER[=SECONDS]",
            candidates.triggers,
            "In a trace: the trigger that a wait takes. Repeatable, in order.",
        ),
    ] = None
    script: Annotated[
        str | None,
        option("FILE", named_files.scripts, "In a trace: a YAML list of {phase, trigger, after}."),
    ] = None
    port: common.PortOfRobot = None
    baud: common.Baud = None
    guard_for: common.GuardFor = None
    detector: common.Detector = None
    also: common.Also = None
    panel: common.Panel = None
    ruler: common.Ruler = False
    start_at: common.StartAt = None
    calibration: common.Calibration = True
    check: common.Check = True
    twin: common.Twin = None
    fitted: common.Fitted = None
    record: Annotated[
        str | None,
        option("FILE.mcap", named_files.files, "Where the run is kept, in place of runs/."),
    ] = None
    no_record: common.NoRecord = False
    live: Annotated[
        bool, flag("Let Foxglove or Lichtblick look on, on this machine.", "--live")
    ] = False
    yes: Annotated[bool, flag("Take the first answer to every question.", "--yes", "-y")] = False
    plain: Annotated[bool, flag("Lines instead of the live view.", "--plain")] = False
    json: Annotated[bool, flag("JSON Lines on standard output.", "--json")] = False
    quiet: Annotated[bool, flag("Only how it ended.", "--quiet", "-q")] = False
    debug: common.Debug = False
    version: common.Version = False


@dataclass(frozen=True, kw_only=True)
class ConsoleOptions:
    """See the robot and steer it by hand, or take over a mission.

    A mission begins paused. Space brings the robot to its safe state at any time, and so does
    every way out of the console.
    """

    mission: Annotated[
        str | None,
        argument(
            "[MISSION|RUN.mcap]",
            named_files.missions_or_recordings,
            "A shipped mission's name, or a file; a recording to look through.",
        ),
    ] = None
    resume: Annotated[
        str | None, option("RUN.mcap", named_files.recordings, "Take over a run that was cut off.")
    ] = None
    at: Annotated[
        str | None,
        option("PHASE", candidates.phases, "With --resume: go on with this phase.", "--at"),
    ] = None
    adopt: common.Adopt = False
    backend: common.Backend = "sim"
    robot: common.RobotOfMission = None
    pipe: common.PipeOfMission = None
    settings: common.Settings = None
    states: common.States = None
    seed: common.Seed = 0
    speed: Annotated[
        str,
        option(
            "max|realtime|FACTOR",
            candidates.words("max", "realtime"),
            "Mission time over wall time.",
        ),
    ] = "realtime"
    theme: Annotated[
        Theme, typer.Option(help="Its colours. NO_COLOR in the environment: none.")
    ] = USUAL_THEME
    defects: common.Defects = None
    fidelity: common.FidelityOfSim = USUAL
    view: common.View = False
    port: common.PortOfRobot = None
    baud: common.Baud = None
    guard_for: common.GuardFor = None
    detector: common.Detector = None
    also: common.Also = None
    panel: common.Panel = None
    ruler: common.Ruler = False
    start_at: common.StartAt = None
    calibration: common.Calibration = True
    check: common.Check = True
    twin: common.Twin = None
    fitted: common.Fitted = None
    no_record: common.NoRecord = False
    live: Annotated[bool, flag("Serve Foxglove and Lichtblick on this machine.", "--live")] = False
    debug: common.Debug = False
