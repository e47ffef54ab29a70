"""The words of the console, panel by panel: snapshots in, styled lines out."""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf, isnan

from textual.content import Content

from pirate_sm.console.pose import SIDES, pose_of
from pirate_sm.console.reasons import choices
from pirate_sm.console.snapshot import Snapshot
from pirate_sm.engine.program import Wait
from pirate_sm.engine.robot_state import state_change
from pirate_sm.showing.memory import Told
from pirate_sm.showing.telling import shortened
from pirate_sm.showing.visible import visible

MUTED = "$foreground 55%"
GOOD, WARN, BAD = "$text-success", "$text-warning", "$text-error"

TOPICS = {"fault": BAD, "error": BAD, "warning": WARN, "detected": GOOD, "ended": "bold"}

_TWO_COLUMNS = 70

Part = str | tuple[str, str]


def line(*parts: Part) -> Content:
    """One line; control characters from files are written out."""
    return Content.assemble(
        *(visible(each) if isinstance(each, str) else (visible(each[0]), each[1]) for each in parts)
    )


def mode(snapshot: Snapshot) -> tuple[str, str]:
    """Who has the robot, in a word with a sign, and its style."""
    state = snapshot.state
    if snapshot.over:
        return "■ OVER", "bold reverse $text-error"
    if state is None:
        return "… OPENING", "bold reverse"
    if state.mission.ending is not None or state.mission.ended:
        return "■ ENDING", "bold reverse $text-warning"
    if not snapshot.scene.mission:
        return "◆ BY HAND", "bold reverse $text-accent"
    if state.mission.paused:
        return "‖ PAUSED", "bold reverse $text-warning"
    return "▶ RUNNING", "bold reverse $text-success"


def header(snapshot: Snapshot, width: int) -> Content:
    """Who has the robot, which mission, robot, pipe and backend, and what time it is."""
    scene = snapshot.scene
    word, style = mode(snapshot)
    pipe = f" in {scene.loaded.pipe_name}" if scene.loaded.pipe_name else ""
    name = scene.mission or "no mission"
    left = line((f" {word} ", style), " ", (name, "bold"), f" on {scene.robot.name}{pipe}")
    right = f"{scene.backend}  {snapshot.now_s:8.1f} s "
    room = max(width - len(right), 0)
    return Content.assemble(left.truncate(room, ellipsis=True).pad_right(room - len(left)), right)


def alarm(snapshot: Snapshot, seen: int) -> Content | None:
    """Return how the last mission ended, else the newest thing that is wrong.

    Either stays until the operator has seen it; None: there is nothing.
    """
    banner, told = snapshot.story.banner, snapshot.story.alarm
    trouble = snapshot.link.trouble if snapshot.link else ""
    if trouble and snapshot.link:
        return line(f" ⚠ link: {trouble}, for {snapshot.link.silent_s:.1f} s ")
    if banner is not None and banner.number > seen:
        outcome, _, why = banner.line.text.partition(": ")
        word = "STOPPED" if outcome == "interrupted" else outcome.upper()
        return line(f" ■ {banner.now_s:.1f} s  {word}: {why}   (Esc: seen) ")
    if told is None or told.number <= seen:
        return None
    topic, text = told.line
    return line(f" ⚠ {told.now_s:.1f} s  {topic}: {text}   (Esc: seen) ")


def shows_success(snapshot: Snapshot, seen: int) -> bool:
    """Return whether the bar says that a mission has succeeded."""
    banner, link = snapshot.story.banner, snapshot.link
    if banner is None or banner.number <= seen or (link is not None and link.trouble):
        return False
    return banner.line.text.startswith("succeeded")


def states(snapshot: Snapshot, width: int) -> list[Content]:
    """The state of each region, with an open mark where it is not confirmed; contacts; words."""
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
        text = f"{name} ?" if open_ else name
        cells.append(
            line((f"{mark} ", style), (f"{label:<{wide}} ", MUTED), (text, style if open_ else ""))
        )
    if width < _TWO_COLUMNS:
        return [*cells, _contacts(snapshot), _words(snapshot)]
    return _in_columns([*cells, _words(snapshot), _contacts(snapshot)], width, 2)


def _in_columns(cells: Sequence[Content], width: int, count: int) -> list[Content]:
    room = width // count
    rows = -(-len(cells) // count)
    return [
        Content("").join(
            [each.truncate(room, ellipsis=True).pad_right(max(room - len(each), 0))
             for each in cells[row::rows]]
        )
        for row in range(rows)
    ]  # fmt: skip


def _contacts(snapshot: Snapshot) -> Content:
    """Which wall each wheel touches."""
    pose = pose_of(snapshot)
    parts: list[Part] = [("  at wall ", MUTED)]
    for number, side in enumerate(pose.touching, 1):
        at = SIDES[side] if side >= 0 else "–"
        parts.append((f"{number}{at} ", "" if side >= 0 else MUTED))
    if pose.origin and any(side >= 0 for side in pose.touching):
        parts.append(("by command", MUTED))
    return line(*parts)


def _words(snapshot: Snapshot) -> Content:
    """What is said from outside, as far as it is known."""
    state, robot = snapshot.state, snapshot.scene.robot
    assert state is not None
    count = len(robot.regions)
    parts: list[Part] = ["  "]
    for name, word in zip(robot.vocabulary.words[count:], state.words[count:], strict=True):
        parts += [(f"{name} ", MUTED), (f"{word or '–'}   ", "bold" if word else MUTED)]
    return line(*parts)


def now(snapshot: Snapshot, width: int) -> list[Content]:
    """What is under way or waited for, and how long still."""
    state = snapshot.state
    if state is None:
        return [line(("the backend is being opened …", MUTED))]
    ended = snapshot.story.ended
    if snapshot.over and ended is not None:
        return [line((f"{ended.outcome}: {ended.message}", BAD)), line("Press q to leave.")]
    lines = _moving(snapshot, width)
    if state.mission.paused and snapshot.scene.mission:
        lines.append(line(("‖ ", WARN), "paused: drive by hand, or let it go on"))
    return lines + (_waiting(snapshot, width) if snapshot.scene.mission else []) or [
        line((_idle(snapshot), MUTED))
    ]


def _idle(snapshot: Snapshot) -> str:
    """What the robot does while no command is under way."""
    state, robot = snapshot.state, snapshot.scene.robot
    if state is None or not any(state.robot.values[wheel.slot] for wheel in robot.wheels):
        return "nothing is under way"
    way = {1: "driving forward", -1: "driving backward"}.get(robot.travel(state.robot.values))
    return way or "wheels are driven"


def _moving(snapshot: Snapshot, width: int) -> list[Content]:
    state = snapshot.state
    motion = state.robot.motion if state is not None else None
    if state is None or motion is None:
        return []
    name = snapshot.scene.robot.commands[motion.command].name
    if isnan(motion.accepted_s):
        return [line(("▶ ", GOOD), f"{name}: sent, not yet accepted")]
    spent_s = state.mission.motion_clock(snapshot.now_s) - motion.accepted_s
    limit_s = motion.deadline_s - motion.accepted_s
    return [line(("▶ ", GOOD), f"{name}: until it is done"), bar(spent_s, limit_s, width)]


def _waiting(snapshot: Snapshot, width: int) -> list[Content]:
    state = snapshot.state
    if state is None or not state.mission.begun:
        return []
    here = snapshot.scene.loaded.program.instructions[state.mission.pc]
    if not isinstance(here, Wait):
        return []
    lines = [
        line(("○ ", WARN), f"{each.text} ", (f"→ {each.go_name}", MUTED)) for each in here.triggers
    ]
    spent_s = state.mission.clock(snapshot.now_s) - state.mission.armed_s
    return [*lines, bar(spent_s, here.within_s, width)]


def bar(spent_s: float, limit_s: float, width: int) -> Content:
    """How much of a time has gone, and how much is left."""
    if isinf(limit_s) or isnan(limit_s):
        return line((f"  {spent_s:.1f} s so far", MUTED))
    text = f" {max(limit_s - spent_s, 0.0):.1f} s left"
    room = max(width - len(text) - 2, 4)
    full = round(room * min(1.0, max(0.0, spent_s / limit_s))) if limit_s else room
    return line("  ", ("━" * full, "$accent"), ("─" * (room - full), MUTED), text)


def phases(snapshot: Snapshot, width: int, rows: int) -> list[Content]:
    """The mission's phases around the present one: done, current, not yet."""
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
        if name == current:
            mark, style = "▶", "bold"
        elif current.startswith(f"{name}/"):
            mark, style = "▷", ""
        elif name in story.spent_s:
            mark, style = "✓", GOOD
        if name == current and state is not None:
            own += program.round_note(state.mission.pc)
        room = max(width - len(time) - 3, 4)
        lines.append(line((f"{mark} {own[:room]:<{room}} {time}", style)))
    return lines


def link(snapshot: Snapshot) -> list[Content]:
    """How the link is."""
    health = snapshot.link
    if health is None:
        kind = {"sim": "a simulator has no link", "trace": "a trace has no link"}
        return [line((kind.get(snapshot.scene.backend, "not connected yet"), MUTED))]
    share = health.repeated / health.written if health.written else 0.0
    lossy = share > 0.05
    word, style = ("● good", GOOD) if not lossy else ("◐ lossy", WARN)
    if health.trouble:
        word, style = "○ silent", BAD
    trip = "–" if isnan(health.round_trip_s) else f"{health.round_trip_s * 1000:.0f} ms"
    return [
        line((word, style), (health.trouble and f": {health.trouble}", style)),
        line(("echo after ", MUTED), trip, ("   repeated ", MUTED), f"{share:.0%}"),
        line(("frames ", MUTED), f"{health.received}", ("  damaged ", MUTED), f"{health.damaged}",
             ("  lost bytes ", MUTED), f"{health.dropped_bytes}"),
    ]  # fmt: skip


def question(snapshot: Snapshot) -> Content | None:
    """What the operator is asked, with the keys that answer; None while nothing is."""
    asked, offered = choices(snapshot)
    if not offered:
        return None
    keys: list[Part] = []
    for number, choice in enumerate(offered, 1):
        keys += [(f" {number} ", "reverse"), f" {choice}   "]
    return line((f" ? {asked}  ", "bold"), *keys)


def told_line(told: Told) -> Content:
    """A line of the log."""
    topic, text = told.line
    style = TOPICS.get(topic, "")
    return line((f"{told.now_s:8.2f} ", MUTED), (f"{topic:<9} {text}", style))
