"""The commands about a robot as such, `plan` and `robot`, and their options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def plan(
    robot: Annotated[str, typer.Argument(metavar="ROBOT", help="A shipped robot, or its folder.")],
    to: Annotated[
        list[str] | None,
        typer.Option(
            "--to", metavar="REGION=STATE,…", help="Where to; regions not named do not matter."
        ),
    ] = None,
    to_phase: Annotated[
        str | None,
        typer.Option(metavar="MISSION:PHASE", help="To where a mission can begin this phase."),
    ] = None,
    from_: Annotated[
        list[str] | None,
        typer.Option(
            "--from", metavar="REGION=STATE,…", help="From where, in place of its initial states."
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="One JSON object, for programs.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Print the fewest commands that lead from one configuration of a robot to another.

    No command is proposed that lets go of a clamp while no other part holds.

    Exit codes: 0 there are commands, or none are needed, 1 there are none, 2 invalid files or
    arguments.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.plan import PlanWishes, run_plan

        return run_plan(PlanWishes(robot, from_ or [], to or [], to_phase, json))

    raise typer.Exit(guarded(work, debug))


def robot(
    name: Annotated[
        str | None,
        typer.Argument(metavar="ROBOT", help="A shipped robot, or its folder; the first shipped."),
    ] = None,
    html: Annotated[
        bool, typer.Option("--html", help="One HTML file in place of Markdown.")
    ] = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="OUT", help="Write to this file.")
    ] = None,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Write a robot's page: what each command means, what it needs, where it leads.

    Exit codes: 0 written, 2 invalid files or arguments.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.robot import write_page

        return write_page(name, output, html=html)

    raise typer.Exit(guarded(work, debug))
