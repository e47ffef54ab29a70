"""Options of the commands that run missions, `pirate run`, `pirate console` and `pirate demo`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options import common
from pirate_sm.cli.options.common import ahead_of, of_all_runs, read_choices, read_fire, values_of
from pirate_sm.cli.options.declaring import (
    CommandOptions,
    argument,
    declared,
    flag,
    option,
    placed,
    typed,
)
from pirate_sm.core.palette import USUAL as USUAL_THEME
from pirate_sm.core.palette import Theme

if TYPE_CHECKING:
    from pirate_sm.running.wiring import Order


@dataclass(frozen=True, kw_only=True)
class _RobotRunOptions(CommandOptions):
    """Options of the commands that run a robot: which one, where, and what watches it."""

    mission: str | None = None
    written: Mapping[str, Any] = of_all_runs(jitter=False)
    adopt: bool = ahead_of(
        "ruler", flag("Adopt a robot that is clamped already, as its sensors show it.", "--adopt")
    )
    breakpoints: list[str] | None = ahead_of(
        "jitter",
        option(
            "PHASE|[FILE:]LINE",
            candidates.phases,
            "Pause before this phase, end or line. Repeatable.",
            "--break",
        ),
    )
    no_record: bool = ahead_of("jitter", flag("Record nothing.", "--no-record"))
    live: bool = ahead_of(
        "jitter", flag("Stream to Foxglove or Lichtblick on this machine.", "--live")
    )
    page: bool = ahead_of(
        "jitter", flag("Serve the report to browsers on this machine, during the run.", "--page")
    )

    def order(self) -> Order:
        """Return the order of the run; without a mission its name is empty.

        Raises:
            LoadError: A file that belongs to it cannot be used.
            UsageError: An option does not have the right form.
        """
        from pirate_sm.running.wiring import Order

        given = tuple(self.breakpoints or ())
        return Order(self.mission or "", **values_of(self.written), breakpoints=given)


@dataclass(frozen=True, kw_only=True)
class RunOptions(_RobotRunOptions):
    """Run a mission.

    Exit codes: 0 succeeded, 1 mission failed, 2 invalid files or arguments (nothing moved),
    3 backend or link fault, 4 an internal error, 5 succeeded but the recording that was asked
    for is incomplete, 129/130/141/143 stopped from outside; the robot is brought to its safe state
    on every way out.
    """

    written: Mapping[str, Any] = of_all_runs(jitter=True)
    mission: str | None = argument(
        "[MISSION]", candidates.missions, "A shipped mission's name, or a file.", default=None
    )
    resume: str | None = ahead_of(
        "jitter", option("RUN.mcap", candidates.recordings, "Resume an interrupted run.")
    )
    at: str | None = ahead_of("jitter", common.at())
    look: bool = ahead_of(
        "jitter", flag("With --resume: only check whether it can continue.", "--look")
    )
    accept: bool = ahead_of(
        "jitter", flag("With --resume: continue without asking, if all is seen.", "--accept")
    )
    speed: str | None = ahead_of(
        "jitter", common.a_speed("Mission time over wall time. On a terminal 4, else max.")
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
        "FILE", candidates.scripts, "In a trace: a YAML list of {phase, trigger, after}."
    )
    record: str | None = option(
        "FILE.mcap", candidates.files, "Where the run is recorded, instead of runs/."
    )
    yes: bool = flag("Give the first answer to every question.", "--yes", "-y")
    plain: bool = flag("Lines instead of the live view.", "--plain")
    json: bool = flag("JSON Lines on standard output.", "--json")
    quiet: bool = flag("Print only the result.", "--quiet", "-q")
    version: bool = placed(declared(common.VERSION, False), inf)

    def order(self) -> Order:
        """Return the order of the run, with what is for a trace and for the emulated bay.

        Raises:
            LoadError: The script cannot be used; it lists all that is wrong.
            UsageError: An option does not have the right form.
        """
        from pirate_sm.core.models import LineFaults
        from pirate_sm.running.wiring.backends import read_script

        listed, course = ((), ()) if self.script is None else read_script(Path(self.script))
        return replace(
            super().order(),
            firings=(*read_fire(self.fire or ()), *listed),
            course=course,
            line=read_choices("--line", self.line, LineFaults) if self.line else None,
        )


@dataclass(frozen=True, kw_only=True)
class ConsoleOptions(_RobotRunOptions):
    """See the robot and steer it by hand, or take over a mission.

    A mission begins paused. Space brings the robot to its safe state at any time, and so does
    every way out of the console.
    """

    mission: str | None = argument(
        "[MISSION|RUN.mcap]",
        candidates.missions_or_recordings,
        "A shipped mission's name, or a file; a recording to look through.",
        default=None,
    )
    resume: str | None = option("RUN.mcap", candidates.recordings, "Take over an interrupted run.")
    at: str | None = common.at()
    speed: str = common.a_speed("Mission time over wall time.", default="realtime")
    theme: Theme = typed("Its colours. NO_COLOR in the environment: none.", default=USUAL_THEME)


@dataclass(frozen=True, kw_only=True)
class DemoOptions(CommandOptions):
    """Play scenes of the gallery, with their reports.

    Without a name they are listed.

    Exit codes: 0 as the scene expects, 1 not so, 2 it cannot be played, 130 stopped by Ctrl-C.
    """

    scene: str | None = argument(
        "[SCENE]", candidates.scenes, "A scene's name, or a file of your own.", default=None
    )
    all: bool = flag("All scenes at full speed, with a page that lists them.", "--all")
    speed: str | None = common.a_speed("Mission time over wall time; else the scene's own.")
    output: Path = option(
        "DIR",
        candidates.folders,
        "Where the reports are written.",
        "--output",
        "-o",
        default=Path("runs/demo"),
    )
    overwrite: bool = common.overwrite()
