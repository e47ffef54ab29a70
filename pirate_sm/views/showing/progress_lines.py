"""Lines about what is under way: the command, the wait, and how long each may still take."""

from __future__ import annotations

from math import isinf, isnan

from rich.text import Text

from pirate_sm.core.program import SwitchControl, Wait
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import ACCENT, BAD, GOOD, MUTED, WARN, line


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
