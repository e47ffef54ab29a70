"""The people of a run: companions for a keyboard and for a control panel."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from typing import TYPE_CHECKING, NamedTuple

from pirate_sm.cli.keyboard import AllKeys, Operator, SharedKeys, TerminalKeys, can_type
from pirate_sm.cli.options.running import RunOptions
from pirate_sm.core.errors import UsageError
from pirate_sm.core.visible import visible
from pirate_sm.running.runtime.ending import INTERRUPTED, Stop, StopRequests
from pirate_sm.running.wiring import Prepared, answers

if TYPE_CHECKING:
    from pirate_sm.robot.control_panel.panel_reader import PanelCompanion, PanelReader
    from pirate_sm.robot.detectors.simple_detectors import Keys, WordKeys


class People(NamedTuple):
    """The companions for people.

    Attributes:
        operator: Answers questions, from the keyboard and the panel.
        words: Says the detector's words from the keyboard.
        panel: Does all else that a panel does.
    """

    operator: Operator | None = None
    words: WordKeys | None = None
    panel: PanelCompanion | None = None


def open_panel(prepared: Prepared, requests: StopRequests, stack: ExitStack) -> PanelReader | None:
    """Open the panel of the run for as long as the stack lasts; return None if it has none.

    Raises:
        UsageError: Its device is not there or cannot be opened.
    """
    if prepared.panel is None:
        return None

    def end_run(reason: str) -> None:
        requests.ask(Stop(reason, INTERRUPTED))

    return stack.enter_context(prepared.panel.reader(end_run))


def people_of(
    prepared: Prepared,
    options: RunOptions,
    reader: PanelReader | None,
    stack: ExitStack,
    *,
    on_terminal: bool,
    live: bool,
) -> People:
    """Return the companions for the people who see the run.

    Args:
        prepared: The run.
        options: Its options.
        reader: The panel, opened.
        stack: Gives the keyboard back at its end.
        on_terminal: Whether a person reads standard output.
        live: Whether the run is redrawn in place, with its questions.

    Raises:
        UsageError: The detector is a person who could neither see the run nor act.
    """
    shown = sys.stdout if on_terminal else sys.stderr
    present = shown is not None and shown.isatty() and can_type()
    panel = _panel(prepared, reader)
    by_keys = prepared.detector == "operator" and present and on_terminal
    if prepared.detector == "operator" and not by_keys and not (panel and panel.says_words):
        raise UsageError("--detector operator needs a terminal to show the run and read keys")
    answering = present or (panel is not None and panel.answers)
    asked = answering and not options.yes and not prepared.attended
    if not (asked or by_keys):
        return People(panel=panel)
    from pirate_sm.robot.detectors.simple_detectors import LETTERS, WordKeys

    def show(text: str) -> None:
        if not live and shown is not None:
            print(visible(text), file=shown, flush=True)

    sources: list[Keys] = [panel] if panel is not None else []
    words = None
    if present:
        keys = SharedKeys(stack.enter_context(TerminalKeys()), LETTERS if by_keys else "")
        sources.append(keys.answers)
        if by_keys:
            robot, valid_for_s = prepared.loaded.robot, _valid_for_s(prepared)
            words = WordKeys(keys.words, robot.detector_words, valid_for_s)
    operator = Operator(AllKeys(sources), answers(prepared.loaded), show) if asked else None
    return People(operator, words, panel)


def _panel(prepared: Prepared, reader: PanelReader | None) -> PanelCompanion | None:
    if reader is None:
        return None
    from pirate_sm.robot.control_panel.panel_reader import PanelCompanion

    return PanelCompanion(
        reader,
        prepared.loaded.robot,
        speaks=prepared.others_words,
        valid_for_s=_valid_for_s(prepared),
        keyboard=can_type(),
    )


def _valid_for_s(prepared: Prepared) -> float:
    return prepared.loaded.loaded_robot.profile.detector.valid_for
