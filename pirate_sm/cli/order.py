"""Makes the order of a run from the options of `pirate run` or `pirate console`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from pirate_sm.cli.options.running import ConsoleOptions, RunOptions
from pirate_sm.cli.options.values import read_duration, read_length, read_pairs, read_settings
from pirate_sm.errors import UsageError
from pirate_sm.loading import trace_script as loading
from pirate_sm.loading.yaml.document import read_document
from pirate_sm.loading.yaml.error_wording import word
from pirate_sm.model.quantities import FROM_FILE
from pirate_sm.model.trace_script import Happening
from pirate_sm.model.variations import LineFaults, StartJitter
from pirate_sm.runtime.trigger_script import Firing
from pirate_sm.spelling import meant
from pirate_sm.wiring import Order

Choices = TypeVar("Choices", StartJitter, LineFaults)


def order_of(options: RunOptions | ConsoleOptions) -> Order:
    """Return the order in the options; without a mission its name is empty.

    Raises:
        LoadError: The script cannot be used.
        UsageError: An option does not have the right form.
    """
    order = Order(
        mission=options.mission or "",
        backend=options.backend,
        robot=options.robot,
        pipe=options.pipe,
        settings=read_settings(options.settings),
        start_phase=options.start_phase,
        states=read_pairs("--state", options.states or (), "REGION=STATE") or None,
        seed=options.seed,
        defects=tuple(dict.fromkeys(options.defects or ())),
        fidelity=options.fidelity,
        twin=options.twin,
        fitted=options.fitted,
        port=options.port,
        baud=options.baud,
        guard_for_s=read_duration("--guard-for", options.guard_for),
        calibration=options.calibration,
        also=options.also,
        ruler=options.ruler,
        check=options.check,
        detector=options.detector,
        start_at_m=read_length("--start-at", options.start_at),
        view=options.view,
        panel=options.panel,
    )
    if isinstance(options, ConsoleOptions):
        return order
    firings, course = read_fire(options.fire or ()), tuple[Happening, ...]()
    if options.script is not None:
        listed, course = read_script(Path(options.script))
        firings += listed
    jitter = read_choices("--jitter", options.jitter, StartJitter)
    return replace(
        order,
        firings=tuple(firings),
        course=course,
        start_jitter_m=jitter.start,
        friction_jitter=jitter.friction,
        diameter_jitter_m=jitter.diameter,
        line=read_choices("--line", options.line, LineFaults) if options.line else None,
    )


def read_choices(option: str, texts: Iterable[str] | None, model: type[Choices]) -> Choices:
    """Return the values of a repeatable option NAME=VALUE, read as a file's.

    Raises:
        UsageError: A text has another form, a name is unknown, or a value does not fit.
    """
    pairs = read_pairs(option, texts or (), "NAME=VALUE")
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
    said = word(error, None)
    if said.suggestion:
        return f"{said.message}; did you mean '{said.suggestion}'?"
    return f"{said.message}; expected {said.expected}" if said.expected else said.message


def read_fire(texts: Iterable[str]) -> list[Firing]:
    """Return the firings in ``--fire TRIGGER[=SECONDS]``.

    Raises:
        UsageError: A text has another form.
    """
    firings = []
    for text in texts:
        trigger, given, after = text.partition("=")
        firings.append(Firing(trigger, _seconds(after, text) if given else None))
    return firings


def _seconds(text: str, whole: str) -> float:
    try:
        after_s = float(text.strip().removesuffix("s"))
    except ValueError:
        after_s = -1.0
    if not (isfinite(after_s) and after_s >= 0):
        raise UsageError(f"--fire {whole}: expected TRIGGER or TRIGGER=SECONDS, such as past=2.5")
    return after_s


def read_script(path: Path) -> tuple[list[Firing], tuple[Happening, ...]]:
    """Return the firings in a file, or its whole event sequence.

    Raises:
        LoadError: The file has errors; it lists all of them.
    """
    script = loading.read_script(read_document(path))
    return [Firing(each.trigger, each.after, each.phase) for each in script.entries], script.course
