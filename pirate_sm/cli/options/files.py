"""Options of the commands about files, such as `list`, `graph` and `new`, and about settings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options import common
from pirate_sm.cli.options.common import of_run
from pirate_sm.cli.options.declaring import CommandOptions, argument, flag, option, typed


@dataclass(frozen=True, kw_only=True)
class ListOptions(CommandOptions):
    """Show the names of robots, missions, pipes, backends and more.

    The rest are the commands, signals and defects of a robot, detectors and control panels.
    """

    what: (
        Literal[
            "robots",
            "commands",
            "signals",
            "defects",
            "missions",
            "pipes",
            "cameras",
            "backends",
            "detectors",
            "panels",
        ]
        | None
    ) = argument(None, None, "All of them when nothing is named.", default=None)
    robot: str | None = common.a_robot("Whose commands, signals and defects.")


@dataclass(frozen=True, kw_only=True)
class SchemaOptions(CommandOptions):
    """Print the JSON Schema by which an editor completes files."""

    files: Literal[
        "mission",
        "pipe",
        "profile",
        "chart",
        "profile_extension",
        "chart_extension",
        "camera",
        "panel",
        "campaign",
        "scene",
        "twin",
    ] = argument(None, None, "Of which files.")
    robot: str | None = common.a_robot("Missions for this robot: its commands, its states.")


@dataclass(frozen=True, kw_only=True)
class GraphOptions(CommandOptions):
    """Draw a mission, a robot's chart or a pipe.

    A mission or a chart can also be written as SCXML, for other programs.

    Exit codes: 0 drawn, 2 invalid files or arguments.
    """

    file: str = argument(
        "FILE", candidates.drawable, "A mission, a robot, a chart or a pipe: name or path."
    )
    format: Literal["mermaid", "dot", "svg", "scxml"] | None = typed(
        "As the name of the output ends, else mermaid.", "--format"
    )
    output: Path | None = common.output()
    overwrite: bool = common.overwrite()
    path: str | None = option(
        "A,B,C", candidates.phases_in_order, "Phases or states to mark, in order.", "--highlight"
    )
    counterexample: Path | None = option(
        "SCRIPT", candidates.scripts, "Mark the path of this event sequence."
    )
    calls: bool = flag("Draw the missions that it calls, too.", "--calls")
    settings: list[str] | None = of_run("settings")


@dataclass(frozen=True, kw_only=True)
class ImportOptions(CommandOptions):
    """Make a robot's chart from SCXML.

    It has one <parallel> with a <state> for each region; whatever else a chart cannot have is
    listed with its line and column.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    file: Path = argument("FILE.scxml", candidates.charts_in_scxml, "A statechart in SCXML 1.0.")
    output: Path | None = common.output()
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class PlanOptions(CommandOptions):
    """Print the fewest commands from one configuration to another.

    No command is proposed that releases a clamp while no other part holds.

    Exit codes: 0 there are commands, or none are needed, 1 there are none, 2 invalid files or
    arguments.
    """

    robot: str = argument("ROBOT", candidates.robots, "A shipped robot, or its folder.")
    to: list[str] | None = option(
        "REGION=STATE,…",
        candidates.states_of_several,
        "Where to; regions not named do not matter.",
        "--to",
    )
    to_phase: str | None = option(
        "MISSION:PHASE", candidates.phases_of_missions, "To where a mission can begin this phase."
    )
    begin: list[str] | None = option(
        "REGION=STATE,…",
        candidates.states_of_several,
        "Start from these states instead of its initial ones.",
        "--from",
    )
    json: bool = flag("One JSON object, for programs.", "--json")


@dataclass(frozen=True, kw_only=True)
class FirmwareOptions(CommandOptions):
    """Write a robot's tables for its controller's firmware.

    They are a header of C++, firmware/robot.h of the sketch.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    robot: str = argument("ROBOT", candidates.robots, "A shipped robot, or its folder.")
    output: Path | None = common.output()
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class RobotOptions(CommandOptions):
    """Draw a robot, and write what each command needs and does.

    The picture shows it to scale, and which way each setpoint moves it. A wrong sign is marked
    there. -o NAME.svg writes the picture alone.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    name: str | None = argument(
        "ROBOT",
        candidates.robots,
        "Robot or its folder (default: the first bundled one).",
        default=None,
    )
    html: bool = flag("One HTML file instead of Markdown.", "--html")
    output: Path | None = common.output()
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class NewMissionOptions(CommandOptions):
    """Write a mission that runs.

    With --pipe it leads along a route to its end, composed of the shipped missions that pass the
    joints on the way; the robot's profile says which (`travel`).
    """

    name: str = argument(None, None, "Its name; the file is NAME.yaml.")
    robot: str | None = common.a_robot("Robot it is for (default: the first bundled one).")
    pipe: str | None = common.a_pipe("Along a route of this pipe: name or file.")
    route: str | None = option("NAME", candidates.routes, "Along this route, instead of the first.")


@dataclass(frozen=True, kw_only=True)
class NewPipeOptions(CommandOptions):
    """Write a pipe with one bend, or a network of round pipes."""

    name: str = argument(None, None, "Its name; the file is NAME.yaml.")
    robot: str | None = common.a_robot("Robot it is for (default: the first bundled one).")
    round: bool = flag("Round pipes, with a tee and a branch.", "--round")


@dataclass(frozen=True, kw_only=True)
class NewCampaignOptions(CommandOptions):
    """Write a campaign that runs.

    A mission runs many times, with a defect and without.
    """

    name: str = argument(None, None, "Its name; the file is NAME.yaml.")
    mission: str = option(
        "MISSION",
        candidates.missions,
        "Which mission it runs: name or file.",
        default="mitre_bend",
    )


@dataclass(frozen=True, kw_only=True)
class NewRobotOptions(CommandOptions):
    """Write a small robot that runs, or a copy of another one."""

    name: str = argument(None, None, "Its name; the folder is NAME.")
    like: str | None = option("ROBOT", candidates.robots, "A copy of this robot, to be changed.")


@dataclass(frozen=True, kw_only=True)
class NewCameraOptions(CommandOptions):
    """Write a copy of a camera's file, to be changed."""

    name: str = argument(None, None, "Its name; the file is NAME.yaml.")
    like: str = option(
        "CAMERA", candidates.cameras, "Of which camera: name or file.", default="setup_3"
    )


@dataclass(frozen=True, kw_only=True)
class NewPanelOptions(CommandOptions):
    """Write a copy of a control panel's file, to be changed."""

    name: str = argument(None, None, "Its name; the file is NAME.yaml.")
    like: str = option(
        "PANEL", candidates.panels, "Of which panel: name or file.", default="nanokontrol2"
    )


@dataclass(frozen=True, kw_only=True)
class ConfigOptions(CommandOptions):
    """Show the active settings and where each comes from.

    The command line comes before the environment, that before pirate.toml of a project, that
    before the user's own file.

    Exit codes: 0 shown, 2 a file has faults.
    """

    what: Literal["show", "path"] = argument(
        None, None, "The settings, or where their files are.", default="show"
    )
    format: Literal["text", "json"] = typed(
        "Text to read, or JSON for programs.", "--format", default="text"
    )


@dataclass(frozen=True, kw_only=True)
class CacheOptions(CommandOptions):
    """Show or clear the kept results of checks.

    `pirate check`, and the check before a simulated run, use a result again while all files that it
    depends on are as they were. The oldest are removed as they become too many.

    Exit codes: 0 shown or cleared, 2 the folder cannot be used.
    """

    what: Literal["show", "clear"] = argument(
        None, None, "Show where they are and how many, or remove them.", default="show"
    )


@dataclass(frozen=True, kw_only=True)
class CompletionOptions(CommandOptions):
    """Print a script with which a shell completes command lines.

    bash: write it to ~/.pirate_sm.bash, and `source ~/.pirate_sm.bash` into ~/.bashrc.

    zsh: write it to ~/.pirate_sm.zsh, and `source ~/.pirate_sm.zsh` into ~/.zshrc.

    fish: write it to ~/.config/fish/conf.d/pirate_sm.fish.
    """

    shell: Literal["bash", "zsh", "fish"] = argument(None, None, "For which shell.")
