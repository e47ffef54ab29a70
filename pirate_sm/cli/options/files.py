"""Options of the commands about files, such as `list`, `schema`, `graph`, `import` and `new`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common


@dataclass(frozen=True, kw_only=True)
class ListOptions:
    """Show the names of robots, missions, pipes, backends and more.

    The rest are the commands, signals and defects of a robot, detectors and control panels.
    """

    what: Annotated[
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
        | None,
        typer.Argument(help="All of them when nothing is named."),
    ] = None
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            autocompletion=named_files.robots,
            help="Whose commands, signals and defects.",
        ),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class SchemaOptions:
    """Print the JSON Schema by which an editor completes files."""

    files: Annotated[
        Literal[
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
        ],
        typer.Argument(help="Of which files."),
    ]
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            autocompletion=named_files.robots,
            help="Missions for this robot: its commands, its states.",
        ),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class GraphOptions:
    """Draw a mission, a robot's chart or a pipe.

    A mission or a chart can also be written as SCXML, for other programs.

    Exit codes: 0 drawn, 2 invalid files or arguments.
    """

    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE",
            autocompletion=named_files.drawable,
            help="A mission, a robot, a chart or a pipe: name or path.",
        ),
    ]
    format: Annotated[
        Literal["mermaid", "dot", "svg", "scxml"] | None,
        typer.Option("--format", help="As the name of the output ends, else mermaid."),
    ] = None
    output: common.Output = None
    overwrite: common.Overwrite = False
    path: Annotated[
        str | None,
        typer.Option(
            "--highlight",
            metavar="A,B,C",
            autocompletion=candidates.phases_in_order,
            help="Phases or states to mark, in order.",
        ),
    ] = None
    counterexample: Annotated[
        Path | None,
        typer.Option(
            metavar="SCRIPT",
            autocompletion=named_files.scripts,
            help="Mark the way that this course of events takes.",
        ),
    ] = None
    calls: Annotated[
        bool, typer.Option("--calls", help="Draw the missions that it calls, too.")
    ] = False
    settings: common.Settings = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class ImportOptions:
    """Make a robot's chart from SCXML.

    It has one <parallel> with a <state> for each region; whatever else a chart cannot have is
    listed with its line and column.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE.scxml",
            autocompletion=named_files.charts_in_scxml,
            help="A statechart in SCXML 1.0.",
        ),
    ]
    output: common.Output = None
    overwrite: common.Overwrite = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class PlanOptions:
    """Print the fewest commands from one configuration to another.

    No command is proposed that lets go of a clamp while no other part holds.

    Exit codes: 0 there are commands, or none are needed, 1 there are none, 2 invalid files or
    arguments.
    """

    robot: Annotated[
        str,
        typer.Argument(
            metavar="ROBOT",
            autocompletion=named_files.robots,
            help="A shipped robot, or its folder.",
        ),
    ]
    to: Annotated[
        list[str] | None,
        typer.Option(
            "--to",
            metavar="REGION=STATE,…",
            autocompletion=candidates.states_of_several,
            help="Where to; regions not named do not matter.",
        ),
    ] = None
    to_phase: Annotated[
        str | None,
        typer.Option(
            metavar="MISSION:PHASE",
            autocompletion=candidates.phases_of_missions,
            help="To where a mission can begin this phase.",
        ),
    ] = None
    begin: Annotated[
        list[str] | None,
        typer.Option(
            "--from",
            metavar="REGION=STATE,…",
            autocompletion=candidates.states_of_several,
            help="From where, in place of its initial states.",
        ),
    ] = None
    json: Annotated[bool, typer.Option("--json", help="One JSON object, for programs.")] = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class RobotOptions:
    """Write a robot's page: what each command needs and leads to.

    Exit codes: 0 written, 2 invalid files or arguments.
    """

    name: Annotated[
        str | None,
        typer.Argument(
            metavar="ROBOT",
            autocompletion=named_files.robots,
            help="A shipped robot, or its folder; the first shipped.",
        ),
    ] = None
    html: Annotated[bool, typer.Option("--html", help="One HTML file in place of Markdown.")] = (
        False
    )
    output: common.Output = None
    overwrite: common.Overwrite = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class NewMissionOptions:
    """Write a mission that runs.

    With --pipe it leads along a route to its end, composed of the shipped missions that pass the
    joints on the way; the robot's profile says which (`travel`).
    """

    name: Annotated[str, typer.Argument(help="Its name; the file is NAME.yaml.")]
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            autocompletion=named_files.robots,
            help="For which robot; the first one shipped.",
        ),
    ] = None
    pipe: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            autocompletion=named_files.pipes,
            help="Along a route of this pipe: name or file.",
        ),
    ] = None
    route: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            autocompletion=candidates.routes,
            help="Along this route, in place of the first.",
        ),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class NewPipeOptions:
    """Write a pipe with one bend, or a network of round pipes."""

    name: Annotated[str, typer.Argument(help="Its name; the file is NAME.yaml.")]
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            autocompletion=named_files.robots,
            help="For which robot; the first one shipped.",
        ),
    ] = None
    round: Annotated[
        bool, typer.Option("--round", help="Round pipes, with a tee and a branch.")
    ] = False
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class NewCampaignOptions:
    """Write a campaign that runs.

    A mission runs many times, with a defect and without.
    """

    name: Annotated[str, typer.Argument(help="Its name; the file is NAME.yaml.")]
    mission: Annotated[
        str,
        typer.Option(
            metavar="MISSION",
            autocompletion=named_files.missions,
            help="Which mission it runs: name or file.",
        ),
    ] = "mitre_bend"
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class NewRobotOptions:
    """Write a small robot that runs, or a copy of another one."""

    name: Annotated[str, typer.Argument(help="Its name; the folder is NAME.")]
    like: Annotated[
        str | None,
        typer.Option(
            metavar="ROBOT",
            autocompletion=named_files.robots,
            help="A copy of this robot, to be changed.",
        ),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class NewCameraOptions:
    """Write a copy of a camera's file, to be changed."""

    name: Annotated[str, typer.Argument(help="Its name; the file is NAME.yaml.")]
    like: Annotated[
        str,
        typer.Option(
            metavar="CAMERA",
            autocompletion=named_files.cameras,
            help="Of which camera: name or file.",
        ),
    ] = "setup_3"
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class NewPanelOptions:
    """Write a copy of a control panel's file, to be changed."""

    name: Annotated[str, typer.Argument(help="Its name; the file is NAME.yaml.")]
    like: Annotated[
        str,
        typer.Option(
            metavar="PANEL", autocompletion=named_files.panels, help="Of which panel: name or file."
        ),
    ] = "nanokontrol2"
    debug: common.Debug = False
