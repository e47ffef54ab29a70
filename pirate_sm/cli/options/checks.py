"""Options of `pirate check`, `pirate lsp`, `pirate explain` and `pirate diff`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options import common
from pirate_sm.cli.options.declaring import CommandOptions, argument, flag, option, typed


@dataclass(frozen=True, kw_only=True)
class CheckOptions(CommandOptions):
    """Find faults in robots, missions, pipes before anything moves.

    `pirate explain CODE` explains a finding. A comment with a reason on its line allows it:
    `# pirate: allow CODE: reason`.

    Exit codes: 0 clean, 1 findings of the severity of --fail-on or worse, 2 usage, or there was
    nothing to check. With --fix they are about what is left; with --diff 1 means that there is
    something to change.
    """

    paths: list[str] | None = argument(
        "[PATH]...",
        candidates.checkable,
        "Files and folders; robots, missions, pipes and panels are known by their "
        "content. Without any: the folders sequences, hardware_profiles and panels and the "
        "files next to them; if there is no folder sequences, all that the working "
        "directory holds.",
        default=None,
    )
    format: Literal["text", "json", "sarif", "junit", "github"] = typed(
        "What is written to standard output.", "--format", default="text"
    )
    fail_on: Literal["error", "warning"] = typed(
        "Exit with 1 from this severity on.", "--fail-on", default="error"
    )
    robot: str | None = common.robot_of_missions()
    pipe: str | None = common.pipe_of_missions()
    settings: list[str] | None = option(
        "NAME=VALUE",
        candidates.parameters,
        "A parameter's value, where there is one of it.",
        "--set",
    )
    counterexamples: str | None = option(
        "DIR", candidates.folders, "Write how a finding comes about, as files to run."
    )
    fix: bool = flag(
        "Change the checked files where only one thing can have been meant, and check again.",
        "--fix",
    )
    unsafe_fixes: bool = flag(
        "With --fix and --diff: also change what was probably meant, such as misspelt names.",
        "--unsafe-fixes",
    )
    diff: bool = flag("Show what --fix would change, and change nothing.", "--diff")
    rehearse: bool = flag("Run each mission in the simulator.", "--rehearse")
    seeds: int = typed("How often each is rehearsed.", min=1, default=1)
    outside: bool = flag("Follow `call` and `pipe` out of the project.", "--outside")
    no_cache: bool = flag("Check all files again, and keep no results.", "--no-cache")


@dataclass(frozen=True, kw_only=True)
class CoverageOptions(CommandOptions):
    """Show which branches of missions runs have taken.

    Branches are triggers, time limits, conditions, answers, failures, retries, handlers of faults
    and phases in which a run is resumed. The check's exploration says which are possible.

    Exit codes: 0 enough were taken, 1 fewer than --at-least, 2 usage, or there is nothing to read.
    """

    paths: list[str] | None = argument(
        "[PATH]...",
        candidates.coverable,
        "Missions, campaigns, recordings, and folders of them. Without a mission the recordings' "
        "own; without any path the project's missions and the folder of recordings.",
        default=None,
    )
    rehearse: int = typed(
        "Run missions and cells of campaigns in the simulator with so many seeds.",
        "--rehearse",
        min=0,
        default=0,
    )
    evidence: Literal["model", "trace", "simulated", "robot"] = typed(
        "The weakest evidence by which a branch counts as taken.", "--evidence", default="simulated"
    )
    at_least: float = typed(
        "Exit with 1 if fewer branches were taken, in percent.", "--at-least",
        min=0, max=100, default=0.0,
    )  # fmt: skip
    lines: bool = flag("Show the lines of the files, as for one mission.", "--lines")
    format: Literal["text", "json"] = typed(
        "What is written to standard output.", "--format", default="text"
    )
    html: Path | None = option("FILE", candidates.files, "Write a page with the lines.")
    lcov: Path | None = option("FILE", candidates.files, "Write a file for editors and CI.")
    write_missing: Path | None = option(
        "FOLDER",
        candidates.folders,
        "Look for runs that take the other branches, and write them as scenes.",
    )
    tries: int = typed(
        "How many runs of a mission are tried in the simulator for that.", min=0, default=60
    )
    robot: str | None = common.robot_of_missions()
    pipe: str | None = common.pipe_of_missions()
    settings: list[str] | None = option(
        "NAME=VALUE", candidates.parameters, "A parameter's value, for all missions.", "--set"
    )
    overwrite: bool = common.overwrite()


@dataclass(frozen=True, kw_only=True)
class LspOptions(CommandOptions):
    """Show an editor what is wrong with its files while you type.

    The editor starts it and talks with it by the Language Server Protocol, over standard input
    and output. It needs the extra lsp.
    """

    stdio: bool = flag("What some editors ask for; nothing else is possible.", "--stdio")
    outside: bool = flag("Follow `call` and `pipe` out of the project.", "--outside")


@dataclass(frozen=True, kw_only=True)
class ExplainOptions(CommandOptions):
    """Explain a finding's code, or a robot's control."""

    code: str | None = argument(
        "[CODE]",
        candidates.codes,
        "A code, or the name of a control; without one all codes.",
        default=None,
    )
    robot: str | None = common.a_robot("Whose control; by default any shipped one's.", "--robot")


@dataclass(frozen=True, kw_only=True)
class DiffOptions(CommandOptions):
    """Compare what two versions of a mission can do, not their text.

    Exit codes: 0 both can do the same, 1 they differ, 2 one of them cannot be used.
    """

    old: str = argument("OLD", candidates.missions, "A mission: its name or its file.")
    new: str = argument("NEW", candidates.missions, "The mission to hold against it.")
    format: Literal["text", "json"] = typed(
        "What is written to standard output.", "--format", default="text"
    )
    robot: str | None = common.robot_of_missions()
    settings: list[str] | None = option(
        "NAME=VALUE", candidates.parameters, "A parameter's value, for both.", "--set"
    )
