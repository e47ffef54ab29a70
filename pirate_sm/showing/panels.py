"""What a person reads of a run, panel by panel: snapshots in, styled lines out."""

from __future__ import annotations

from math import isnan

from rich.text import Text

from pirate_sm.engine.mission.program import Question, Wait
from pirate_sm.engine.robot.robot_state import state_change
from pirate_sm.model.effects import Ended
from pirate_sm.model.fault_codes import BuiltInFault
from pirate_sm.model.simulation import SIMULATORS
from pirate_sm.showing.effect_lines import UNCONFIRMED, away, shortened
from pirate_sm.showing.pose import SIDES, pose_of
from pirate_sm.showing.progress_lines import idle, moving, waiting
from pirate_sm.showing.run_history import NumberedLine
from pirate_sm.showing.snapshot import Snapshot
from pirate_sm.showing.text_styles import (
    ACCENT,
    BAD,
    FLAG,
    GOOD,
    MUTED,
    STRONG,
    WARN,
    Part,
    fitted,
    in_columns,
    line,
)

TOPICS = {
    "fault": BAD,
    "error": BAD,
    "warning": WARN,
    "detected": GOOD,
    "ended": STRONG,
}

OUTCOME = {"succeeded": GOOD, "interrupted": WARN}
"""Styles of how a run has ended; any other end is bad."""

_TWO_COLUMNS = 70

Flag = tuple[str, str]
"""A word with a sign, and its style."""


def ended_flag(ended: Ended) -> Flag:
    """Return how a run has ended."""
    style = OUTCOME.get(ended.outcome, BAD)
    return f"■ {_outcome(ended.outcome)}", f"{FLAG}.{style}"


def _outcome(outcome: str) -> str:
    return "STOPPED" if outcome == "interrupted" else outcome.upper()


def mode(snapshot: Snapshot) -> Flag:
    """Return who has the robot, in a word with a sign, and its style."""
    state, ended = snapshot.state, snapshot.story.ended
    if snapshot.over:
        return ended_flag(ended) if ended is not None else ("■ OVER", f"{FLAG}.{BAD}")
    if state is None:
        return "… OPENING", FLAG
    if state.mission.ending is not None or state.mission.ended:
        return "■ ENDING", f"{FLAG}.{WARN}"
    if not snapshot.scene.mission:
        return "◆ BY HAND", f"{FLAG}.{ACCENT}"
    if state.mission.paused:
        return "‖ PAUSED", f"{FLAG}.{WARN}"
    return "▶ RUNNING", f"{FLAG}.{GOOD}"


def header(
    snapshot: Snapshot, width: int, *, flag: Flag | None = None, how: str = "", pace: str = ""
) -> Text:
    """Return what runs where, and what time it is.

    Args:
        snapshot: The moment.
        width: Of the line.
        flag: What is said first; by default who has the robot.
        how: More about the backend, beside the names.
        pace: What stands before the time; by default the backend.
    """
    scene = snapshot.scene
    word, style = flag or mode(snapshot)
    pipe = f" in {scene.loaded.pipe_name}" if scene.loaded.pipe_name else ""
    name = scene.mission or "no mission"
    more = f", {how}" if how else ""
    left = line((f" {word} ", style), " ", (name, STRONG), f" on {scene.robot.name}{pipe}{more}")
    right = f" {pace or scene.backend}  {snapshot.now_s:8.1f} s "
    return fitted(left, max(width - len(right), 0)).append(right)


def alarm(snapshot: Snapshot, seen: int, hint: str = "   (Esc: seen)") -> Text | None:
    """Return how the last mission ended, else the newest thing that is wrong.

    How it ended stays until the operator has seen it; what is wrong also goes when the engine
    knows that it is over. None: there is nothing.

    Args:
        snapshot: The moment.
        seen: Number of the last line that the operator has seen.
        hint: How it is taken down.
    """
    banner, told = snapshot.story.banner, snapshot.story.alarm
    if (found := trouble(snapshot)) is not None:
        return found
    if banner is not None and banner.number > seen:
        outcome, _, why = banner.line.text.partition(": ")
        return line(f" ■ {banner.now_s:.1f} s  {_outcome(outcome)}: {why}{hint} ")
    if told is None or told.number <= seen or _is_past(snapshot, told):
        return None
    topic, text = told.line
    return line(f" ⚠ {told.now_s:.1f} s  {topic}: {text}{hint} ")


def trouble(snapshot: Snapshot) -> Text | None:
    """Return what is wrong with the link now, and whether a stop waits for it; None: nothing."""
    link, state = snapshot.link, snapshot.state
    if link is None or state is None:
        return None
    stopping = state.mission.ending is not None or state.mission.ended
    said = away(link, stopping=stopping)
    if not said and snapshot.over and not link.stopped:
        said = UNCONFIRMED
    return line(f" ⚠ {said} ") if said else None


def _is_past(snapshot: Snapshot, told: NumberedLine) -> bool:
    """Whether a fault was reported that the signals show no more."""
    state, robot = snapshot.state, snapshot.scene.robot
    if told.line.topic != "fault" or state is None:
        return False
    code, faults = told.line.text.partition(": ")[0], state.faults
    if code in _UNHEARD:
        return not (faults.silent or faults.blind)
    rules = [index for index, rule in enumerate(robot.faults) if rule.code == code]
    return bool(rules) and not faults.raised.intersection(rules)


_UNHEARD = {BuiltInFault.SENSOR_SILENT.code, BuiltInFault.LINK_SILENT.code}


def shows_success(snapshot: Snapshot, seen: int) -> bool:
    """Return whether the bar says that a mission has succeeded."""
    banner, link = snapshot.story.banner, snapshot.link
    if banner is None or banner.number <= seen or (link is not None and link.trouble):
        return False
    return banner.line.text.startswith("succeeded")


def states(snapshot: Snapshot, width: int) -> list[Text]:
    """Return the state of each region (an open mark: not confirmed), contacts and words.

    Also the control in force, unless it is the usual one.
    """
    state, robot = snapshot.state, snapshot.scene.robot
    if state is None:
        return [line((" not known yet", MUTED))]
    change = state_change(robot, state.robot)
    labels = shortened(robot.regions)
    wide = max(map(len, labels))
    cells = []
    for region, label, name in zip(robot.regions, labels, change.states, strict=True):
        open_ = region in change.unconfirmed
        mark, style = ("○", WARN) if open_ else ("●", GOOD)
        cells.append(
            line((f"{mark} ", style), (f"{label:<{wide}} ", MUTED), (name, style if open_ else ""))
        )
    control = robot.controls[state.robot.control].name
    if control:
        cells.append(line(("◆ ", ACCENT), (f"{'Control':<{wide}} ", MUTED), (control, ACCENT)))
    if width < _TWO_COLUMNS:
        return [*cells, _contacts(snapshot), _words(snapshot)]
    return in_columns([*cells, _words(snapshot), _contacts(snapshot)], width, 2)


def _contacts(snapshot: Snapshot) -> Text:
    """Return which wall each wheel touches."""
    pose = pose_of(snapshot)
    parts: list[Part] = [("  at wall ", MUTED)]
    for number, side in enumerate(pose.touching, 1):
        at = SIDES[side] if side >= 0 else "–"
        parts.append((f"{number}{at} ", "" if side >= 0 else MUTED))
    if pose.origin and any(side >= 0 for side in pose.touching):
        parts.append(("by command", MUTED))
    return line(*parts)


def _words(snapshot: Snapshot) -> Text:
    """Return what is said from outside, as far as it is known."""
    state, robot = snapshot.state, snapshot.scene.robot
    assert state is not None
    count = len(robot.regions)
    parts: list[Part] = ["  "]
    for name, word in zip(robot.vocabulary.words[count:], state.words[count:], strict=True):
        if word is None and name == "joint":  # mostly unknown, and there is little room
            continue
        parts += [(f"{name} ", MUTED), (f"{word or '–'}   ", STRONG if word else MUTED)]
    return line(*parts)


def now(snapshot: Snapshot, width: int) -> list[Text]:
    """Return what is under way or waited for, and how long still."""
    state = snapshot.state
    if state is None:
        return [line(("the backend is being opened …", MUTED))]
    ended = snapshot.story.ended
    if snapshot.over and ended is not None:
        return [line((ended.message, OUTCOME.get(ended.outcome, BAD)))]
    lines = moving(snapshot, width)
    if state.mission.paused and snapshot.scene.mission:
        lines.append(line(("‖ ", WARN), "paused: drive by hand, or go on"))
    return lines + (waiting(snapshot, width) if snapshot.scene.mission else []) or [
        line((idle(snapshot), MUTED))
    ]


def phases(snapshot: Snapshot, width: int, rows: int) -> list[Text]:
    """Return the mission's phases around the present one: done, current, not yet."""
    program, state, story = snapshot.scene.loaded.program, snapshot.state, snapshot.story
    if not snapshot.scene.mission:
        return [line(("No mission is chosen.", MUTED)), line(("Press m for the list.", MUTED))]
    names = program.phases
    current = program.phase_of[state.mission.pc] if state is not None else ""
    at = names.index(current) if current in names else 0
    first = max(0, min(at - rows // 2, len(names) - rows))
    lines = []
    for name in names[first : first + rows]:
        own = f"{'  ' * name.count('/')}{name.rpartition('/')[2]}"
        spent_s = story.spent_s.get(name, 0.0)
        if name == story.phase.phase and story.ended is None:
            spent_s += snapshot.now_s - story.phase.since_s
        time = f"{spent_s:7.1f} s" if spent_s else ""
        mark, style = "·", MUTED
        if name == current and story.ended is None:
            mark, style = "▶", STRONG
        elif current.startswith(f"{name}/") and story.ended is None:
            mark, style = "▷", ""
        elif name in story.spent_s:
            mark, style = "✓", GOOD
        if mark == "▶" and state is not None:
            own += program.round_note(state.mission.pc)
        room = max(width - len(time) - 3, 4)
        lines.append(fitted(line((f"{mark} {own}", style)), room + 2).append(f" {time}", style))
    return lines


def link(snapshot: Snapshot) -> list[Text]:
    """Return how the link is."""
    health = snapshot.link
    if health is None:
        kind = dict.fromkeys(SIMULATORS, "a simulator has no link")
        kind["trace"] = "a trace has no link"
        return [line((kind.get(snapshot.scene.backend, "not connected yet"), MUTED))]
    share = health.repeated / health.written if health.written else 0.0
    lossy = share > 0.05
    word, style = ("● good", GOOD) if not lossy else ("◐ lossy", WARN)
    if health.trouble:
        word, style = "○ silent", BAD
    trip = "–" if isnan(health.round_trip_s) else f"{health.round_trip_s * 1000:.0f} ms"
    lost = ("  lost bytes ", MUTED), f"{health.dropped_bytes}"
    damaged = ("  damaged ", MUTED), f"{health.damaged}"
    return [
        line((word, style), (health.trouble and f": {health.trouble}", style)),
        line(("echo after ", MUTED), trip, ("   repeated ", MUTED), f"{share:.0%}"),
        line(("frames ", MUTED), f"{health.received}", *damaged, *lost),
    ]


def choices(snapshot: Snapshot) -> tuple[str, tuple[str, ...]]:
    """Return what the mission asks the operator now, and the answers; both empty when nothing."""
    state = snapshot.state
    if state is None or snapshot.over or state.mission.paused or not state.mission.begun:
        return "", ()
    here = snapshot.scene.loaded.program.instructions[state.mission.pc]
    if isinstance(here, Question):
        return here.text, tuple(choice for choice, _ in here.choices)
    if isinstance(here, Wait):
        words = tuple(trigger.answer for trigger in here.triggers if trigger.answer)
        return ("The mission waits for your word" if words else ""), words
    return "", ()


def question(snapshot: Snapshot, width: int) -> list[Text]:
    """Return what the operator is asked, with the keys that answer; nothing while nothing is."""
    asked, offered = choices(snapshot)
    if not offered:
        return []
    lines = [line((f"? {asked}  ", STRONG))]
    for number, choice in enumerate(offered, 1):
        key = line((f"[{number}] {choice}  ", STRONG))
        if len(lines[-1]) + len(key) > width:
            lines.append(line("  "))
        lines[-1].append_text(key)
    return lines


def told_line(told: NumberedLine) -> Text:
    """Return a line of the log."""
    topic, text = told.line
    style = TOPICS.get(topic, "")
    return line((f"{told.now_s:8.2f} ", MUTED), (f"{topic:<9} {text}", style))
