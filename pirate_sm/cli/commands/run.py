"""`pirate run`: prepares a mission, runs and shows it, and reports how it ended."""

from __future__ import annotations

import errno
import os
import select
import stat
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from math import inf
from typing import NamedTuple, Protocol, TextIO

from pirate_sm.cli.errors import say, say_bug, show_traceback, silence_stdout
from pirate_sm.cli.options.declaring import read_speed
from pirate_sm.cli.options.running import RunOptions
from pirate_sm.cli.output.event_lines import EventLines, JsonLines, ObservedRun, SaysWhyItWaits
from pirate_sm.cli.output.terminal import agree, is_terminal, shows_signs
from pirate_sm.cli.people import People, open_desk, people_of
from pirate_sm.cli.run_recording import RecordingOptions, check_page, recorded
from pirate_sm.core.companion import Companion, entered
from pirate_sm.core.errors import ExitCode, UsageError
from pirate_sm.core.library import shown
from pirate_sm.running.runtime.ending import CaughtSignals, Result, StopRequests
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.pump import Observer, Resuming, Watcher
from pirate_sm.running.runtime.scripted_events import Firing, FirstChoice, LoopWatch, TriggerScript
from pirate_sm.running.wiring import Prepared, answers, prepare
from pirate_sm.running.wiring.run_recorder import Kept

# --- a run that is shown ------------------------------------------------------------------------


class Output(Observer, Protocol):
    """One of the ways to show a run."""

    def begin(self) -> None:
        """Print what is about to run."""


class Manner(NamedTuple):
    """How a run is shown.

    Attributes:
        on_terminal: Whether a user reads standard output.
        live: Whether it is redrawn in place.
        factor: Mission seconds per second of the wall clock.
    """

    on_terminal: bool
    live: bool
    factor: float


def run_prepared(
    prepared: Prepared,
    options: RunOptions,
    manner: Manner,
    requests: StopRequests,
    resuming: Resuming | None = None,
) -> int:
    """Run a prepared mission, show it and report how it ended; return the exit code.

    Args:
        prepared: The run.
        options: Its options.
        manner: How it is shown; whether it is redrawn in place is decided here.
        requests: Requests to stop.
        resuming: The state from which an interrupted mission resumes.
    """
    live = manner.on_terminal and not options.plain and shows_signs(sys.stdout)
    result, kept = _shown(prepared, options, manner._replace(live=live), requests, resuming)
    if result is None:
        return ExitCode.OUTPUT_LOST
    _say_unused(prepared)
    if parting := prepared.parting():
        say(parting)
    code = _conclude(result, options)
    if code == ExitCode.SUCCEEDED and kept.lost is not None:
        say(f"the mission succeeded, but its recording {shown(kept.lost)} is incomplete")
        return ExitCode.RECORDING_LOST
    return code


def _shown(
    prepared: Prepared,
    options: RunOptions,
    manner: Manner,
    requests: StopRequests,
    resuming: Resuming | None,
) -> tuple[Result | None, Kept]:
    """Run the mission and show it.

    Returns:
        Its result, None if nothing could be written; its recording.
    """
    recording = RecordingOptions(options.record, options.no_record, options.live)
    if options.page:
        check_page(prepared, recording)
    with ExitStack() as stack:
        desk = open_desk(prepared, requests, stack, page=options.page)
        recording = replace(recording, page=desk.page)
        kept = stack.enter_context(
            recorded(prepared, recording, manner.factor, quiet=options.quiet)
        )
        observed = ObservedRun(kept.prepared)
        stack.enter_context(entered(prepared.companions))
        on_terminal, live = manner.on_terminal, manner.live
        people = people_of(prepared, options, desk, stack, on_terminal=on_terminal, live=live)
        output = _output(observed, options, manner, people)
        companions = _companions(prepared, kept, people, yes=options.yes)
        run = _mission_run(prepared, kept, output, companions, manner, requests, resuming)
        observed.run = run
        kept.follow(run)
        if not _begun(output):
            return None, kept
        if isinstance(output, AbstractContextManager):
            stack.enter_context(output)
        return run.execute(), kept


def _mission_run(
    prepared: Prepared,
    kept: Kept,
    output: Output,
    companions: list[Companion],
    manner: Manner,
    requests: StopRequests,
    resuming: Resuming | None,
) -> MissionRun:
    link, pipe = prepared.link, watch_pipe(sys.stdout)
    why = SaysWhyItWaits(link, requests) if link is not None and not manner.live else None
    return MissionRun(
        prepared.engine,
        prepared.backend,
        observers=[output, *([why] if why else [])],
        watchers=[each for each in (output, pipe, why) if isinstance(each, Watcher)],
        companions=companions,
        tap=kept.tap,
        requests=requests,
        factor=manner.factor,
        resuming=resuming,
        breakpoints=prepared.breakpoints,
    )


def _companions(prepared: Prepared, kept: Kept, people: People, *, yes: bool) -> list[Companion]:
    """Return the companions of the mission, with one that answers its questions."""
    operator, words, panel, page, stepper = people
    companions: list[Companion] = [*prepared.companions, *kept.companions]
    if panel or (operator and answers(prepared.loaded)):
        # A user may decide differently the next time.
        companions = [each for each in companions if not isinstance(each, LoopWatch)]
    if not prepared.attended:
        nobody = FirstChoice("--yes") if yes else FirstChoice("no terminal", "warning")
        companions.append(operator or nobody)
    return companions + [each for each in (words, panel, page, stepper) if each is not None]


def _begun(output: Output) -> bool:
    """Write the beginning of the output; return whether it could be written."""
    try:
        output.begin()
    except OSError as error:
        silence_stdout()
        say(f"nothing has moved: the output cannot be written: {error.strerror}")
        return False
    return True


def _say_unused(prepared: Prepared) -> None:
    """Print which of the requested triggers have never fired, and why."""
    for companion in prepared.companions:
        if isinstance(companion, TriggerScript):
            _say_never_fired(companion.unused, "the mission reached no wait that has it")
            _say_never_fired(companion.forestalled, "something else ended its wait first")


def _say_never_fired(firings: Sequence[Firing], why: str) -> None:
    if firings:
        names = ", ".join(f"'{firing.trigger}'" for firing in firings)
        say(f"warning: never fired, because {why}: {names}")


def _output(observed: ObservedRun, options: RunOptions, manner: Manner, people: People) -> Output:
    out = sys.stdout
    if options.json:
        out.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
        return JsonLines(out, observed)
    if manner.live:
        from rich.console import Console

        from pirate_sm.cli.output.live_view import LiveView

        speed = "max" if manner.factor == inf else f"{manner.factor:g} ×"
        if observed.prepared.backend.real_time:
            speed = "real time"
        console = Console(file=out, highlight=False)
        return LiveView(console, observed, speed, people.operator, people.words)
    return EventLines(out, observed, quiet=options.quiet)


def _conclude(result: Result, options: RunOptions) -> int:
    """Print on standard error what the output lacks; return the exit code."""
    if result.error is not None and result.exit_code == ExitCode.BUG:
        say_bug(result.error, options.debug)
    elif result.error is not None and options.debug:
        show_traceback(result.error)
    elif result.exit_code == ExitCode.OUTPUT_LOST:
        silence_stdout()
        ended = result.ended
        if ended.outcome == "interrupted":  # its message is about the output
            say(f"{ended.message}; the mission was stopped safely")
        else:
            say(f"the output cannot be written; the mission {ended.outcome}: {ended.message}")
    return result.exit_code


class PipeWatch:
    """A watcher that notices when the other end of a pipe has been closed.

    A mission may wait for minutes without output. It must not continue unseen until the next line.
    """

    def __init__(self, out: TextIO) -> None:
        self._poll = select.poll()
        # No event is requested: the closed other end is always reported.
        self._poll.register(out.fileno(), 0)

    def pulse(self, now_s: float) -> None:
        """Check that the output is still read.

        Raises:
            BrokenPipeError: The other end is closed.
        """
        if self._poll.poll(0):
            raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))


def watch_pipe(out: TextIO) -> PipeWatch | None:
    """Return a watcher of the output if it is a pipe or a socket."""
    try:
        mode = os.fstat(out.fileno()).st_mode
    except (OSError, ValueError):  # not a file
        return None
    return PipeWatch(out) if stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode) else None


# --- pirate run ---------------------------------------------------------------------------------


ON_A_TERMINAL = 4.0
"""Mission seconds per second if a user probably watches."""


def run_mission(options: RunOptions) -> int:
    """Run the mission of the options; return the exit code.

    Raises:
        LoadError: The files have errors; nothing has moved.
        UsageError: An argument does not fit; nothing has moved.
    """
    if options.json and options.quiet:
        raise UsageError("--json and --quiet exclude each other")
    if options.json and options.plain:
        raise UsageError("--json and --plain exclude each other")
    on_terminal = is_terminal(sys.stdout) and not (options.json or options.quiet)
    factor = read_speed(options.speed, ON_A_TERMINAL if is_terminal(sys.stdout) else inf)
    if options.resume is not None:
        # Most runs never need it, and it takes time to import.
        from pirate_sm.cli.commands.resume import resume_run

        return resume_run(options, Manner(on_terminal, False, factor))
    if options.mission is None:
        raise UsageError("name a MISSION, or a recording with --resume")
    _refuse_without_resume(options)
    prepared = prepare(options.order(), say=say)
    if prepared.confirmation and not options.yes:
        what = prepared.confirmation
        agree(f"{what}. Is it free to?", nobody=f"{what}: agree to it with --yes")
    requests = StopRequests()
    manner, begun = Manner(on_terminal, False, factor), None
    with CaughtSignals(requests, ends_process=True):
        if prepared.backend.real_time:
            # Simulated robots are where they are declared to be, and it takes time to import.
            from pirate_sm.cli.commands.resume import take_over

            prepared, begun = take_over(prepared, options, requests)
        return run_prepared(prepared, options, manner, requests, begun)


def _refuse_without_resume(options: RunOptions) -> None:
    """Refuse options that only --resume has.

    Raises:
        UsageError: One is given.
    """
    given = {"--look": options.look, "--at": options.at, "--accept": options.accept}
    if wrong := [name for name, value in given.items() if value]:
        raise UsageError(f"{', '.join(wrong)}: only together with --resume")
