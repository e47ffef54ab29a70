"""Options of `pirate check`, `pirate explain` and `pirate diff`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import typer

from pirate_sm.cli.completion import candidates, named_files
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import argument, flag, option


@dataclass(frozen=True, kw_only=True)
class CheckOptions:
    """Find faults in robots, missions, pipes before anything moves.

    `pirate explain CODE` explains a finding. A comment with a reason on its line allows it:
    `# pirate: allow CODE: reason`.

    Exit codes: 0 clean, 1 findings of the severity of --fail-on or worse, 2 usage, or there was
    nothing to check.
    """

    paths: Annotated[
        list[str] | None,
        argument(
            "[PATH]...",
            named_files.checkable,
            "Files and folders; robots, missions, pipes and panels are known by their "
            "content. Without any: the folders sequences, hardware_profiles and panels and the "
            "files beside them; where there is no folder sequences, all that the working "
            "directory holds.",
        ),
    ] = None
    format: Annotated[
        Literal["text", "json", "sarif", "junit", "github"],
        typer.Option("--format", help="What is written to standard output."),
    ] = "text"
    fail_on: Annotated[
        Literal["error", "warning"],
        typer.Option("--fail-on", help="Exit with 1 from this severity on."),
    ] = "error"
    robot: common.RobotOfMissions = None
    pipe: common.PipeOfMissions = None
    settings: Annotated[
        list[str] | None,
        option(
            "NAME=VALUE",
            candidates.parameters,
            "A parameter's value, where there is one of it.",
            "--set",
        ),
    ] = None
    counterexamples: Annotated[
        str | None,
        option("DIR", named_files.folders, "Write how a finding comes about, as files to run."),
    ] = None
    rehearse: Annotated[bool, flag("Run each mission in the simulator.", "--rehearse")] = False
    seeds: Annotated[int, typer.Option(min=1, help="How often each is rehearsed.")] = 1
    outside: Annotated[bool, flag("Follow `call` and `pipe` out of the project.", "--outside")] = (
        False
    )
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class ExplainOptions:
    """Explain a finding's code, or a robot's control."""

    code: Annotated[
        str | None,
        argument(
            "[CODE]", candidates.codes, "A code, or the name of a control; without one all codes."
        ),
    ] = None
    robot: Annotated[
        str | None,
        option(
            "NAME", named_files.robots, "Whose control; by default any shipped one's.", "--robot"
        ),
    ] = None
    debug: common.Debug = False


@dataclass(frozen=True, kw_only=True)
class DiffOptions:
    """Compare what two versions of a mission can do, not their text.

    Exit codes: 0 both can do the same, 1 they differ, 2 one of them cannot be used.
    """

    old: Annotated[str, argument("OLD", named_files.missions, "A mission: its name or its file.")]
    new: Annotated[str, argument("NEW", named_files.missions, "The mission to hold against it.")]
    format: Annotated[
        Literal["text", "json"],
        typer.Option("--format", help="What is written to standard output."),
    ] = "text"
    robot: common.RobotOfMissions = None
    settings: Annotated[
        list[str] | None,
        option("NAME=VALUE", candidates.parameters, "A parameter's value, for both.", "--set"),
    ] = None
    debug: common.Debug = False
