"""What an operator reads of a run, panel by panel: snapshots in, styled lines out."""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf, isnan
from textwrap import wrap

from rich.text import Text

from pirate_sm.core.effects import Ended
from pirate_sm.core.models import SIMULATORS
from pirate_sm.core.program import Question, SwitchControl, Wait
from pirate_sm.core.robot import STOPPED, state_change
from pirate_sm.core.sensing import JOINT
from pirate_sm.views.showing.alarms import outcome_word
from pirate_sm.views.showing.effect_lines import shortened
from pirate_sm.views.showing.picture import SIDES, pose_of
from pirate_sm.views.showing.snapshot import NumberedLine, Snapshot
from pirate_sm.views.showing.text_styles import (
    ACCENT,
    BAD,
    FLAG,
    GOOD,
    MUTED,
    STALE,
    STRONG,
    WARN,
    Part,
    ago,
    fitted,
    flowed,
    in_columns,
    line,
)

# --- what is under way --------------------------------------------------------------------------


def moving(snapshot: Snapshot, width: int) -> list[Text]:
    """Return the command under way and its time; nothing while there is none."""
    state = snapshot.state
    motion = state.robot.motion if state is not None else None
    if state is None or motion is None:
        return []
    name = snapshot.scene.robot.commands[motion.command].name
    if not snapshot.live:
        return [line(("? ", BAD), f"{name}: not known if it is done")]
    if isnan(motion.accepted_s):
        return [line(("▶ ", GOOD), f"{name}: sent, not yet accepted")]
    spent_s = state.mission.motion_clock(snapshot.engine_s) - motion.accepted_s
    limit_s = motion.deadline_s - motion.accepted_s
    return [line(("▶ ", GOOD), f"{name}: until it is done"), bar(spent_s, limit_s, width)]


def waiting(snapshot: Snapshot, width: int) -> list[Text]:
    """Return what the mission waits for and its time; nothing while it does not."""
    state = snapshot.state
    if state is None or not state.mission.begun:
        return []
    here = snapshot.scene.loaded.program.instructions[state.mission.pc]
    spent_s = state.mission.clock(snapshot.engine_s) - state.mission.armed_s
    if isinstance(here, SwitchControl):
        name = snapshot.scene.robot.controls[here.control].name or "the usual control"
        said = line(("○ ", WARN), f"{name}: until the joints bear their torques")
        return [said, bar(spent_s, here.timeout_s, width)]
    if not isinstance(here, Wait):
        return []
    lines = [
        line(("○ ", WARN), f"{each.text} ", (f"→ {each.go_name}", MUTED)) for each in here.triggers
    ]
    return [*lines, bar(spent_s, here.within_s, width)]


def idle(snapshot: Snapshot) -> str:
    """Return what the robot does while no command is under way."""
    state, robot = snapshot.state, snapshot.scene.robot
    asked = [] if state is None else [state.robot.latest[wheel.slot] for wheel in robot.wheels]
    if state is None or not any(asked):
        return "nothing is under way"
    if any(map(isnan, asked)):
        return "what the wheels were last asked for is not known"
    way = {1: "driving forward", -1: "driving backward"}.get(robot.travel(state.robot.latest))
    return f"{'' if snapshot.live else 'last asked for: '}{way or 'wheels are driven'}"


def bar(spent_s: float, limit_s: float, width: int) -> Text:
    """Return a bar of how much of a time has gone, and how much is left."""
    if isinf(limit_s) or isnan(limit_s):
        return line((f"  {spent_s:.1f} s so far", MUTED))
    text = f" {max(limit_s - spent_s, 0.0):.1f} s left"
    room = max(width - len(text) - 2, 4)
    full = round(room * min(1.0, max(0.0, spent_s / limit_s))) if limit_s else room
    return line("  ", ("━" * full, ACCENT), ("─" * (room - full), MUTED), text)


# --- panels -------------------------------------------------------------------------------------


TOPICS = {"fault": BAD, "error": BAD, "warning": WARN, "detected": GOOD, "ended": STRONG}

OUTCOME = {"succeeded": GOOD, "interrupted": WARN}
"""Styles of how a run has ended; any other end is bad."""

_PAUSED = "paused: drive by hand, or {} (r)"

_TWO_COLUMNS = 70

_LOG_TEXT = 19
"""Where the text of a line of the log begins."""

Flag = tuple[str, str]
"""A word with a sign, and its style."""


def ended_flag(ended: Ended) -> Flag:
    """Return how a run has ended."""
    style = OUTCOME.get(ended.outcome, BAD)
    return f"■ {outcome_word(ended.outcome)}", f"{FLAG}.{style}"


def mode(snapshot: Snapshot) -> Flag:
    """Return who has the robot, in a word with a sign, and its style.

    The sign is a question mark while nothing is heard from the robot. Once a run has been stopped,
    by an operator or by its end, this says so until something is set in motion again.
    """
    word, style = _mode(snapshot)
    if snapshot.unheard_s:
        return f"? {word.partition(' ')[2]}", f"{FLAG}.{BAD}"
    if snapshot.story.stopped and word[0] in "‖◆":
        return f"■ {_stop(snapshot)}, {word.partition(' ')[2]}", f"{FLAG}.{WARN}"
    return word, style


def _stop(snapshot: Snapshot) -> str:
    """Return that the wheels were stopped, and by what if no person has stopped them."""
    banner = snapshot.story.banner
    word = outcome_word(banner.line.text.partition(": ")[0]) if banner is not None else "STOPPED"
    return word if word == "STOPPED" else f"STOPPED ({word})"


def _mode(snapshot: Snapshot) -> Flag:
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
        how: More about the backend, next to the names.
        pace: What is shown before the time; by default the backend.
    """
    scene = snapshot.scene
    word, style = flag or mode(snapshot)
    pipe = f" in {scene.loaded.pipe_name}" if scene.loaded.pipe_name else ""
    name = scene.mission or "no mission"
    more = f", {how}" if how else ""
    left = line((f" {word} ", style), " ", (name, STRONG), f" on {scene.robot.name}{pipe}{more}")
    right = f" {pace or scene.backend}  {snapshot.now_s:8.1f} s "
    return fitted(left, max(width - len(right), 0)).append(right)


def states(snapshot: Snapshot, width: int) -> list[Text]:
    """Return the state of each region with its sign and age, contacts and words.

    Also the active control, unless it is the usual one.
    """
    state, robot = snapshot.state, snapshot.scene.robot
    if state is None:
        return [line((" not known yet", MUTED))]
    change = state_change(robot, state.robot)
    labels = shortened(robot.regions)
    wide = max(map(len, labels))
    columns = 1 if width < _TWO_COLUMNS else 2
    cells = []
    for region, label, name in zip(robot.regions, labels, change.states, strict=True):
        mark, style, said = _state(snapshot, region, name, region in change.unconfirmed)
        of, why = style if style != GOOD else "", []
        cell = line((f"{mark} ", style), (f"{label:<{wide}} ", MUTED), (said, of))
        if len(cell) > width // columns and said != name:
            short = f"{name}; sent: 0" if mark == "■" else said.partition(":")[0]
            if mark == "?" and columns == 1:
                short, _, doubt = said.partition(", ")
                why = wrap(doubt, max(width - 4, 8))
            cell = line((f"{mark} ", style), (f"{label:<{wide}} ", MUTED), (short, of))
        age = f" {ago(snapshot.age_s(region))} "
        if len(cell) + len(age) <= width // columns:
            cell = fitted(cell, width // columns - len(age)).append(age, MUTED)
        cells += [cell, *(line((f"    {each}", of)) for each in why)]
    control = robot.controls[state.robot.control].name
    if control:
        cells.append(line(("◆ ", ACCENT), (f"{'Control':<{wide}} ", MUTED), (control, ACCENT)))
    if columns == 1:
        return [*cells, _contacts(snapshot), *_words(snapshot, width)]
    return in_columns([*cells, *_words(snapshot, width // 2), _contacts(snapshot)], width, 2)


def _state(snapshot: Snapshot, region: str, name: str, unconfirmed: bool) -> tuple[str, str, str]:
    """Return the sign of a region's state, its style, and what is said of it."""
    robot, state = snapshot.scene.robot, snapshot.state
    assert state is not None
    marks = {robot.regions[each.which]: each for each in state.robot.marks if each.kind == "region"}
    if not snapshot.is_shown(region):
        return "?", MUTED, f"{STALE}{name}"
    if region in marks and marks[region].command == STOPPED:
        return "■", WARN, f"commanded: {name}; sent: 0"
    if region in snapshot.doubts:
        return "?", BAD, f"{name}, {snapshot.doubts[region]}"
    return ("○", WARN, name) if unconfirmed else ("●", GOOD, name)


def _contacts(snapshot: Snapshot) -> Text:
    """Return which wall each wheel touches."""
    pose = pose_of(snapshot)
    parts: list[Part] = [("  at wall ", MUTED)]
    for number, side in enumerate(pose.touching, 1):
        at = SIDES[side] if side >= 0 else "–" if pose.live else "?"
        parts.append((f"{number}{at} ", "" if side >= 0 else MUTED))
    if pose.origin and any(side >= 0 for side in pose.touching):
        parts.append(("by command", MUTED))
    return line(*parts)


def _words(snapshot: Snapshot, width: int) -> list[Text]:
    """Return what is said from outside or of the surroundings, as far as it is known."""
    state, robot = snapshot.state, snapshot.scene.robot
    assert state is not None
    count = len(robot.regions)
    found = dict(zip(robot.vocabulary.words[count:], state.words[count:], strict=True))
    kind = found.pop("joint", None)  # mostly unknown, and there is little room
    if kind is not None:
        found["segment" if found.get("segment") == JOINT else "joint"] = kind
    style = STRONG if snapshot.live else MUTED
    cells = []
    for name, word in found.items():
        said = "–" if not word else word if snapshot.live else f"{STALE}{word}"
        cells.append(line((f" {name} ", MUTED), (f"{said}  ", style if word else MUTED)))
    return flowed(cells, width, " ")


def now(snapshot: Snapshot, width: int) -> list[Text]:
    """Return what is under way or waited for, and how long still."""
    state, ended = snapshot.state, snapshot.story.ended
    if snapshot.over:
        said = ended.message if ended is not None else "the run is over"
        style = OUTCOME.get(ended.outcome, BAD) if ended is not None else MUTED
        return [line((each, style)) for each in wrap(said, max(width, 8))]
    if state is None:
        return [line(("the backend is being opened …", MUTED))]
    lines = moving(snapshot, width)
    if snapshot.unheard_s:
        lines.append(line(("? ", BAD), "no word: mission time stands still"))
    if state.mission.paused and snapshot.scene.mission:
        left, program = snapshot.stopped_in, snapshot.scene.loaded.program
        paused = _PAUSED.format("start" if snapshot.untouched else "resume")
        lines.append(line(("‖ ", WARN), f"stopped in {left}" if left else paused))
        if left:
            lines.append(line(("  r: choose the phase to resume at", MUTED)))
        elif not (snapshot.untouched or state.mission.begun):  # a fault has led it there
            phase = program.phase_of[state.mission.pc].rpartition("/")[2]
            lines.append(line((f"  r: resumes at {phase}", MUTED)))
    lines += waiting(snapshot, width) if snapshot.scene.mission else []
    if snapshot.left:
        lines.append(line(("≈ ", MUTED), snapshot.left))
    return lines or [line((idle(snapshot), MUTED))]


def phases(snapshot: Snapshot, width: int, rows: int) -> list[Text]:
    """Return the mission's phases around the current one: done, current, not yet."""
    program, state, story = snapshot.scene.loaded.program, snapshot.state, snapshot.story
    if not snapshot.scene.mission:
        return [line(("No mission is chosen.", MUTED)), line(("Press m for the list.", MUTED))]
    current = program.phase_of[state.mission.pc] if state is not None else ""
    begun = state is not None and (state.mission.begun or state.mission.pc != program.start)
    current = current if begun else story.stopped_in_phase or current
    names = program.phases
    if len(names) > rows:  # those of missions that are called are left out, but for the current one
        names = tuple(each for each in names if current.startswith(each[: each.rfind("/") + 1]))
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
        present = begun and story.ended is None
        if name == current and present:
            mark, style = "▶" if snapshot.live else "?", STRONG
        elif current.startswith(f"{name}/") and present:
            mark, style = "▷", ""
        elif name in story.spent_s:
            mark, style = ("■", WARN) if name == story.stopped_in_phase else ("✓", GOOD)
        if mark in "▶?" and state is not None:
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
    elif snapshot.over:
        word, style = "■ closed", MUTED
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


def numbered_line(shown: NumberedLine) -> Text:
    """Return a line of the log."""
    topic, text = shown.line
    style = TOPICS.get(topic, "")
    return line((f"{shown.now_s:8.2f} ", MUTED), (f"{topic:<9} {text}", style))


def log(kept: Sequence[NumberedLine], width: int, rows: int) -> list[Text]:
    """Return the last lines of the log in so many rows, each in full."""
    shown: list[Text] = []
    for each in reversed(kept):
        if len(shown) >= rows:
            break
        first, *more = wrap(each.line.text, max(width - _LOG_TEXT, 8)) or [""]
        lines = [numbered_line(each._replace(line=each.line._replace(text=first)))]
        style = TOPICS.get(each.line.topic, "")
        shown = [*lines, *(line((" " * _LOG_TEXT + it, style)) for it in more), *shown]
    return shown[-rows:] if rows else []
