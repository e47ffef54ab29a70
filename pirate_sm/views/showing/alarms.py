"""What is wrong, and how missions have ended: the newest cascade in a bar, all of it in a list."""

from __future__ import annotations

from collections.abc import Container, Sequence
from itertools import pairwise
from textwrap import wrap
from typing import NamedTuple

from rich.text import Text

from pirate_sm.core.events import BuiltInFault
from pirate_sm.views.showing.effect_lines import UNCONFIRMED, EffectLine, away
from pirate_sm.views.showing.snapshot import ENDED, NumberedLine, Snapshot
from pirate_sm.views.showing.text_styles import line

_CASCADE_S = 10.0
"""What goes wrong so soon after the last thing is taken for its consequence [decided]."""

_MOST_LINES = 3
"""Lines of the bar for the link, and for each alarm."""

_GRAVE = 3

_UNHEARD = {BuiltInFault.SENSOR_SILENT.code, BuiltInFault.LINK_SILENT.code}


class Alarm(NamedTuple):
    """Something wrong, or how a mission has ended.

    Attributes:
        entry: The numbered line about it.
        first: Whether it is the first of its cascade, and so its cause.
        over: Whether it was a silence, and the robot is heard again.
        seen: Whether the operator has acknowledged it.
    """

    entry: NumberedLine
    first: bool
    over: bool
    seen: bool

    @property
    def text(self) -> str:
        """Return all of it."""
        topic, text = self.entry.line
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
    entries = snapshot.story.alarms
    firsts = {each.number for each in entries[:1]}
    firsts |= {after.number for before, after in pairwise(entries) if _begins(before, after)}
    return [
        Alarm(each, each.number in firsts, _is_over(snapshot, each), each.number in seen)
        for each in entries
    ]


def _begins(before: NumberedLine, after: NumberedLine) -> bool:
    """Return whether a line is not a consequence of the one before."""
    return before.line.topic == ENDED or after.now_s - before.now_s > _CASCADE_S


def pending(snapshot: Snapshot, seen: Container[int]) -> list[Alarm]:
    """Return what the bar shows: of the newest cascade the first alarm, and how its run ended.

    What was acknowledged, or is over, is left out. A mere warning hides nothing else.
    """
    found = alarms(snapshot, seen)
    newest: list[Alarm] = []
    cascade: list[Alarm] = []
    for each in found:
        cascade = [] if each.first else cascade
        if not (each.seen or each.over):
            cascade.append(each)
        if cascade and _gravity(cascade) >= _gravity(newest):
            newest = cascade
    if _gravity(newest) == _GRAVE:
        newest = [each for each in newest if each.entry.line.topic != "warning"]
    since = newest[0].entry.number if newest else 0
    after = [each for each in found if each.entry.number > since]
    ends = [each for each in after if each.entry.line.topic == ENDED and not each.seen][:1]
    if ends and newest[0].entry.line.text.partition(" (")[0] in ends[0].text:
        return ends  # it says why itself
    return newest[:1] + ends


def _gravity(cascade: Sequence[Alarm]) -> int:
    """Return 3 if one of them is a fault or a bad end, 2 for a success, 1 for warnings only."""
    lines = [each.entry.line for each in cascade]
    grave = (1 if each.topic == "warning" else 2 + (not _succeeded(each)) for each in lines)
    return max(grave, default=0)


def _succeeded(line: EffectLine) -> bool:
    return line.topic == ENDED and line.text.startswith("succeeded")


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
        more = f"  (Esc: seen, !: {f'{left} more' if left else 'all'}) " if keys and last else ""
        sign = "■" if each.entry.line.topic == ENDED else "⚠"
        rows = _rows(f"{sign} {each.entry.now_s:.1f} s  {each.text}", width)
        if len(rows[-1]) + len(more) > width:
            rows.append(line(" "))
        lines += [*rows[:-1], rows[-1].append(more)]
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
    return _rows(f"⚠ {said}", width) if said else []


def _rows(said: str, width: int) -> list[Text]:
    """Return what begins with a sign, in lines as long as there is room for."""
    rows = wrap(said, max(width - 4, 20), max_lines=_MOST_LINES, placeholder=" …")
    return [line(f" {row} " if at == 0 else f"   {row} ") for at, row in enumerate(rows)]


def _is_over(snapshot: Snapshot, entry: NumberedLine) -> bool:
    """Return whether a silence was reported, and the robot is heard again.

    Of no other fault is that known: its rule is not true either while a motor is stopped that has
    failed, or while a signal is unknown.
    """
    state = snapshot.state
    if entry.line.topic != "fault" or state is None or not snapshot.live:
        return False
    code = entry.line.text.partition(": ")[0]
    return code in _UNHEARD and not (state.faults.silent or state.faults.blind)


def shows_success(snapshot: Snapshot, seen: Container[int]) -> bool:
    """Return whether the bar says nothing but that a mission has succeeded."""
    shown = pending(snapshot, seen)
    if len(shown) != 1 or trouble(snapshot, 80):
        return False
    return _succeeded(shown[0].entry.line)
