"""Options that several commands share, each written once, and those that runs have too.

Each is called for a field: ``port: str | None = common.port()``. Options of runs are as
:mod:`pirate_sm.core.options` declares them. What people write for them is read here, and nowhere
else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import field
from functools import partial
from inspect import Parameter
from math import isfinite
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pirate_sm import __version__
from pirate_sm.cli.completion import candidates
from pirate_sm.cli.options.declaring import (
    argument,
    declared,
    flag,
    option,
    placed,
    read_duration,
    read_length,
    read_pairs,
    shape,
)
from pirate_sm.core.errors import UsageError
from pirate_sm.core.options import DIFFERS, JITTER, OPTIONS, RunOption
from pirate_sm.core.spelling import meant
from pirate_sm.core.units import LENGTH

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

    from pirate_sm.core.fields import Frozen
    from pirate_sm.running.runtime.scripted_events import Firing

    Choices = TypeVar("Choices", bound=Frozen)


# --- shared options -----------------------------------------------------------------------------


def _print_version(wanted: bool) -> None:
    if wanted:
        from typing import get_args

        import typer

        from pirate_sm.cli.output.event_lines import FORMAT as LINES
        from pirate_sm.core.events import ALPHABET_VERSION
        from pirate_sm.core.fields import Format
        from pirate_sm.running.recording.format.header import FORMAT as RECORDING

        (number,) = get_args(get_args(Format)[0])
        others = f"JSON {LINES}, recordings {RECORDING}, events {ALPHABET_VERSION}"
        typer.echo(f"pirate-sm {__version__}")
        typer.echo(f"formats: files {number}, {others}")
        raise typer.Exit


VERSION = shape(
    "Option",
    "--version",
    callback=_print_version,
    is_eager=True,
    help="Print the versions of program and formats.",
)

a_robot = partial(option, "NAME", candidates.robots)
a_pipe = partial(option, "NAME", candidates.pipes)
robot_of_missions = partial(a_robot, "Robot to use instead of the missions'.", "--robot")
pipe_of_missions = partial(a_pipe, "Pipe to use instead of the missions'.", "--pipe")
one_robot = partial(a_robot, "Robot (default: the first bundled one).", "--robot")
a_speed = partial(option, "max|realtime|FACTOR", candidates.words("max", "realtime"))
at = partial(option, "PHASE", candidates.phases, "With --resume: continue with this phase.", "--at")
port = partial(option, "PORT", candidates.ports, "/dev/ttyACM0, or a pyserial URL.")

recording = partial(argument, "RUN.mcap", candidates.recordings, "A recording.")
output = partial(option, "OUT", candidates.files, "Write to this file.", "--output", "-o")
overwrite = partial(flag, "Replace files that this program did not write.", "--overwrite")


# --- options of runs ----------------------------------------------------------------------------


_PLACES = {each.word: place for place, each in enumerate(OPTIONS.values())}


def of_run(name: str) -> Any:
    """Return an option that runs have too, as they declare it."""
    return declared(_declaration(OPTIONS[name]), OPTIONS[name].on_command_line)


def of_all_runs(*, jitter: bool) -> Any:
    """Return a field with the options of runs as they are written, with or without --jitter."""

    def several() -> list[tuple[float, Parameter]]:
        found = [_parameter(each) for each in OPTIONS.values() if not each.key]
        return [*found, (_PLACES["jitter"], _jitter())] if jitter else found

    return field(default_factory=dict, metadata={"several": several})


def ahead_of(word: str, option: Any) -> Any:
    """Return an option that help texts show ahead of this one of runs."""
    return placed(option, _PLACES[word] - 0.5)


def _parameter(option: RunOption) -> tuple[float, Parameter]:
    """Return the parameter for an option, with its place."""
    kind = option.type if option.unit is None else str | None
    return _PLACES[option.word], Parameter(
        option.name,
        Parameter.KEYWORD_ONLY,
        annotation=Annotated[list[str] | None if option.many else kind, _declaration(option)()],
        default=option.on_command_line,
    )


def _jitter() -> Parameter:
    examples = ", ".join(f"{each.key}={each.form}" for each in JITTER)
    own = shape(
        "Option",
        "--jitter",
        metavar="NAME=VALUE",
        autocompletion=candidates.words(*(f"{each.key}=" for each in JITTER)),
        help=f"{DIFFERS}: {examples}.",
    )
    kind = Annotated[list[str] | None, own()]
    return Parameter("jitter", Parameter.KEYWORD_ONLY, annotation=kind, default=None)


def _declaration(option: RunOption) -> Callable[[], Any]:
    names, offered = option.flag, None
    if option.type is bool and option.on_command_line:
        names = f"{names}/{names.replace('--', '--no-', 1)}"
    if option.completes:
        offered = getattr(candidates, option.completes)
    return shape(
        "Option",
        names,
        metavar=option.form or None,
        autocompletion=offered,
        help=option.help,
        min=option.least,
    )


def values_of(written: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of options of runs that are written so; the others as commands take them.

    Raises:
        UsageError: One does not have the right form.
    """
    found = {
        name: _value(option, written.get(name, option.on_command_line))
        for name, option in OPTIONS.items()
        if not option.key
    }
    if written.get("jitter"):
        from pirate_sm.lab.campaign.campaign_model import StartJitter

        jitter = read_choices("--jitter", written["jitter"], StartJitter)
        found |= {each.name: getattr(jitter, each.key) for each in JITTER}
    return found


def _value(option: RunOption, written: Any) -> Any:
    if option.many is Mapping:
        return read_pairs(option.flag, written or (), option.form) or option.default
    if option.many:
        return tuple(dict.fromkeys(written or ()))
    if option.unit is not None:
        read = read_length if option.unit == LENGTH else read_duration
        return read(option.flag, written)
    return written


def read_choices(option: str, texts: Iterable[str], model: type[Choices]) -> Choices:
    """Return the values of a repeatable option NAME=VALUE, read as a file's.

    Raises:
        UsageError: A text has another form, a name is unknown, or a value does not fit.
    """
    from pydantic import ValidationError

    from pirate_sm.core.fields import FROM_FILE

    pairs = read_pairs(option, texts, "NAME=VALUE")
    try:
        return model.model_validate(pairs, context=dict(FROM_FILE))
    except ValidationError as error:
        wrong = []
        for each in error.errors():
            name = str(each["loc"][0]) if each["loc"] else ""
            if each["type"] == "extra_forbidden":
                wrong.append(f"{option} {name}: {meant(name, sorted(model.model_fields))}")
            else:
                wrong.append(f"{option} {name}={pairs.get(name)}: {_refusal(each)}")
        raise UsageError("\n".join(wrong)) from None


def _refusal(error: ErrorDetails) -> str:
    from pirate_sm.core.loading import word

    said = word(error, None)
    if said.suggestion:
        return f"{said.message}; did you mean '{said.suggestion}'?"
    return f"{said.message}; expected {said.expected}" if said.expected else said.message


def read_fire(texts: Iterable[str]) -> Iterator[Firing]:
    """Yield the firings in ``--fire TRIGGER[=SECONDS]``.

    Raises:
        UsageError: A text has another form.
    """
    from pirate_sm.running.runtime.scripted_events import Firing

    for text in texts:
        trigger, given, after = text.partition("=")
        yield Firing(trigger, _seconds(after, text) if given else None)


def _seconds(text: str, whole: str) -> float:
    try:
        after_s = float(text.strip().removesuffix("s"))
    except ValueError:
        after_s = -1.0
    if not (isfinite(after_s) and after_s >= 0):
        raise UsageError(f"--fire {whole}: expected TRIGGER or TRIGGER=SECONDS, such as past=2.5")
    return after_s
