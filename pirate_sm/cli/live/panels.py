"""The parts of the view, each as lines of text of a given width."""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf, isnan

from rich.text import Text

from pirate_sm.cli.asking import Operator
from pirate_sm.cli.lines import headline
from pirate_sm.cli.live.gauges import Gauge
from pirate_sm.cli.situation import Situation
from pirate_sm.detectors.keys import WordKeys
from pirate_sm.engine.robot import RobotSpec
from pirate_sm.showing.memory import Memory
from pirate_sm.showing.telling import setpoint, shortened

OUTCOME = {
    "succeeded": "bold green",
    "failed": "bold red",
    "interrupted": "bold yellow",
    "fault": "bold red",
}
_TOPIC = {"fault": "red", "error": "red", "warning": "yellow", "state": "cyan", "detected": "green"}

CELL = 20
"""Least width of a gauge."""


def header(situation: Situation, memory: Memory, speed: str, width: int) -> Text:
    """Mission, robot, pipe and backend, and what time it is."""
    outcome = memory.ended.outcome if memory.ended else speed
    right = f" {outcome}  {situation.now_s:7.2f} s "
    left = Text(f" {headline(situation)}")
    left.truncate(max(width - len(right), 0), overflow="ellipsis", pad=True)
    line = Text(f"{left.plain}{right}", no_wrap=True, end="")
    line.stylize(f"reverse {OUTCOME[memory.ended.outcome] if memory.ended else 'bold'}")
    return line


def title(text: str, width: int) -> Text:
    """A heading that fills the line."""
    return Text(f"─ {text} {'─' * max(width - len(text) - 3, 0)}", "bright_black", end="")


def phases(situation: Situation, memory: Memory, rows: int) -> list[Text]:
    """The mission's phases around the present one: done, current, not yet."""
    names = situation.prepared.loaded.program.phases
    current, since_s = memory.phase
    at = names.index(current) if current in names else 0
    first = max(0, min(at - rows // 2, len(names) - rows))
    lines = []
    for name in names[first : first + rows]:
        depth, own = name.count("/"), name.rpartition("/")[2]
        if current.startswith(f"{name}/") and memory.ended is None:
            lines.append(Text(f"▶ {'  ' * depth}{own}"))
            continue
        if name == current and memory.ended is None:
            mark, style, spent_s = "▶", "bold", situation.now_s - since_s
            spent_s += memory.spent_s.get(name, 0.0)
            if situation.state is not None:
                own += situation.prepared.loaded.program.round_note(situation.state.mission.pc)
        elif name in memory.spent_s:
            mark, style, spent_s = "✓", "green", memory.spent_s[name]
        else:
            lines.append(Text(f"· {'  ' * depth}{own}", "bright_black"))
            continue
        lines.append(Text(f"{mark} {'  ' * depth}{own}  {spent_s:.1f} s", style))
    return lines


def waiting(
    situation: Situation,
    memory: Memory,
    operator: Operator | None,
    words: WordKeys | None,
    width: int,
) -> list[Text]:
    """What the mission waits for, and how much longer it will."""
    if memory.ended:
        return [Text(memory.ended.message, OUTCOME[memory.ended.outcome])]
    lines = [Text(words.offered, "yellow")] if words else []
    if operator and operator.choices:
        lines.append(Text(operator.question, "bold yellow"))
        offered = (f"[{n}] {choice}" for n, choice in enumerate(operator.choices, 1))
        lines.append(Text("  ".join(offered), "yellow"))
    if memory.wait:
        armed, since_s = memory.wait
        lines += [Text(f"○ {condition}") for condition in armed.conditions]
        lines.append(_left(situation.now_s, since_s, armed.deadline_s, width))
    elif (state := situation.state) is not None and state.robot.motion is not None:
        motion = state.robot.motion
        name = situation.robot.commands[motion.command].name
        if isnan(motion.accepted_s):
            lines.append(Text(f"{name}: sent, not yet accepted"))
        else:
            lines.append(Text(f"{name}: until it is done"))
            now_s = state.mission.motion_clock(situation.now_s)
            lines.append(_left(now_s, motion.accepted_s, motion.deadline_s, width))
    return lines


def _left(now_s: float, since_s: float, deadline_s: float, width: int) -> Text:
    if isinf(deadline_s) or isnan(deadline_s):
        return Text(f"{now_s - since_s:.1f} s so far", "bright_black")
    left_s = max(deadline_s - now_s, 0.0)
    text = f" {left_s:.1f} s left"
    room = max(width - len(text), 0)
    filled = round(room * min(1.0, (now_s - since_s) / max(deadline_s - since_s, 1e-9)))
    bar = Text().append("━" * filled, "cyan")
    bar.append("━" * (room - filled), "bright_black")
    return bar.append(text)


def words(situation: Situation) -> Text:
    """What is said from outside, as far as it is known."""
    if (state := situation.state) is None:
        return Text()
    regions = len(situation.robot.regions)
    names = situation.robot.vocabulary.words[regions:]
    line = Text("  ")
    for name, word in zip(names, state.words[regions:], strict=True):
        line.append(f"{name} ", "bright_black").append(f"{word or '–'}  ", "green" if word else "")
    return line


def states(robot: RobotSpec, memory: Memory) -> list[Text]:
    """The state of each region; an open mark where it is not confirmed."""
    if memory.states is None:
        return []
    labels = shortened(robot.regions)
    wide = max(len(label) for label in labels)
    lines = []
    for region, label, name in zip(robot.regions, labels, memory.states.states, strict=True):
        open_ = region in memory.states.unconfirmed
        line = Text().append("○ " if open_ else "● ", "yellow" if open_ else "green")
        line.append(f"{label:<{wide}} ", "bright_black").append(name, "yellow" if open_ else "")
        lines.append(line)
    return lines


def sensors(situation: Situation, chosen: Sequence[Gauge], width: int) -> list[Text]:
    """Key signals in as many columns as there is room for."""
    signals = situation.signals()
    cells = [(gauge.label, gauge.read(signals)) for gauge in chosen]
    across = sensor_columns(width)
    lines = []
    for start in range(0, len(cells), across):
        line = Text()
        for label, value in cells[start : start + across]:
            room = width // across - 1
            cell = Text().append(f"{label} ", "bright_black").append(value)
            cell.truncate(room, overflow="ellipsis", pad=True)
            line.append_text(cell).append(" ")
        lines.append(line)
    return lines


def sensor_columns(width: int) -> int:
    """How many gauges stand side by side."""
    return max(1, width // CELL)


def setpoints(robot: RobotSpec, memory: Memory, rows: int) -> list[Text]:
    """Every slot with what would be sent to it; what the last array changed stands out."""
    wide = max(len(slot.name) for slot in robot.slots)
    cells = []
    for index, (slot, value) in enumerate(zip(robot.slots, memory.setpoints, strict=True)):
        style = "bold yellow" if index in memory.changed else ("" if value else "bright_black")
        cells.append(Text(f"{slot.name:<{wide}} {setpoint(slot, value):>7}  ", style))
    down = min(rows, len(cells)) or 1
    lines = [Text() for _ in range(down)]
    for index, cell in enumerate(cells):
        lines[index % down].append_text(cell)
    return lines


def events(memory: Memory, rows: int) -> list[Text]:
    """The last lines of what happened, the newest last."""
    recent = list(memory.recent)[-rows:] if rows > 0 else []
    lines = []
    for _, now_s, (topic, text) in recent:
        line = Text().append(f"{now_s:8.2f} ", "bright_black")
        lines.append(line.append(f"{topic:<9} {text}", _TOPIC.get(topic)))
    return lines
