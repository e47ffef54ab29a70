"""Does the work of a command line once its options are read, and keeps what they are.

Reading a line takes typer, which is a tenth of the time of a short mission. So the values that a
line gives are kept as results of checks are: they depend on nothing but the line and the program.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from pirate_sm.checking.kept_results import again, kept, kept_results
from pirate_sm.checking.permissions import SIMULATED
from pirate_sm.cli import ctrl_c
from pirate_sm.cli.output.terminal import degrade

COMMANDS = {
    "run": ("running:RunOptions", "run:run_mission"),
    "demo": ("running:DemoOptions", "demo:play_demo"),
    "list": ("files:ListOptions", "list:list_things"),
    "schema": ("files:SchemaOptions", "schema:print_schema"),
    "check": ("checks:CheckOptions", "check:run_check"),
    "lsp": ("checks:LspOptions", "lsp:serve_editor"),
    "explain": ("checks:ExplainOptions", "explain:explain_code"),
    "diff": ("checks:DiffOptions", "diff:run_diff"),
    "coverage": ("checks:CoverageOptions", "coverage:measure_coverage"),
    "graph": ("files:GraphOptions", "graph:draw_graph"),
    "import": ("files:ImportOptions", "import_chart:import_chart"),
    "plan": ("files:PlanOptions", "plan:print_plan"),
    "robot": ("files:RobotOptions", "robot_page:write_page"),
    "campaign": ("estimates:CampaignOptions", "campaign:run_campaign"),
    "margins": ("estimates:MarginsOptions", "margins:find_margins"),
    "console": ("running:ConsoleOptions", "console:open_console"),
    "panel": ("devices:PanelOptions", "panel:show_panel"),
    "doctor": ("devices:DoctorOptions", "doctor:run_doctor"),
    "calibrate": ("devices:CalibrateOptions", "calibrate:run_calibrate"),
    "bay": ("devices:BayOptions", "bay:run_bay"),
    "firmware": ("files:FirmwareOptions", "firmware:write_tables"),
    "replay": ("recordings:ReplayOptions", "replay:run_replay"),
    "compare": ("recordings:CompareOptions", "compare:run_compare"),
    "forecast": ("recordings:ForecastOptions", "forecast:make_forecast"),
    "export": ("recordings:ExportOptions", "export:run_export"),
    "map": ("recordings:MapOptions", "map:write_map"),
    "fit": ("estimates:FitOptions", "fit:run_fit"),
    "experiment": ("estimates:ExperimentOptions", "experiment:run_experiment"),
    "report": ("recordings:ReportOptions", "report:write_reports"),
    "page": ("recordings:PageOptions", "page:serve_page"),
    "repair": ("recordings:RepairOptions", "repair:run_repair"),
    "camera print": ("devices:PrintOptions", "camera:print_sheets"),
    "camera calibrate": ("devices:CalibrateCameraOptions", "camera:calibrate_camera"),
    "camera survey": ("devices:SurveyOptions", "camera:survey_camera"),
    "camera look": ("devices:LookOptions", "camera:look"),
    "config": ("files:ConfigOptions", "config:show_settings"),
    "cache": ("files:CacheOptions", "cache:show_cache"),
    "completion": ("files:CompletionOptions", "completion:print_script"),
    "new mission": ("files:NewMissionOptions", "new:write_mission"),
    "new pipe": ("files:NewPipeOptions", "new:write_pipe"),
    "new campaign": ("files:NewCampaignOptions", "new:write_campaign"),
    "new robot": ("files:NewRobotOptions", "new:write_robot"),
    "new camera": ("files:NewCameraOptions", "new:write_camera"),
    "new panel": ("files:NewPanelOptions", "new:write_panel"),
}
"""Each command with its options in ``cli/options`` and its work in ``cli/commands``.

The options are a dataclass: its fields are the arguments and options in the order of the help text,
its docstring is the help text. The work takes them and returns the exit code.
"""


_MOVE = ("run", "console", "doctor", "calibrate")
"""The commands that are connected to a robot; while they are, they catch signals themselves."""

_CHECK = ("check", "run", "demo", "campaign", "margins", "console")
"""The commands that check files, and use kept results again."""

words: tuple[str, ...] = ()
"""The command line of this process, from which all its options follow; empty if it has none."""


@contextmanager
def begun(given: Sequence[str]) -> Iterator[None]:
    """Return a context for the work of this process's command line, a command and what follows.

    It ends the process if the work can be done, or the report printed, without reading the line.
    """
    global words  # noqa: PLW0603 - a process has one
    words = tuple(given)
    if len(sys.argv) < 2 or words[0] not in _CHECK or "--no-cache" in words or sys.stdout is None:
        yield
        return
    with kept_results():
        if words[0] == "check":
            from pirate_sm.cli.commands.check import print_again

            print_again()
        known = again("line", words, _read)
        if known is not None:
            enter(lambda: sys.exit(work(words[0], *known)))
        yield


def _read(known: Any) -> tuple[dict[str, Any], list[str]]:
    """Return the values of a line, and which it gives, from JSON.

    Raises:
        ValueError: It holds something else, or what is not kept.
    """
    given, named = known
    if given.get("backend", "sim") not in SIMULATED:
        raise ValueError
    return given, named


def keep(name: str, given: Mapping[str, Any], named: Collection[str]) -> None:
    """Keep the values of this process's command line, and which of them it gives.

    A line that names a backend which may reach a robot is always read, and one with a value that
    JSON does not give back, such as a path.
    """
    plain = all(isinstance(each, str | int | float | list | None) for each in given.values())
    if plain and words[:1] == (name,) and given.get("backend", "sim") in SIMULATED:
        kept("line", words, lambda: [given, named], _read)


def work(name: str, given: Mapping[str, Any], named: Collection[str]) -> int:
    """Do the work of a command and return its exit code.

    Args:
        name: The command.
        given: The values of all its options.
        named: Which of them are on the command line.
    """
    from pirate_sm.cli.errors import guarded
    from pirate_sm.cli.options.declaring import made
    from pirate_sm.cli.settings import with_settings

    options_at, work_at = COMMANDS[name]

    def worked() -> int:
        chosen = made(found("options", options_at), with_settings(name, given, named.__contains__))
        ctrl_c.answer(moves=name in _MOVE)
        if name not in _CHECK or given.get("no_cache"):
            return int(_work(work_at)(chosen))
        with kept_results():
            return int(_work(work_at)(chosen))

    return guarded(worked, given["debug"])


def _work(at: str) -> Any:
    """Return the function that does the work of a command, and collect garbage from then on."""
    work = found("commands", at)
    if not gc.isenabled():  # `start.py` has seen to that
        gc.freeze()
        gc.enable()
    return work


def found(package: str, at: str) -> Any:
    """Return the object at ``module:name`` in a package of the command line."""
    module, _, name = at.partition(":")
    return getattr(import_module(f"pirate_sm.cli.{package}.{module}"), name)


def enter(run: Callable[[], None]) -> None:
    """Run what ends this process; report in one line that output cannot be written."""
    if sys.stdout is None:
        from pirate_sm.cli.errors import say
        from pirate_sm.core.errors import ExitCode

        say("the output cannot be written: standard output is closed")
        raise SystemExit(ExitCode.OUTPUT_LOST)
    degrade(sys.stdout)
    degrade(sys.stderr)
    try:
        try:
            run()
        finally:
            sys.stdout.flush()
    except KeyboardInterrupt:  # another one, while the first was reported
        from pirate_sm.core.errors import ExitCode

        raise SystemExit(ExitCode.INTERRUPTED) from None
    except OSError as error:
        from pirate_sm.cli.errors import output_lost

        raise SystemExit(output_lost(error)) from None
