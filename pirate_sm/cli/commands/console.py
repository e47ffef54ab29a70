"""`pirate console`: opens the console and brings the robot to its safe state at the end."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from pirate_sm.cli.errors import say, say_bug
from pirate_sm.cli.options.declaring import read_speed
from pirate_sm.cli.options.running import ConsoleOptions
from pirate_sm.cli.output.terminal import is_terminal, progress, shows_signs
from pirate_sm.cli.people import page_process
from pirate_sm.cli.run_recording import RecordingOptions, check_page, recorded
from pirate_sm.core.errors import ExitCode, UsageError
from pirate_sm.core.generated_missions import BY_HAND
from pirate_sm.core.palette import Theme
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import CaughtSignals, Stop, StopRequests
from pirate_sm.running.wiring import Order, Prepared, load, prepare

if TYPE_CHECKING:
    from pirate_sm.core.loading import LoadedMission
    from pirate_sm.robot.control_panel.panel_reader import PressSource
    from pirate_sm.running.runtime.pump import Resuming
    from pirate_sm.running.wiring.run_recorder import Kept
    from pirate_sm.views.console.app import Console
    from pirate_sm.views.console.session import OperatorSession
    from pirate_sm.views.report.page_process import PageProcess

_LOOK_EVERY_S = 0.1

SWITCH_EVERY_S = 0.001
"""How long a thread of Python may keep the others waiting, instead of 5 ms. A stop on a panel goes
through two threads, the panel's and the run's, and either waits for the one that draws."""

RECORDING = ".mcap"
"""Files with this suffix are recordings to view, not missions to run."""


def open_console(options: ConsoleOptions) -> int:
    """Open the console; return the exit code when it is closed.

    Without a mission the robot is driven by hand, and nothing is recorded.

    Raises:
        LoadError: The files have errors; nothing has moved.
        UsageError: An argument does not fit; nothing has moved.
    """
    order, factor = options.order(), read_speed(options.speed, 1.0)
    _check_terminal()
    if order.mission.endswith(RECORDING):
        return _view(order.mission, options.theme)
    requests = StopRequests()
    if options.resume is not None:
        from pirate_sm.cli.commands.resume import resume_dialog

        dialog = resume_dialog(options, requests)
        with CaughtSignals(requests):
            chosen = dialog.decide()
        if chosen is None:
            return dialog.code
        opened = _session(chosen[0], options, factor, chosen[1], dialog.prepared.loaded)
    elif options.at:
        raise UsageError("--at: only together with --resume")
    else:
        prepared, begun = _prepared(order), None
        if prepared.backend.real_time:
            from pirate_sm.cli.commands.resume import take_over

            # From where the robot is, each phase is checked before it is offered.
            order = prepared.order
            unchecked = replace(prepared, order=replace(order, check=False))
            with CaughtSignals(requests):
                prepared, begun = take_over(unchecked, options, requests)
            prepared = replace(prepared, order=replace(prepared.order, check=order.check))
        opened = _session(prepared, options, factor, begun)
    from pirate_sm.views.console.app import Console
    from pirate_sm.views.console.check_process import CheckProcess
    from pirate_sm.views.console.session import Watchdog, ender
    from pirate_sm.views.console.terminal_driver import StopDriver

    sys.setswitchinterval(SWITCH_EVERY_S)
    session, page = opened
    with ExitStack() as stack, CaughtSignals(session.quitting, ends_process=True):
        pressed: list[PressSource] = [stack.enter_context(each) for each in (page,) if each]
        Watchdog(session.quitting, ender()).start()
        checking = CheckProcess(lambda: session.quitting.stop is not None)
        ask = stack.enter_context(checking).ask
        if session.prepared.panel is not None:
            reader = session.prepared.panel.reader(lambda reason: session.stop())
            pressed.append(stack.enter_context(reader))
        app = Console(
            session, *pressed, ask_check=ask, theme=options.theme, driver_class=StopDriver
        )
        try:
            app.run()
        except Exception as error:
            app.failure = app.failure or error
        finally:
            session.quit()
            while not session.join(_LOOK_EVERY_S):
                pass  # a second signal may come meanwhile
    return _conclude(app, session, options.debug)


def _check_terminal() -> None:
    """Check that the console can be shown.

    Raises:
        UsageError: There is no terminal, or it lacks the signs.
    """
    if not (is_terminal(sys.stdout) and sys.stdin.isatty() and sys.stderr.isatty()):
        raise UsageError("the console needs a terminal; `pirate run` does without")
    if not shows_signs(sys.stdout):
        raise UsageError(
            f"the console needs a terminal with UTF-8, this one has {sys.stdout.encoding}: "
            "set LANG=C.UTF-8, or use `pirate run`"
        )


def _session(
    prepared: Prepared,
    options: ConsoleOptions,
    factor: float,
    resuming: Resuming | None = None,
    then: LoadedMission | None = None,
) -> tuple[OperatorSession, PageProcess | None]:
    """Return a session of the console with a recording of each mission, and the page of its runs.

    Raises:
        UsageError: The page is asked for, and cannot be served or nothing is recorded.
    """
    from pirate_sm.views.console.session import OperatorSession, unkept

    recording = RecordingOptions(None, options.no_record, options.live)
    if options.page:

        def end_run(reason: str) -> None:
            session.stop(Stop(reason, ExitCode.SUCCEEDED))

        check_page(prepared, recording)
        recording = replace(recording, page=page_process(prepared, end_run))

    def keep(prepared: Prepared) -> AbstractContextManager[Kept]:
        if prepared.loaded.mission.mission == BY_HAND:
            return unkept(prepared)
        return recorded(prepared, recording, factor)

    session = OperatorSession(prepared, factor=factor, keep=keep, resuming=resuming, then=then)
    return session, recording.page


def _view(path: str, theme: Theme) -> int:
    """Show a recording; return the exit code when it is closed.

    Raises:
        RecordingError: The recording cannot be read.
    """
    from pathlib import Path

    from pirate_sm.running.recording.read.reader import read_recording
    from pirate_sm.views.console.recording_viewer import RecordingViewer, recorded_snapshots
    from pirate_sm.views.console.session import LeaveRequests, Watchdog, ender
    from pirate_sm.views.console.terminal_driver import StopDriver

    with progress(f"reading {visible(path)}") as watch:
        reel = recorded_snapshots(read_recording(Path(path), watch))
    requests = LeaveRequests()
    viewer = RecordingViewer(
        reel, Path(path).name, requests=requests, theme=theme, driver_class=StopDriver
    )
    with CaughtSignals(requests, ends_process=True):
        Watchdog(requests, ender()).start()
        viewer.run()
    return requests.stop.exit_code if requests.stop is not None else ExitCode.SUCCEEDED


def _prepared(order: Order) -> Prepared:
    from pirate_sm.views.console.missions import without_mission

    if order.mission:
        return prepare(order, load(order), say=say)
    given = {"--set": order.settings, "--from": order.start_phase, "--forecast": order.forecast}
    if of_mission := [option for option, value in given.items() if value]:
        raise UsageError(f"{of_mission[0]} needs a mission")
    by_hand = replace(order, mission=BY_HAND, check=False)
    prepared = prepare(by_hand, without_mission(order), say=say)
    return replace(prepared, order=replace(by_hand, check=order.check))


def _conclude(app: Console, session: OperatorSession, debug: bool) -> int:
    """Print how the session ended and how it left the robot; return the exit code."""
    from pirate_sm.views.showing.effect_lines import left_state

    if parting := session.prepared.parting():
        say(parting)
    failures = [*app.faults]
    if app.failure is not None and not _gone(app.failure, session):
        failures.append(app.failure)
    for each in failures:
        say_bug(each, debug)
    result, stop, latest = session.result, session.quitting.stop, session.latest
    if result is not None:
        what = latest.scene.engine, latest.state, latest.story.setpoints, latest.link
        say(f"{result.ended.message}: {left_state(*what)}")
    if failures:
        return ExitCode.BUG
    if result is not None and result.ended.outcome != "interrupted":
        return result.exit_code
    return stop.exit_code if result is not None and stop is not None else ExitCode.SUCCEEDED


def _gone(failure: Exception, session: OperatorSession) -> bool:
    """Return whether it failed only because the terminal has gone."""
    stop = session.quitting.stop
    return isinstance(failure, OSError) and stop is not None and stop.exit_code > ExitCode.BUG
