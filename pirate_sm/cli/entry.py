"""The commands `pirate` and `pirate-run` and their options, quick to start.

Nothing of this package but its version is imported before a command is known to run: a help text
must not wait for models, numbers and compilers.
"""

from __future__ import annotations

import sys
from enum import Enum
from typing import Annotated

import typer

from pirate_sm import __version__
from pirate_sm.cli.checking import check, diff, explain
from pirate_sm.cli.connecting import GUARD_FOR, calibrate, doctor
from pirate_sm.cli.drawing import graph
from pirate_sm.cli.emulating import bay
from pirate_sm.cli.encoding import degrade
from pirate_sm.cli.keeping import compare, export, repair, replay
from pirate_sm.cli.operating import console
from pirate_sm.cli.planning import plan, robot
from pirate_sm.cli.reporting import report


class Things(str, Enum):  # noqa: UP042 - a StrEnum would show its members in capitals
    """What can be listed."""

    ROBOTS = "robots"
    COMMANDS = "commands"
    SIGNALS = "signals"
    DEFECTS = "defects"
    MISSIONS = "missions"
    PIPES = "pipes"
    BACKENDS = "backends"
    DETECTORS = "detectors"


class Files(str, Enum):  # noqa: UP042
    """What there are JSON Schemas of."""

    MISSION = "mission"
    PIPE = "pipe"
    PROFILE = "profile"
    CHART = "chart"


def _app(*, completion: bool) -> typer.Typer:
    # Plain help starts in half the time of the coloured one; our own errors are shown by us.
    return typer.Typer(
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        add_completion=completion,
        no_args_is_help=completion,
        context_settings={"help_option_names": ["-h", "--help"]},
    )


commands = _app(completion=True)
only_run = _app(completion=False)
new = _app(completion=True)
commands.add_typer(new, name="new", help="Start a mission or a robot from a template that runs.")


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"pirate-sm {__version__}")
        raise typer.Exit


_VERSION = typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")


@commands.callback()
def _everything(version: Annotated[bool, _VERSION] = False) -> None:
    """Missions in YAML for in-pipe inspection robots."""


@commands.command("run")
@only_run.command()
def run(
    mission: Annotated[
        str, typer.Argument(metavar="MISSION", help="A shipped mission's name, or a file.")
    ],
    backend: Annotated[
        str,
        typer.Option(
            metavar="NAME",
            help="sim: the kinematic simulator; trace: nothing moves; serial: the real robot; "
            "others: pirate list backends.",
        ),
    ] = "sim",
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="In place of the mission's own.")
    ] = None,
    pipe: Annotated[
        str | None, typer.Option(metavar="NAME", help="In place of the mission's own.")
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A parameter's value. Repeatable."),
    ] = None,
    start_phase: Annotated[
        str | None, typer.Option("--from", metavar="PHASE", help="Begin with this phase.")
    ] = None,
    states: Annotated[
        list[str] | None,
        typer.Option(
            "--state",
            metavar="REGION=STATE",
            help="The robot is in this state, in place of starts_in.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of everything random.")] = 0,
    speed: Annotated[
        str | None,
        typer.Option(
            metavar="max|realtime|FACTOR",
            help="Mission time over wall time. On a terminal 4, else max.",
        ),
    ] = None,
    defects: Annotated[
        list[str] | None,
        typer.Option("--defect", metavar="NAME", help="Switch on a known defect. Repeatable."),
    ] = None,
    fire: Annotated[
        list[str] | None,
        typer.Option(
            metavar="TRIGGER[=SECONDS]",
            help="In a trace: the trigger that a wait takes. Repeatable, in order.",
        ),
    ] = None,
    script: Annotated[
        str | None,
        typer.Option(metavar="FILE", help="In a trace: a YAML list of {phase, trigger, after}."),
    ] = None,
    port: Annotated[
        str | None,
        typer.Option(metavar="PORT", help="Of the real robot: /dev/ttyACM0, or a pyserial URL."),
    ] = None,
    baud: Annotated[
        int | None, typer.Option(min=1, help="In place of the robot's own rate.")
    ] = None,
    guard_for: Annotated[
        str | None,
        typer.Option(metavar="DURATION", help=GUARD_FOR),
    ] = None,
    detector: Annotated[
        str | None,
        typer.Option(
            metavar="sim|odometry|operator|socket:ADDRESS|NAME",
            help="Who says where the robot is. For sim: sim, for serial: odometry.",
        ),
    ] = None,
    start_at: Annotated[
        str | None,
        typer.Option(metavar="LENGTH", help="Where odometry takes the first wheel to begin."),
    ] = None,
    calibration: Annotated[
        bool,
        typer.Option("--calibration/--no-calibration", help="Whether its joint zeros are used."),
    ] = True,
    check: Annotated[
        bool, typer.Option("--check/--no-check", help="Whether a faulty mission is refused.")
    ] = True,
    record: Annotated[
        str | None,
        typer.Option(metavar="FILE.mcap", help="Where the run is kept, in place of runs/."),
    ] = None,
    no_record: Annotated[bool, typer.Option("--no-record", help="Nothing is kept.")] = False,
    live: Annotated[
        bool, typer.Option("--live", help="Let Foxglove or Lichtblick look on, on this machine.")
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", "-y", help="Take the first answer to every question.")
    ] = False,
    plain: Annotated[bool, typer.Option("--plain", help="Lines instead of the live view.")] = False,
    json: Annotated[bool, typer.Option("--json", help="JSON Lines on standard output.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only how it ended.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
    version: Annotated[bool, _VERSION] = False,
) -> None:
    """Run a mission.

    Exit codes: 0 succeeded, 1 mission failed, 2 invalid files or arguments (nothing moved),
    3 backend or link fault, 4 a fault in this program, 129/130/141/143 stopped from outside; the
    robot is brought to its safe state on every way out.
    """
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.recording import RecordingWishes
        from pirate_sm.cli.run import Wishes, run_mission

        return run_mission(
            Wishes(
                mission=mission,
                backend=backend,
                robot=robot,
                pipe=pipe,
                settings=settings or [],
                start_phase=start_phase,
                states=states or [],
                seed=seed,
                speed=speed,
                defects=defects or [],
                fire=fire or [],
                script=script,
                port=port,
                baud=baud,
                guard_for=guard_for,
                calibration=calibration,
                check=check,
                detector=detector,
                start_at=start_at,
                yes=yes,
                plain=plain,
                json=json,
                quiet=quiet,
                debug=debug,
                recording=RecordingWishes(record, no_record, live),
            )
        )

    raise typer.Exit(guarded(work, debug))


@commands.command("list")
def list_(
    what: Annotated[
        Things | None, typer.Argument(help="All of them when nothing is named.")
    ] = None,
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="Whose commands, signals and defects.")
    ] = None,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Show robots, commands, signals, defects, missions, pipes, backends and detectors."""
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.listing import show

        return show(what.value if what else None, robot)

    raise typer.Exit(guarded(work, debug))


@commands.command("schema")
def schema(
    files: Annotated[Files, typer.Argument(help="Of which files.")],
    robot: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Missions for this robot: its commands, its states."),
    ] = None,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Print the JSON Schema with which an editor completes and explains files."""
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.schema import print_schema

        return print_schema(files.value, robot)

    raise typer.Exit(guarded(work, debug))


commands.command("check")(check)
commands.command("explain")(explain)
commands.command("diff")(diff)
commands.command("graph")(graph)
commands.command("plan")(plan)
commands.command("robot")(robot)
commands.command("console")(console)
commands.command("doctor")(doctor)
commands.command("calibrate")(calibrate)
commands.command("bay")(bay)
commands.command("replay")(replay)
commands.command("compare")(compare)
commands.command("export")(export)
commands.command("report")(report)
commands.command("repair")(repair)


@new.command("mission")
def new_mission(
    name: Annotated[str, typer.Argument(help="Its name; the file is NAME.yaml.")],
    robot: Annotated[
        str | None, typer.Option(metavar="NAME", help="For which robot; the first one shipped.")
    ] = None,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Write a mission that runs."""
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.new import write_mission

        return write_mission(name, robot)

    raise typer.Exit(guarded(work, debug))


@new.command("robot")
def new_robot(
    name: Annotated[str, typer.Argument(help="Its name; the folder is NAME.")],
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Write a small robot with a pipe and a mission that runs."""
    from pirate_sm.cli.guard import guarded

    def work() -> int:
        from pirate_sm.cli.new import write_robot

        return write_robot(name)

    raise typer.Exit(guarded(work, debug))


def _enter(app: typer.Typer) -> None:
    """Run the app, which ends this process; say in one line when its output cannot be written."""
    if sys.stdout is None:
        from pirate_sm.cli.guard import say
        from pirate_sm.runtime.stopping import OUTPUT_LOST

        say("the output cannot be written: standard output is closed")
        raise SystemExit(OUTPUT_LOST)
    degrade(sys.stdout)
    degrade(sys.stderr)
    try:
        try:
            app()
        finally:
            sys.stdout.flush()
    except OSError as error:
        from pirate_sm.cli.guard import output_lost

        raise SystemExit(output_lost(error)) from None


def main() -> None:
    """The process has done what the command line says and ended."""
    _enter(commands)


def run_main() -> None:
    """The process has run the mission on the command line and ended."""
    _enter(only_run)
