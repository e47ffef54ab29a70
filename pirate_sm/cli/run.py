"""What `pirate run` does, from words on the command line to an exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from pirate_sm.cli.asking import Operator, SharedKeys, TerminalKeys, can_type
from pirate_sm.cli.encoding import shows_signs
from pirate_sm.cli.guard import say, say_bug, show_traceback, silence_stdout
from pirate_sm.cli.jsonl import JsonLines
from pirate_sm.cli.lines import Lines, SaysWhyItWaits
from pirate_sm.cli.reader import watch_pipe
from pirate_sm.cli.recording import RecordingWishes, recorded
from pirate_sm.cli.script import read_fire, read_script
from pirate_sm.cli.situation import Situation
from pirate_sm.companion import Companion
from pirate_sm.errors import UsageError
from pirate_sm.runtime.companions import FirstChoice, LoopWatch, TriggerScript
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.runtime.observing import Observer, Watcher
from pirate_sm.runtime.outcome import BUG, Result
from pirate_sm.runtime.stopping import OUTPUT_LOST, CaughtSignals, StopRequests
from pirate_sm.units import LENGTH, TIME, Dimension, QuantityError, read_quantity
from pirate_sm.visible import visible
from pirate_sm.wiring import Order, Prepared, answers, prepare

if TYPE_CHECKING:
    from pirate_sm.detectors.keys import WordKeys
    from pirate_sm.model.course import Happening

ON_A_TERMINAL = 4.0
"""Mission seconds per second where a person is thought to watch."""


class Output(Observer, Protocol):
    """One of the ways to show a run."""

    def begin(self) -> None:
        """What is about to run has been said."""
        ...


@dataclass(frozen=True)
class Wishes:
    """The command line as it was given."""

    mission: str
    backend: str
    robot: str | None
    pipe: str | None
    settings: list[str]
    start_phase: str | None
    states: list[str]
    seed: int
    speed: str | None
    defects: list[str]
    fire: list[str]
    script: str | None
    port: str | None
    baud: int | None
    guard_for: str | None
    calibration: bool
    check: bool
    detector: str | None
    start_at: str | None
    yes: bool
    plain: bool
    json: bool
    quiet: bool
    debug: bool
    recording: RecordingWishes


def run_mission(wishes: Wishes) -> int:
    """The exit code of the run that was asked for.

    Raises:
        LoadError: Everything that is wrong with the files; nothing has moved.
        UsageError: An argument does not fit; nothing has moved.
    """
    if wishes.json and wishes.quiet:
        raise UsageError("--json and --quiet exclude each other")
    on_terminal = is_terminal() and not (wishes.json or wishes.quiet)
    factor = read_speed(wishes.speed, ON_A_TERMINAL if is_terminal() else inf)
    prepared = prepare(read_order(wishes), say=say)
    if prepared.confirmation and not wishes.yes:
        _confirm(prepared.confirmation)
    requests = StopRequests()
    with CaughtSignals(requests, ends_process=True):
        return _show(prepared, wishes, factor, on_terminal, requests)


def _confirm(what: str) -> None:
    """A person has agreed.

    Raises:
        UsageError: Nobody has; nothing has moved.
    """
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise UsageError(f"{what}: agree to it with --yes")
    print(f"{what}. Is it free to? [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in {"y", "yes"}:
        raise UsageError("nothing has moved")


def _show(
    prepared: Prepared, wishes: Wishes, factor: float, on_terminal: bool, requests: StopRequests
) -> int:
    """The run has been shown in the way that was wished, and ended."""
    live = on_terminal and not wishes.plain and shows_signs(sys.stdout)
    with ExitStack() as stack:
        kept = stack.enter_context(recorded(prepared, wishes.recording, factor, quiet=wishes.quiet))
        situation = Situation(kept.prepared)
        for companion in prepared.companions:
            if isinstance(companion, AbstractContextManager):
                stack.enter_context(companion)
        operator, words = _people(prepared, wishes, on_terminal, live, stack)
        output = _output(situation, wishes, live, factor, operator, words)
        pipe = watch_pipe(sys.stdout)
        link = prepared.link
        why = SaysWhyItWaits(link, requests) if link is not None and not live else None
        companions: list[Companion] = [*prepared.companions, *kept.companions]
        if operator and answers(prepared.loaded):  # a person may decide otherwise the next time
            companions = [each for each in companions if not isinstance(each, LoopWatch)]
        if not prepared.attended:
            companions.append(operator or _nobody(wishes))
        companions += [words] if words else []
        run = MissionRun(
            prepared.engine,
            prepared.backend,
            observers=[output, *([why] if why else [])],
            watchers=[each for each in (output, pipe, why) if isinstance(each, Watcher)],
            companions=companions,
            tap=kept.tap,
            requests=requests,
            factor=factor,
        )
        situation.run = run
        kept.follow(run)
        try:
            output.begin()
        except OSError as error:
            silence_stdout()
            say(f"nothing has moved: the output cannot be written: {error.strerror}")
            return OUTPUT_LOST
        if isinstance(output, AbstractContextManager):
            stack.enter_context(output)
        result = run.execute()
    _say_unused(prepared)
    if parting := prepared.parting():
        say(parting)
    return _conclude(result, wishes)


def _say_unused(prepared: Prepared) -> None:
    """Whoever asked for a trigger that was never fired knows."""
    for companion in prepared.companions:
        if isinstance(companion, TriggerScript) and companion.unused:
            names = ", ".join(f"'{firing.trigger}'" for firing in companion.unused)
            say(f"warning: never fired, because no wait came that had it: {names}")


def _people(
    prepared: Prepared, wishes: Wishes, on_terminal: bool, live: bool, stack: ExitStack
) -> tuple[Operator | None, WordKeys | None]:
    """The person at the keyboard, where there is one who sees what is asked and what happens.

    Raises:
        UsageError: The detector shall be a person, and there is none.
    """
    shown = sys.stdout if on_terminal else sys.stderr
    present = shown is not None and shown.isatty() and can_type()
    detects = prepared.detector == "operator"
    if detects and not (present and on_terminal):
        raise UsageError("--detector operator needs a terminal: nobody could see it and type")
    if not present or prepared.attended or (wishes.yes and not detects):
        return None, None
    from pirate_sm.detectors.keys import LETTERS, WordKeys

    keys = SharedKeys(stack.enter_context(TerminalKeys()), LETTERS if detects else "")

    def show(text: str) -> None:
        if not live:
            print(visible(text), file=shown, flush=True)

    operator = None if wishes.yes else Operator(keys.answers, answers(prepared.loaded), show)
    if not detects:
        return operator, None
    valid_for_s = prepared.loaded.loaded_robot.profile.detector.valid_for
    return operator, WordKeys(keys.words, prepared.loaded.robot.detector_words, valid_for_s)


def _nobody(wishes: Wishes) -> FirstChoice:
    """What answers where no operator does, and keeps why."""
    return FirstChoice("--yes") if wishes.yes else FirstChoice("no terminal", "warning")


def _output(
    situation: Situation,
    wishes: Wishes,
    live: bool,
    factor: float,
    operator: Operator | None,
    words: WordKeys | None,
) -> Output:
    out = sys.stdout
    if wishes.json:
        out.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
        return JsonLines(out, situation)
    if live:
        from rich.console import Console

        from pirate_sm.cli.view import View

        speed = "max" if factor == inf else f"{factor:g} ×"
        if situation.prepared.backend.real_time:
            speed = "real time"
        return View(Console(file=out, highlight=False), situation, speed, operator, words)
    return Lines(out, situation, quiet=wishes.quiet)


def read_order(wishes: Wishes) -> Order:
    """The order that the command line gives.

    Raises:
        LoadError: The script cannot be used.
        UsageError: An option reads otherwise than it should.
    """
    firings = read_fire(wishes.fire)
    course: tuple[Happening, ...] = ()
    if wishes.script is not None:
        listed, course = read_script(Path(wishes.script))
        firings += listed
    return Order(
        mission=wishes.mission,
        backend=wishes.backend,
        robot=wishes.robot,
        pipe=wishes.pipe,
        settings=read_pairs("--set", wishes.settings, "NAME=VALUE"),
        start_phase=wishes.start_phase,
        states=read_pairs("--state", wishes.states, "REGION=STATE") or None,
        seed=wishes.seed,
        defects=tuple(dict.fromkeys(wishes.defects)),
        firings=tuple(firings),
        course=course,
        port=wishes.port,
        baud=wishes.baud,
        guard_for_s=read_duration("--guard-for", wishes.guard_for),
        calibration=wishes.calibration,
        check=wishes.check,
        detector=wishes.detector,
        start_at_m=read_length("--start-at", wishes.start_at),
    )


def read_pairs(option: str, texts: Iterable[str], form: str) -> dict[str, str]:
    """What a repeatable option of the form NAME=VALUE gives.

    Raises:
        UsageError: One of them has another form, or a name comes twice.
    """
    pairs: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise UsageError(f"{option} {text}: expected {form}")
        if name in pairs:
            raise UsageError(f"{option} gives '{name}' twice")
        pairs[name] = value
    return pairs


def read_length(option: str, text: str | None) -> float | None:
    """The length that an option gives, m.

    Raises:
        UsageError: It is none.
    """
    return _read(option, text, LENGTH)


def read_duration(option: str, text: str | None) -> float | None:
    """Return the duration that an option gives, s.

    Raises:
        UsageError: It gives none, or none above zero.
    """
    duration_s = _read(option, text, TIME)
    if duration_s is not None and duration_s <= 0.0:
        raise UsageError(f"{option} {text}: expected a duration above zero, such as '10 min'")
    return duration_s


def _read(option: str, text: str | None, dimension: Dimension) -> float | None:
    if text is None:
        return None
    try:
        return read_quantity(text, dimension)
    except QuantityError as error:
        raise UsageError(f"{option} {text}: {error}") from None


def read_speed(text: str | None, default: float) -> float:
    """Mission seconds per second of the wall; infinite for ``max``.

    Raises:
        UsageError: The text is none of these.
    """
    if text is None:
        return default
    named = {"max": inf, "realtime": 1.0}
    if text in named:
        return named[text]
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not (isfinite(factor) and factor > 0):
        raise UsageError(f"--speed {text}: expected max, realtime, or a factor such as 4")
    return factor


def is_terminal() -> bool:
    """Whether a person sees standard output, on something that can do more than lines."""
    return sys.stdout.isatty() and os.environ.get("TERM", "dumb") != "dumb"


def _conclude(result: Result, wishes: Wishes) -> int:
    """What the output has not said is said on standard error."""
    if result.error is not None and result.exit_code == BUG:
        say_bug(result.error, wishes.debug)
    elif result.error is not None and wishes.debug:
        show_traceback(result.error)
    elif result.exit_code == OUTPUT_LOST:
        silence_stdout()
        ended = result.ended
        if ended.outcome == "interrupted":  # its message is about the output
            say(f"{ended.message}; the mission was stopped safely")
        else:
            say(f"the output cannot be written; the mission {ended.outcome}: {ended.message}")
    return result.exit_code
