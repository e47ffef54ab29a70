"""The command that draws, and its options."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer


class Formats(str, Enum):  # noqa: UP042 - a StrEnum would show its members in capitals
    """What a drawing can be written as."""

    MERMAID = "mermaid"
    DOT = "dot"
    SVG = "svg"


def graph(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A mission, a robot or a chart: name or path.")
    ],
    format_: Annotated[
        Formats | None,
        typer.Option("--format", help="As the name of the output ends, else mermaid."),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="OUT", help="Write to this file.")
    ] = None,
    path: Annotated[
        str | None,
        typer.Option("--highlight", metavar="A,B,C", help="Phases or states to mark, in order."),
    ] = None,
    counterexample: Annotated[
        Path | None,
        typer.Option(metavar="SCRIPT", help="Mark the way that this course of events takes."),
    ] = None,
    calls: Annotated[
        bool, typer.Option("--calls", help="Draw the missions that it calls, too.")
    ] = False,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter's value. Repeatable."),
    ] = None,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Draw a mission or a robot's chart.

    Exit codes: 0 drawn, 2 invalid files or arguments.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.graph import GraphWishes, run_graph

        return run_graph(
            GraphWishes(
                what=file,
                format=format_.value if format_ else None,
                output=output,
                path=path,
                calls=calls,
                settings=settings or [],
                counterexample=counterexample,
            )
        )

    raise typer.Exit(guarded(work, debug))
