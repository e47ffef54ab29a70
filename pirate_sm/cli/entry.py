"""The commands `pirate` and `pirate-run`: reads a command line with typer, then its work is done.

A command's options are imported when it is requested, its work when it is known to run. So help
texts and usage errors do not wait for models, numbers and compilers.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from inspect import Parameter, Signature
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from pirate_sm.cli import command_line
from pirate_sm.cli.command_line import COMMANDS, found
from pirate_sm.cli.completion import ASKING
from pirate_sm.cli.options.common import VERSION
from pirate_sm.cli.options.declaring import parameters_of, plain_refusal

_VERSION = VERSION()

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


def _single(name: str) -> typer.Typer:
    """Return an app with one command; its options are imported, its work is not."""
    options = found("options", COMMANDS[name][0])

    def command(context: typer.Context, **given: Any) -> None:
        sources = {each: str(context.get_parameter_source(each)) for each in given}
        named = [each for each, source in sources.items() if source.endswith("COMMANDLINE")]
        command_line.keep(name, given, named)
        raise typer.Exit(command_line.work(name, given, named))

    context = Parameter("context", Parameter.KEYWORD_ONLY, annotation=typer.Context)
    vars(command)["__signature__"] = Signature([context, *parameters_of(options)])
    app = _app()
    app.command(name.rsplit(maxsplit=1)[-1], cls=_Command, help=options.__doc__)(command)
    return app


def about(name: str) -> str:
    """Return the first line of the help text of a command or of a group of commands."""
    if name in GROUPS:
        return GROUPS[name]
    return str(found("options", COMMANDS[name][0]).__doc__).partition("\n")[0]


def only_run() -> typer.Typer:
    """Return the app of `pirate-run`."""
    return _single("run")


commands = _app(cls=_Group, no_args_is_help=True)
for group, text in GROUPS.items():
    commands.add_typer(_app(cls=_Group, no_args_is_help=True), name=group, help=text)


@commands.callback()
def _everything(version: Annotated[bool, _VERSION] = False) -> None:
    """Missions in YAML for in-pipe inspection robots."""


def _enter(app: typer.Typer) -> None:
    """Run the app, which ends this process."""

    def run() -> None:
        if len(sys.argv) == 1 and ASKING in os.environ:
            from pirate_sm.cli.completion.answer import answered

            sys.stdout.write(answered(typer.main.get_command(app), os.environ, about))
        else:
            app()

    command_line.enter(run)


def main() -> None:
    """Run the command line of `pirate`, and end the process."""
    _enter(commands)


def run_main() -> None:
    """Run the mission on the command line of `pirate-run`, and end the process."""
    _enter(only_run())
