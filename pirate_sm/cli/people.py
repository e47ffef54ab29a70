"""The people of a run: companions for a keyboard and for a control panel.

At the keyboard one key answers, and Enter gives the first choice.
"""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from pirate_sm.cli.options.running import RunOptions
from pirate_sm.cli.stepper import STEPPER_KEYS, Stepper
from pirate_sm.core.effects import Ask, Effect, Ended, Log, TriggerFired, WaitArmed
from pirate_sm.core.errors import ExitCode, UsageError
from pirate_sm.core.events import Answer, Event
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import Stop, StopRequests
from pirate_sm.running.runtime.scripted_events import Answered
from pirate_sm.running.wiring import Prepared, answers

if TYPE_CHECKING:
    from pirate_sm.core.engine import EngineState
    from pirate_sm.robot.control_panel.panel_reader import (
        EndRun,
        PanelCompanion,
        PanelReader,
        PressSource,
    )
    from pirate_sm.robot.detectors.simple_detectors import Keys, WordKeys
    from pirate_sm.views.report.page_process import PageProcess


# --- the keyboard -------------------------------------------------------------------------------


_LOOK_EVERY_S = 0.05


def can_type() -> bool:
    """Return whether standard input is a terminal whose keys reach this process."""
    try:
        fd = sys.stdin.fileno()
        # A process in the background would be stopped by touching the terminal, during a run.
        return os.isatty(fd) and os.tcgetpgrp(fd) == os.getpgrp()
    except (AttributeError, OSError, ValueError):  # closed, or no terminal of ours
        return False


class TerminalKeys:
    """Reads keys as they are pressed, without echo, while it is entered; Ctrl-C still works."""

    def __init__(self) -> None:
        self._fd = sys.stdin.fileno()
        self._before: list[Any] | None = None

    def __enter__(self) -> Self:
        """Let keys arrive one by one, without echo."""
        self._before = termios.tcgetattr(self._fd)
        tty.setcbreak(self._fd)
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the terminal as it was."""
        if self._before is not None:
            with suppress(termios.error):  # the terminal may have gone
                termios.tcsetattr(self._fd, termios.TCSADRAIN, self._before)

    def pressed(self) -> str:
        """Return the keys pressed since the last call."""
        ready, _, _ = select.select([self._fd], [], [], 0)
        if not ready:
            return ""
        try:
            return os.read(self._fd, 64).decode(errors="replace")
        except OSError:
            return ""  # the terminal has gone; a signal will follow


class _Share:
    """The keys of one user of a shared keyboard."""

    def __init__(self, look: Callable[[], None]) -> None:
        self._look = look
        self.waiting = ""

    def pressed(self) -> str:
        """Return this user's keys since the last call."""
        self._look()
        keys, self.waiting = self.waiting, ""
        return keys


class SharedKeys:
    """Shares a keyboard: some keys are for a paused mission or words, all others are answers.

    Attributes:
        stepper: The keys for a paused mission.
        words: The keys for words of the detector.
        answers: The other keys.
    """

    def __init__(self, keys: Keys, for_words: str, for_stepper: str = "") -> None:
        self._keys = keys
        self._for_words, self._for_stepper = for_words, for_stepper
        self.stepper = _Share(self._look)
        self.words = _Share(self._look)
        self.answers = _Share(self._look)

    def _look(self) -> None:
        for key in self._keys.pressed():
            low = key.lower()
            share = self.words if low in self._for_words else self.answers
            share = self.stepper if low in self._for_stepper else share
            share.waiting += key


class AllKeys:
    """The keys of several sources."""

    def __init__(self, sources: Sequence[Keys]) -> None:
        self._sources = tuple(sources)

    def pressed(self) -> str:
        """Return the keys pressed since the last call, source by source."""
        return "".join(each.pressed() for each in self._sources)


class Operator:
    """A companion that asks an operator the mission's questions and the operator's triggers.

    Attributes:
        question: The present question, empty if there is none.
        choices: Its answers, numbered from 1.
    """

    def __init__(
        self,
        keys: Keys,
        heard: Mapping[str, Sequence[str]],
        show_question: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Begin with no question.

        Args:
            keys: Source of the answers.
            heard: The words that the wait of each phase listens to.
            show_question: Shows a question if there is no view.
        """
        self._keys = keys
        self._heard = heard
        self._show = show_question
        self.question = ""
        self.choices: tuple[str, ...] = ()
        self._expects = False
        self._answer: str | None = None
        self.due_s = inf

    @property
    def listening(self) -> bool:
        """Whether an operator may answer."""
        return bool(self.choices)

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Ask a new question; drop an old one."""
        for effect in effects:
            if isinstance(effect, Ask):
                self._put(effect.question, effect.choices, now_s, expects=True)
            elif isinstance(effect, WaitArmed):
                words = tuple(self._heard.get(effect.phase, ()))
                self._put("Operator:" if words else "", words, now_s, expects=False)
            elif isinstance(effect, TriggerFired | Ended):
                self._put("", (), now_s, expects=False)

    def look(self, state: EngineState | None, now_s: float) -> Sequence[Log]:
        """Return a log line if a key has answered; ``speak`` returns the answer next."""
        self.due_s = now_s + _LOOK_EVERY_S
        for key in self._keys.pressed():
            choice = self._choice(key)
            if choice is not None:
                self._put("", (), now_s, expects=False)
                self._answer = choice
                return (Answered("info", f"answered '{choice}' (operator)"),)
        return ()

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the answer found by ``look``."""
        answer, self._answer = self._answer, None
        return () if answer is None else (Answer(answer),)

    def _put(self, question: str, choices: tuple[str, ...], now_s: float, expects: bool) -> None:
        self.question, self.choices = question, choices
        self._expects = expects
        self.due_s = now_s if choices else inf
        if choices:
            self._keys.pressed()  # earlier keys are not an answer
            offered = "  ".join(f"[{n}] {choice}" for n, choice in enumerate(choices, 1))
            self._show(f"{question}  {offered}")

    def _choice(self, key: str) -> str | None:
        if key in "\r\n" and self._expects:
            return self.choices[0]
        if key.isdecimal() and 1 <= int(key) <= len(self.choices):
            return self.choices[int(key) - 1]
        return None


# --- companions ---------------------------------------------------------------------------------


class People(NamedTuple):
    """The companions for people.

    Attributes:
        operator: Answers questions, from the keyboard and the panel.
        words: Says the detector's words from the keyboard.
        panel: Does all else that a panel does.
        page: Does what is pressed on the page.
        stepper: Resumes a mission that a breakpoint has paused, from the keyboard.
    """

    operator: Operator | None = None
    words: WordKeys | None = None
    panel: PanelCompanion | None = None
    page: PanelCompanion | None = None
    stepper: Stepper | None = None


class Desk(NamedTuple):
    """Where people can press buttons during a run.

    Attributes:
        panel: The control panel, opened; None: the run has none.
        page: The page of the run; None: it has none.
    """

    panel: PanelReader | None
    page: PageProcess | None


def open_desk(prepared: Prepared, requests: StopRequests, stack: ExitStack, *, page: bool) -> Desk:
    """Open the panel of the run, if it has one, for as long as the stack lasts.

    Args:
        prepared: The run.
        requests: Receives its stop.
        stack: Closes what is opened.
        page: Whether the run has a page.

    Raises:
        UsageError: The panel's device is not there or cannot be opened, or the page not be served.
    """

    def end_run(reason: str) -> None:
        requests.ask(Stop(reason, ExitCode.INTERRUPTED))

    panel = shown = None
    if prepared.panel is not None:
        panel = stack.enter_context(prepared.panel.reader(end_run))
    if page:
        shown = stack.enter_context(page_process(prepared, end_run))
    return Desk(panel, shown)


def page_process(prepared: Prepared, end_run: EndRun) -> PageProcess:
    """Return the page of this run, and of others with the same robot after it.

    Raises:
        UsageError: It cannot be served.
    """
    from pirate_sm.views.report.page_process import PageProcess

    return PageProcess(
        () if prepared.others_words else prepared.loaded.robot.detector_words, end_run
    )


def people_of(
    prepared: Prepared,
    options: RunOptions,
    desk: Desk,
    stack: ExitStack,
    *,
    on_terminal: bool,
    live: bool,
) -> People:
    """Return the companions for the people who see the run.

    Args:
        prepared: The run.
        options: Its options.
        desk: Where they can press buttons.
        stack: Gives the keyboard back at its end.
        on_terminal: Whether an operator reads standard output.
        live: Whether the run is redrawn in place, with its questions.

    Raises:
        UsageError: The detector is an operator who could neither see the run nor act, or
            no operator could resume the mission after a breakpoint.
    """
    shown = sys.stdout if on_terminal else sys.stderr
    present = shown is not None and shown.isatty() and can_type()
    panel = _presses(prepared, desk.panel, keyboard=can_type())
    page = _presses(prepared, desk.page, keyboard=True, watching=False)
    by_keys = prepared.detector == "operator" and present and on_terminal
    says_words = by_keys or any(each is not None and each.says_words for each in (panel, page))
    if prepared.detector == "operator" and not says_words:
        raise UsageError("--detector operator needs a terminal to show the run and read keys")
    breaks = bool(prepared.order.breakpoints)
    if breaks and not (present or page is not None or (panel is not None and panel.resumes)):
        needs = "a terminal with its keys, a panel with a button that resumes, or --page"
        raise UsageError(
            f"--break pauses the mission, and no operator could resume it: it needs {needs}"
        )
    answering = present or (panel is not None and panel.answers)
    asked = answering and not options.yes and not prepared.attended
    if not (asked or by_keys or (breaks and present)):
        return People(panel=panel, page=page)
    from pirate_sm.robot.detectors.simple_detectors import LETTERS, WordKeys

    def show(text: str) -> None:
        if not live and shown is not None:
            print(visible(text), file=shown, flush=True)

    sources: list[Keys] = [panel] if panel is not None else []
    words = stepper = None
    if present:
        for_words, for_stepper = LETTERS if by_keys else "", STEPPER_KEYS if breaks else ""
        keys = SharedKeys(stack.enter_context(TerminalKeys()), for_words, for_stepper)
        sources.append(keys.answers)
        stepper = Stepper(keys.stepper) if breaks else None
        if by_keys:
            robot, valid_for_s = prepared.loaded.robot, _valid_for_s(prepared)
            words = WordKeys(keys.words, robot.detector_words, valid_for_s)
    operator = Operator(AllKeys(sources), answers(prepared.loaded), show) if asked else None
    return People(operator, words, panel, page, stepper)


def _presses(
    prepared: Prepared, source: PressSource | None, *, keyboard: bool, watching: bool = True
) -> PanelCompanion | None:
    """Return what does as is pressed there; None where nothing can be pressed."""
    if source is None:
        return None
    from pirate_sm.robot.control_panel.panel_reader import PanelCompanion
    from pirate_sm.running.runtime.breakpoints import breakpoints

    return PanelCompanion(
        source,
        prepared.loaded.robot,
        speaks=prepared.others_words,
        valid_for_s=_valid_for_s(prepared),
        keyboard=keyboard,
        watching=watching,
        places=lambda line: breakpoints(prepared.loaded, [line])[0],
    )


def _valid_for_s(prepared: Prepared) -> float:
    return prepared.loaded.loaded_robot.profile.detector.valid_for
