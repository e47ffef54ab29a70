"""The commands `pirate` and `pirate-run`: a table of their options and their work.

A command's options are imported when it is requested, its work when it is known to run. So help
texts and usage errors do not wait for models, numbers and compilers.
"""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterable
from importlib import import_module
from inspect import Parameter, Signature
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from pirate_sm.cli import ctrl_c
from pirate_sm.cli.completion import ASKING
from pirate_sm.cli.options.common import VERSION
from pirate_sm.cli.options.declaring import made, parameters_of, plain_refusal
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
    "graph": ("files:GraphOptions", "graph:draw_graph"),
    "import": ("files:ImportOptions", "import_chart:import_chart"),
    "plan": ("files:PlanOptions", "plan:print_plan"),
    "robot": ("files:RobotOptions", "robot_page:write_page"),
    "campaign": ("estimates:CampaignOptions", "campaign:run_campaign"),
    "console": ("running:ConsoleOptions", "console:open_console"),
    "panel": ("devices:PanelOptions", "panel:show_panel"),
    "doctor": ("devices:DoctorOptions", "doctor:run_doctor"),
    "calibrate": ("devices:CalibrateOptions", "calibrate:run_calibrate"),
    "bay": ("devices:BayOptions", "bay:run_bay"),
    "firmware": ("files:FirmwareOptions", "firmware:write_tables"),
    "replay": ("recordings:ReplayOptions", "replay:run_replay"),
    "compare": ("recordings:CompareOptions", "compare:run_compare"),
    "export": ("recordings:ExportOptions", "export:run_export"),
    "map": ("recordings:MapOptions", "map:write_map"),
    "fit": ("estimates:FitOptions", "fit:run_fit"),
    "experiment": ("estimates:ExperimentOptions", "experiment:run_experiment"),
    "report": ("recordings:ReportOptions", "report:write_reports"),
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


GROUPS = {
    "new": "Start a mission, a pipe, a robot or other files that run.",
    "camera": "Print, calibrate, survey and try a camera over the setup.",
}
"""The first words of commands of two words."""


class _Group(TyperGroup):
    """A group of commands that imports a command's options when it is requested."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names of the commands of this group, in the order of the table."""
        before = f"{self.name} ".lstrip()
        inside = [each.removeprefix(before) for each in COMMANDS if each.startswith(before)]
        return list(dict.fromkeys(each.partition(" ")[0] for each in inside))

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command with this name, None if there is none."""
        whole = f"{self.name} {cmd_name}".strip()
        if whole in COMMANDS:
            return typer.main.get_command(_single(whole))
        return super().get_command(ctx, cmd_name)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the requested command; suggest a similar name for a mistyped one."""
        if self.get_command(ctx, args[0]) is None:
            self.commands = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
            if not self.name and (hint := _suggested_line(args[0], self.commands)):
                ctx.fail(f"There is no command '{args[0]}'; did you mean: {hint}?")
        return super().resolve_command(ctx, args)


def _suggested_line(word: str, known: Iterable[str]) -> str | None:
    """Return the command line that a word instead of a command is short for, None if unknown."""
    import shlex

    from pirate_sm.core import library
    from pirate_sm.core.library import PROFILE_FILE
    from pirate_sm.core.spelling import nearest

    if word.lower() in ("help", "version"):
        return " ".join(("pirate", f"--{word.lower()}"))
    if nearest(word, known):
        return None
    if "/" in word:
        command = "check" if word.endswith(f"/{PROFILE_FILE}") else "run"
        return shlex.join(("pirate", command, word)) if word.endswith(".yaml") else None
    files_of = {"pirate run": library.missions(), "pirate demo": library.scenes()}
    for command, files in files_of.items():
        if name := nearest(word, [path.stem for path in files]):
            return f"{command} {name}"
    return None


class _Command(TyperCommand):
    """A command that says in plain words which value it cannot take."""

    def make_context(self, info_name: Any, args: list[str], *given: Any, **more: Any) -> Any:
        """Return the context with the command line's values.

        Raises:
            BadParameter: A value cannot be taken.
        """
        try:
            for option, name, value in zip(args, args[1:], args[2:], strict=False):
                if option == "--set" and "=" not in name and value[:1].isdigit():
                    raise typer.BadParameter(f"did you mean: --set {name}={value}?")
            return super().make_context(info_name, args, *given, **more)
        except typer.BadParameter as error:
            error.message = plain_refusal(error.message)
            raise


def _app(**more: Any) -> typer.Typer:
    # Plain help starts in half the time of coloured help; errors are printed by this package.
    return typer.Typer(
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        add_completion=False,  # `pirate completion` has scripts that evaluate nothing from files
        context_settings={"help_option_names": ["-h", "--help"]},
        **more,
    )


_MOVE = ("run", "console", "doctor", "calibrate")
"""The commands that are connected to a robot; while they are, they catch signals themselves."""

_CHECK = ("check", "run", "demo", "campaign", "console")
"""The commands that check files, and use kept results again."""


def _single(name: str) -> typer.Typer:
    """Return an app with one command; its options are imported, its work is not."""
    options_at, work_at = COMMANDS[name]
    options = _found("options", options_at)

    def command(context: typer.Context, **given: Any) -> None:
        from pirate_sm.cli.errors import guarded
        from pirate_sm.cli.settings import with_settings

        def is_given(option: str) -> bool:
            source = context.get_parameter_source(option)
            return source is not None and source.name == "COMMANDLINE"

        def work() -> int:
            chosen = made(options, with_settings(name, given, is_given))
            ctrl_c.answer(moves=name in _MOVE)
            if name not in _CHECK or given.get("no_cache"):
                return int(_work(work_at)(chosen))
            from pirate_sm.checking.kept_results import kept_results

            with kept_results():
                return int(_work(work_at)(chosen))

        raise typer.Exit(guarded(work, given["debug"]))

    context = Parameter("context", Parameter.KEYWORD_ONLY, annotation=typer.Context)
    vars(command)["__signature__"] = Signature([context, *parameters_of(options)])
    app = _app()
    app.command(name.rsplit(maxsplit=1)[-1], cls=_Command, help=options.__doc__)(command)
    return app


def _work(at: str) -> Any:
    """Return the function that does the work of a command, and collect garbage from then on."""
    work = _found("commands", at)
    if not gc.isenabled():  # `start.py` has seen to that
        gc.freeze()
        gc.enable()
    return work


def _found(package: str, at: str) -> Any:
    """Return the object at ``module:name`` in a package of the command line."""
    module, _, name = at.partition(":")
    return getattr(import_module(f"pirate_sm.cli.{package}.{module}"), name)


def about(name: str) -> str:
    """Return the first line of the help text of a command or of a group of commands."""
    if name in GROUPS:
        return GROUPS[name]
    return str(_found("options", COMMANDS[name][0]).__doc__).partition("\n")[0]


def only_run() -> typer.Typer:
    """Return the app of `pirate-run`."""
    return _single("run")


commands = _app(cls=_Group, no_args_is_help=True)
for group, text in GROUPS.items():
    commands.add_typer(_app(cls=_Group, no_args_is_help=True), name=group, help=text)


@commands.callback()
def _everything(version: Annotated[bool, VERSION] = False) -> None:
    """Missions in YAML for in-pipe inspection robots."""


def _enter(app: typer.Typer) -> None:
    """Run the app, which ends this process; report in one line that output cannot be written."""
    if sys.stdout is None:
        from pirate_sm.cli.errors import say
        from pirate_sm.core.errors import ExitCode

        say("the output cannot be written: standard output is closed")
        raise SystemExit(ExitCode.OUTPUT_LOST)
    degrade(sys.stdout)
    degrade(sys.stderr)
    try:
        try:
            if len(sys.argv) == 1 and ASKING in os.environ:
                from pirate_sm.cli.completion.answer import answered

                sys.stdout.write(answered(typer.main.get_command(app), os.environ, about))
            else:
                app()
        finally:
            sys.stdout.flush()
    except OSError as error:
        from pirate_sm.cli.errors import output_lost

        raise SystemExit(output_lost(error)) from None


def main() -> None:
    """Run the command line of `pirate`, and end the process."""
    _enter(commands)


def run_main() -> None:
    """Run the mission on the command line of `pirate-run`, and end the process."""
    _enter(only_run())
