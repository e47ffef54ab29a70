"""The commands `pirate check` and `pirate explain` and their options."""

from __future__ import annotations

from enum import Enum
from typing import Annotated

import typer


class Formats(str, Enum):  # noqa: UP042 - a StrEnum would show its members in capitals
    """How findings are written."""

    TEXT = "text"
    JSON = "json"
    SARIF = "sarif"
    JUNIT = "junit"
    GITHUB = "github"


class Limits(str, Enum):  # noqa: UP042
    """From which severity on a check fails."""

    ERROR = "error"
    WARNING = "warning"


_DEBUG = typer.Option("--debug", help="Show tracebacks.")


def check(
    paths: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[PATH]...",
            help="Files and folders; robots, missions and pipes are known by their content. "
            "Without any: the folders sequences and hardware_profiles and the files beside them; "
            "where there is no folder sequences, all that the working directory holds.",
        ),
    ] = None,
    format_: Annotated[
        Formats, typer.Option("--format", help="What is written to standard output.")
    ] = Formats.TEXT,
    fail_on: Annotated[
        Limits, typer.Option("--fail-on", help="Exit with 1 from this severity on.")
    ] = Limits.ERROR,
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="In place of the missions' own.")
    ] = None,
    pipe: Annotated[
        str | None, typer.Option(metavar="NAME", help="In place of the missions' own.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="NAME=VALUE", help="A parameter's value, where there is one of it."
        ),
    ] = None,
    counterexamples: Annotated[
        str | None,
        typer.Option(metavar="DIR", help="Write how a finding comes about, as files to run."),
    ] = None,
    rehearse: Annotated[
        bool, typer.Option("--rehearse", help="Run each mission in the simulator.")
    ] = False,
    seeds: Annotated[int, typer.Option(min=1, help="How often each is rehearsed.")] = 1,
    outside: Annotated[
        bool, typer.Option("--outside", help="Follow `call` and `pipe` out of the project.")
    ] = False,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Find what is wrong with robots, missions and pipes before anything moves.

    `pirate explain CODE` tells more about a finding. On its line a finding is allowed by a
    comment with a reason: `# pirate: allow CODE: reason`.

    Exit codes: 0 clean, 1 findings of the severity of --fail-on or worse, 2 usage, or there was
    nothing to check.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.check import CheckWishes, run_check

        return run_check(
            CheckWishes(
                paths=paths or [],
                format=format_.value,
                fail_on=fail_on.value,
                robot=robot,
                pipe=pipe,
                settings=settings or [],
                counterexamples=counterexamples,
                rehearse=rehearse,
                seeds=seeds,
                outside=outside,
                debug=debug,
            )
        )

    raise typer.Exit(guarded(work, debug))


def explain(
    code: Annotated[
        str | None, typer.Argument(metavar="[CODE]", help="All of them when none is named.")
    ] = None,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Say what the code of a finding or fault means, why it matters and how it is mended."""
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.check import run_explain

        return run_explain(code)

    raise typer.Exit(guarded(work, debug))


class Comparisons(str, Enum):  # noqa: UP042
    """How a comparison is written."""

    TEXT = "text"
    JSON = "json"


def diff(
    old: Annotated[str, typer.Argument(metavar="OLD", help="A mission: its name or its file.")],
    new: Annotated[str, typer.Argument(metavar="NEW", help="The mission to hold against it.")],
    format_: Annotated[
        Comparisons, typer.Option("--format", help="What is written to standard output.")
    ] = Comparisons.TEXT,
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="In place of the missions' own.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter's value, for both."),
    ] = None,
    debug: Annotated[bool, _DEBUG] = False,
) -> None:
    """Compare what two versions of a mission can do, not their text.

    Exit codes: 0 both can do the same, 1 they differ, 2 one of them cannot be used.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.diff import DiffWishes, run_diff

        return run_diff(DiffWishes(old, new, format_.value, robot, settings or []))

    raise typer.Exit(guarded(work, debug))
