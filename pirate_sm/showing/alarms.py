"""What is wrong, and how missions have ended: the newest cascade in a bar, all of it in a list."""

from __future__ import annotations

from collections.abc import Container
from itertools import pairwise
from textwrap import wrap
from typing import NamedTuple

from rich.text import Text

from pirate_sm.model.fault_codes import BuiltInFault
from pirate_sm.showing.effect_lines import UNCONFIRMED, away
from pirate_sm.showing.run_history import ENDED, NumberedLine
from pirate_sm.showing.snapshot import Snapshot
from pirate_sm.showing.text_styles import fitted, line

_CASCADE_S = 10.0
"""What goes wrong so soon after the last thing is taken for its consequence [decided]."""

_MOST_LINES = 2
"""Lines of the bar for the link; as many follow for a cascade."""

_UNHEARD = {BuiltInFault.SENSOR_SILENT.code, BuiltInFault.LINK_SILENT.code}


class Alarm(NamedTuple):
    """Something wrong, or how a mission has ended.

    Attributes:
        told: The line about it.
        first: Whether it is the first of its cascade, and so its cause.
        over: Whether the signals show that it is not so any more.
        seen: Whether the operator has acknowledged it.
    """

    told: NumberedLine
    first: bool
    over: bool
    seen: bool

    @property
    def text(self) -> str:
        """Return all of it."""
        topic, text = self.told.line
        if topic == ENDED:
            outcome, _, why = text.partition(": ")
            return f"{outcome_word(outcome)}: {why}"
        return f"{topic}: {text}"


def outcome_word(outcome: str) -> str:
    """Return how a run has ended, in capitals."""
    return "STOPPED" if outcome == "interrupted" else outcome.upper()


def alarms(snapshot: Snapshot, seen: Container[int]) -> list[Alarm]:
    """Return every alarm, oldest first.

    Args:
        snapshot: The moment.
        seen: Numbers of the lines that the operator has acknowledged.
    """
    told = snapshot.story.alarms
    firsts = {each.number for each in told[:1]}
    firsts |= {after.number for before, after in pairwise(told) if _begins(before, after)}
    return [
        Alarm(each, each.number in firsts, _is_over(snapshot, each), each.number in seen)
        for each in told
    ]


def _begins(before: NumberedLine, after: NumberedLine) -> bool:
    """Return whether a line is no consequence of the one before."""
    return before.line.topic == ENDED or after.now_s - before.now_s > _CASCADE_S


def pending(snapshot: Snapshot, seen: Container[int]) -> list[Alarm]:
    """Return what the bar shows: of the newest cascade the first alarm, and how its run ended.

    What was acknowledged, or is over, is left out.
    """
    newest: list[Alarm] = []
    cascade: list[Alarm] = []
    for each in alarms(snapshot, seen):
        cascade = [] if each.first else cascade
        if not (each.seen or each.over):
            cascade.append(each)
        newest = cascade or newest
    ends = [each for each in newest[1:] if each.told.line.topic == ENDED][-1:]
    if ends and newest[0].told.line.text.partition(" (")[0] in ends[0].text:
        return ends  # it says why itself
    return newest[:1] + ends


def bar(snapshot: Snapshot, seen: Container[int], width: int, *, keys: bool = True) -> list[Text]:
    """Return what is wrong now, the link first; nothing while nothing is.

    Args:
        snapshot: The moment.
        seen: Numbers of the lines that the operator has acknowledged.
        width: Width of a line.
        keys: Whether there are keys to acknowledge and to open the list.
    """
    lines, shown = trouble(snapshot, width), pending(snapshot, seen)
    left = sum(not (each.seen or each.over) for each in alarms(snapshot, seen)) - len(shown)
    for each in shown:
        last = each is shown[-1]
        more = f"   (Esc: seen, !: {f'{left} more' if left else 'all'}) " if keys and last else " "
        sign = "■" if each.told.line.topic == ENDED else "⚠"
        text = line(f" {sign} {each.told.now_s:.1f} s  {each.text}")
        lines.append(fitted(text, min(len(text), max(width - len(more), 0))).append(more))
    return lines


def trouble(snapshot: Snapshot, width: int) -> list[Text]:
    """Return what is wrong with the link now, and what the robot may be doing; or nothing."""
    link, state, said = snapshot.link, snapshot.state, ""
    if link is not None and state is not None:
        moving = state.robot.motion is not None
        stopping = state.mission.ending is not None or state.mission.ended
        said = away(link, stopping=stopping, moving=moving)
        if not said and snapshot.over and not link.stopped:
            said = UNCONFIRMED
    if not said and snapshot.held_s:
        held = f"this program has not looked at the robot for {snapshot.held_s:.1f} s"
        said = f"{held}; wheels may be turning: cut power"
    rows = wrap(said, max(width - 4, 20), max_lines=_MOST_LINES, placeholder=" …")
    return [line(f" {'⚠' if at == 0 else ' '} {row} ") for at, row in enumerate(rows)]


def _is_over(snapshot: Snapshot, told: NumberedLine) -> bool:
    """Whether a fault was reported that the signals show no more."""
    state, robot = snapshot.state, snapshot.scene.robot
    if told.line.topic != "fault" or state is None or not snapshot.live:
        return False
    code, faults = told.line.text.partition(": ")[0], state.faults
    if code in _UNHEARD:
        return not (faults.silent or faults.blind)
    rules = [index for index, rule in enumerate(robot.faults) if rule.code == code]
    return bool(rules) and not faults.raised.intersection(rules)


def shows_success(snapshot: Snapshot, seen: Container[int]) -> bool:
    """Return whether the bar says nothing but that a mission has succeeded."""
    shown = pending(snapshot, seen)
    if len(shown) != 1 or trouble(snapshot, 80):
        return False
    return shown[0].told.line.topic == ENDED and shown[0].told.line.text.startswith("succeeded")
