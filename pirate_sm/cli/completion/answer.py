"""Answers a shell with what fits at the end of a command line.

The scripts next to this module (``pirate completion``) call the program without arguments and with
the line in the environment, so that nothing can be mistaken for a request to run something. Each
line of the answer is a value, for zsh and fish with a tab and a line about it; bash gets what it is
to insert. No shell evaluates any of it, since values and descriptions come from files of others.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from typing import Any

import typer
from typer.core import TyperArgument, TyperGroup, TyperOption

from pirate_sm.cli.completion import ASKING
from pirate_sm.cli.completion.candidates import OPEN, Candidate
from pirate_sm.core.visible import visible

LINE = "PIRATE_SM_LINE"
"""The line up to the cursor, as it is typed."""

BREAKS = "PIRATE_SM_BREAKS"
"""The characters at which bash begins another word."""

_CURSOR = "\0"
_INSERTED = re.compile(r"[^\w@%+=:,./~-]")
_QUOTED = re.compile(r"[\w@%+=:,./~ -]*")


def answered(command: Any, environment: Mapping[str, str], about: Callable[[str], str]) -> str:
    """Return the answer to a shell; empty if nothing fits or something cannot be read.

    Args:
        command: The program.
        environment: What the shell asks, see above.
        about: Returns a line about the command or group of commands with a name.
    """
    quoted, words = _words(environment.get(LINE, ""))
    typed = words.pop() if words else ""
    with open(os.devnull, "w") as nothing, redirect_stdout(nothing), redirect_stderr(nothing):  # noqa: PTH123
        try:
            found = [
                each for each in offered(command, words[1:], typed, about) if each[0].isprintable()
            ]
        except Exception:  # a shell has no use for a message in the middle of a line
            return ""
    if environment[ASKING] != "bash":
        return "".join(f"{value}\t{visible(line)}\n" for value, line in found)
    cut = max(typed.rfind(each) + 1 for each in f" {environment.get(BREAKS, '')}" if each in " =:")
    values = (value[cut:] for value, _ in found)
    return "".join(f"{each}\n" for each in _for_bash(values, quoted=quoted))


def offered(
    command: Any, words: Sequence[str], typed: str, about: Callable[[str], str]
) -> Iterator[Candidate]:
    """Yield what fits after the words of a command line.

    Args:
        command: The program.
        words: Those before the cursor.
        typed: The beginning of the word at the cursor.
        about: See `answered`.
    """
    given = list(words)
    name = ""
    while isinstance(command, TyperGroup):
        chosen = next((each for each in given if not each.startswith("-")), None)
        if chosen is None:
            yield from _commands(command, name, typed, about)
            return
        given = given[given.index(chosen) + 1 :]
        name = f"{name} {chosen}".strip()
        command = command.get_command(typer.Context(command), chosen)
    if command is not None:
        yield from _values(command, given, typed)


def _commands(
    group: TyperGroup, name: str, typed: str, about: Callable[[str], str]
) -> Iterator[Candidate]:
    context = typer.Context(group)
    for each in group.list_commands(context):
        if each.startswith(typed):
            yield each, about(f"{name} {each}".strip())
    yield from _options(context, typed)


def _values(command: Any, words: Sequence[str], typed: str) -> Iterator[Candidate]:
    """Yield what fits after the words of a command without commands of its own."""
    given, before = list(words), ""
    taking = {
        name: each
        for each in command.params
        if isinstance(each, TyperOption) and not each.is_flag
        for name in each.opts
    }
    wanted = None
    if "--" not in given:
        if given and given[-1] in taking:
            wanted = taking[given.pop()]
        elif typed.startswith("-"):
            name, sign, rest = typed.partition("=")
            if not sign:
                yield from _options(_parsed(command, given), typed)
                return
            wanted, before, typed = taking[name], f"{name}=", rest
    context = _parsed(command, given)
    if wanted is None:
        wanted = next((each for each in command.params if _is_open(context, each)), None)
    if wanted is not None:
        for value, about in _fitting(context, wanted, typed):
            yield f"{before}{value}", about


def _parsed(command: Any, words: Sequence[str]) -> typer.Context:
    """Return the options and arguments in the words, as texts; nothing is called or converted."""
    context = typer.Context(command, resilient_parsing=True)
    given, _, _ = command.make_parser(context).parse_args(args=list(words))
    context.params = {name: value for name, value in given.items() if value is not None}
    return context


def _is_open(context: typer.Context, parameter: Any) -> bool:
    """Return whether an argument takes a further value."""
    is_given = isinstance(context.params.get(parameter.name), str)
    return isinstance(parameter, TyperArgument) and (parameter.nargs == -1 or not is_given)


def _fitting(context: typer.Context, parameter: Any, typed: str) -> Iterator[Candidate]:
    """Yield the values of an option or argument; none twice, of a repeatable one none again."""
    given = context.params.get(parameter.name)
    seen = set(given) if isinstance(given, list | tuple) else set()
    seen |= {f"{each.partition('=')[0]}=" for each in seen if "=" in each}
    for each in parameter.shell_complete(context, typed):
        if each.value not in seen:
            seen.add(each.value)
            yield each.value, each.help or ""


def _options(context: typer.Context, typed: str) -> Iterator[Candidate]:
    """Yield the options that begin so, without those that cannot be given again."""
    for each in context.command.get_params(context) if typed.startswith("-") else ():
        if isinstance(each, TyperOption) and (each.multiple or each.name not in context.params):
            for name in (*each.opts, *each.secondary_opts):
                if name.startswith(typed):
                    yield name, each.help or ""


def _words(line: str) -> tuple[bool, list[str]]:
    """Return whether a quote is open at the end of a line, and its words up to there."""
    found = shlex.shlex(f"{line}{_CURSOR}", posix=True)
    found.whitespace_split = True
    found.commenters = ""
    words: list[str] = []
    is_open = False
    try:
        words += found
    except ValueError:
        is_open = True
        words.append(found.token)
    return is_open, [each.replace(_CURSOR, "") for each in words]


def _for_bash(values: Iterator[str], *, quoted: bool) -> Iterator[str]:
    """Yield what bash inserts as it is: with backslashes, and a space after what is complete."""
    for value in values:
        if quoted:
            if _QUOTED.fullmatch(value):
                yield value
        else:
            yield _INSERTED.sub(r"\\\g<0>", value) + ("" if value.endswith(OPEN) else " ")
