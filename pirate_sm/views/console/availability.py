"""The keys of the console, which requests are possible now, and the engine's reasons against them.

A key means one thing, so a key that answers a question never moves the robot. A letter means the
same in both cases, so Caps Lock does no harm.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from string import ascii_lowercase
from textwrap import wrap
from typing import NamedTuple

from rich.text import Text

from pirate_sm.checking.plans import why_not_from
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import GoTo, Resume
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import SwitchControl, Wait
from pirate_sm.core.robot import (
    RobotSpec,
    RobotState,
    at_rest_in,
    marks_after,
    refusal,
    state_change,
)
from pirate_sm.views.showing.effect_lines import shortened
from pirate_sm.views.showing.snapshot import Snapshot
from pirate_sm.views.showing.text_styles import MUTED, STRONG, line

# --- keys ---------------------------------------------------------------------------------------


LEAVE, MISSIONS = "q", "m"
YES, NO = "y", "n"
CONTROLS: Mapping[str, str] = {
    "go": "r",
    "pause": "p",
    "step": ".",
    "skip": "k",
    "hand_back": "h",
    "abort": "x",
}
"""Keys of the controls of a mission."""

ANSWERS = frozenset([YES, NO, LEAVE, "escape", "enter", *"123456789"])
"""Keys that answer a question; no command, control or word of a detector has one of them."""

RESERVED = frozenset([*ANSWERS, MISSIONS, *CONTROLS.values()])
"""Keys that no command and no word of a detector gets."""

_SPARE_KEYS = ",;'[]"
"""Keys for names when there are no more letters."""


def letters_for(names: Sequence[str]) -> dict[str, str]:
    """Return a lower-case letter for each name, in order, as far as there are letters and signs.

    The first that is free of: the capitals of the name, its other letters, the rest of the
    alphabet from its end, some signs.
    """
    free = [key for key in ascii_lowercase + _SPARE_KEYS if key not in RESERVED]
    found: dict[str, str] = {}
    for name in names:
        capitals = [letter.lower() for letter in name if letter.isupper()]
        wanted = (*capitals, *name.lower(), *reversed(ascii_lowercase), *_SPARE_KEYS)
        letter = next((each for each in wanted if each in free), None)
        if letter is None:
            break
        free.remove(letter)
        found[name] = letter
    return found


def both_cases(letter: str) -> str:
    """Return the keys of a letter in both cases, for a binding; of a sign its name."""
    if letter.isalpha():
        return f"{letter},{letter.upper()}"
    return unicodedata.name(letter).lower().replace("-", "_").replace(" ", "_")


def arrows_for(robot: RobotSpec) -> dict[str, str]:
    """Return the command of each arrow key: up and down drive, left and right brake."""
    found: dict[str, str] = {}
    for command in robot.commands:
        if command.done.kind == "stopped":
            found.setdefault("left", command.name)
            found.setdefault("right", command.name)
    for name, way in ways(robot).items():
        found.setdefault("up" if way > 0 else "down", name)
    return found


@lru_cache(maxsize=8)
def ways(robot: RobotSpec) -> dict[str, int]:
    """Return the commands that drive: 1 forward, -1 backward."""
    found: dict[str, int] = {}
    for index, command in enumerate(robot.commands):
        for here in range(len(robot.table.configurations)):
            target = robot.table.follow(here, index)
            if robot.driven[target].keys() - robot.driven[here].keys():
                travel = robot.travel(at_rest_in(robot, target).values)
                if travel:
                    found.setdefault(command.name, travel)
    return found


# --- requests -----------------------------------------------------------------------------------


OVER = "the session is over: q leaves"
OPENING = "the backend is being opened"
NO_MISSION = "no mission is chosen: press m"
LOOKING = "being looked at"
UNHEARD = "no word from the robot"
PAUSE_FIRST = f"pause the mission first: {CONTROLS['pause']}"

_MOST_BEFORE = 2
"""The most commands that are named as what to give before another one."""

_PLACE = re.compile(r"\((?P<file>[^()]+):(?P<line>\d+):\d+\)")

Entries = Mapping[str, str]
"""Per checked phase, why the mission cannot be handed back there; empty if it can."""


class RunControl(NamedTuple):
    """A control of a mission; ``reason`` is empty if it is available."""

    name: str
    key: str
    label: str
    reason: str


class HandBackSituation(NamedTuple):
    """Everything that decides where a mission can be handed back."""

    mission: int
    configuration: int
    unconfirmed: tuple[str, ...]


def situation_of(snapshot: Snapshot) -> HandBackSituation | None:
    """Return the situation while no command is under way; None if there can be no hand-back."""
    state = snapshot.state
    program = snapshot.scene.loaded.program
    if state is None or not snapshot.scene.mission or snapshot.unheard_s:
        return None
    if state.why_not_go_to(program, program.phase_of[program.start]):
        return None
    change = state_change(snapshot.scene.robot, state.robot)
    return HandBackSituation(id(snapshot.scene), state.robot.configuration, change.unconfirmed)


def look_at_entries(loaded: LoadedMission, body: RobotState) -> Entries:
    """Return why the mission cannot start at each phase; takes up to 0.1 s per phase."""
    document, phases = Path(loaded.documents[0].name), loaded.program.phases
    return {phase: without_path(why_not_from(loaded, phase, body), document) for phase in phases}


def without_path(reason: str, document: Path) -> str:
    """Return a reason with each ``(file:line:column)`` shortened to a line and a foreign mission.

    Args:
        reason: The reason of the engine or the check.
        document: The file of the current mission.
    """

    def shorter(place: re.Match[str]) -> str:
        file = Path(place["file"])
        return f"(line {place['line']}{'' if file == document else f' of {file.stem}'})"

    return _PLACE.sub(shorter, reason)


def command_reason(snapshot: Snapshot, command: str) -> str:
    """Return why the engine would refuse the command now; empty if it would not.

    The commands that help come first, since the engine's own reason names states.
    """
    state, robot = snapshot.state, snapshot.scene.robot
    if snapshot.over or state is None:
        return OVER if snapshot.over else OPENING
    index = robot.table.command_index[command]
    reason = _unheard(snapshot) or state.why_not_command(robot, index, at_once=True)
    kind, _, why = reason.partition(": ")
    if kind == "impossible" and reason == refusal(robot, state.robot, index):
        before = commands_before(robot, state.robot, index)
        return f"{kind}: {before} first ({why})" if before else reason
    return reason


def commands_before(robot: RobotSpec, body: RobotState, command: int) -> str:
    """Return the commands after which this one is not refused any more; empty if none help.

    Each counts as done. One that lets go of the pipe is never named.
    """
    names = [each.name for each in robot.commands]
    found: list[tuple[str, RobotState]] = [("", body)]
    for _ in range(_MOST_BEFORE):
        found = [
            (f"{said}, {names[at]}" if said else names[at], _done(robot, here, at))
            for said, here in found
            for at, each in enumerate(robot.commands)
            if not (each.lets_go or refusal(robot, here, at))
        ]
        if ways := [said for said, here in found if not refusal(robot, here, command)]:
            return ways[0] if "," in ways[0] else " or ".join(ways)
    return ""


def _done(robot: RobotSpec, body: RobotState, command: int) -> RobotState:
    """Return the commanded state once the command is done."""
    here, marks = body.configuration, body.marks
    left = (it for it in marks_after(robot, here, marks, command) if it.command != command)
    return body._replace(configuration=robot.table.follow(here, command), marks=frozenset(left))


def drive_doubt(snapshot: Snapshot, command: str) -> str:
    """Return the fault that makes a drive doubtful now; empty without one, or without a drive."""
    drives = command in ways(snapshot.scene.robot)
    return next(iter(snapshot.doubts.values()), "") if drives else ""


def phase_reason(snapshot: Snapshot, phase: str, entries: Entries | None) -> str:
    """Return why the mission cannot be handed back at the phase now; empty if it can."""
    state = snapshot.state
    if snapshot.over or state is None:
        return OVER if snapshot.over else OPENING
    obstacle = _unheard(snapshot) or state.why_not_go_to(snapshot.scene.loaded.program, phase)
    if obstacle:
        return obstacle
    return LOOKING if entries is None else entries.get(phase, LOOKING)


def hand_back(robot: RobotSpec, body: RobotState, phase: str) -> GoTo:
    """Return the event that hands the mission back at a phase, in the robot's states."""
    change = state_change(robot, body)
    return GoTo(phase, change.states, change.unconfirmed)


def going_on(snapshot: Snapshot) -> GoTo | Resume:
    """Return the event that starts or resumes the mission."""
    program = snapshot.scene.loaded.program
    if snapshot.state is None or not snapshot.untouched:
        return Resume()
    return hand_back(snapshot.scene.robot, snapshot.state.robot, program.phase_of[program.start])


def controls(snapshot: Snapshot, entries: Entries | None) -> tuple[RunControl, ...]:
    """Return everything that can be done with a mission, in the order of its keys."""
    general, state = _general(snapshot), snapshot.state
    chooses = snapshot.stopped_in
    start = "Run: start" if snapshot.untouched and not chooses else "Run: resume"
    if general or state is None:
        reasons = (general,) * len(CONTROLS)
    else:
        reasons = (
            _unheard(snapshot) if chooses else _why_not_go(snapshot, state, entries),
            "it is paused" if state.mission.paused or state.mission.pause_wanted else "",
            _why_not_step(snapshot, state, entries),
            _why_not_skip(snapshot, state),
            PAUSE_FIRST if not state.mission.paused else _unheard(snapshot),
            "it has not begun" if snapshot.untouched else "",
        )
    labels = (start, "Pause", "Next step", "Skip the wait", "Hand back at …", "Abort")
    return tuple(map(RunControl, CONTROLS, CONTROLS.values(), labels, reasons))


def _general(snapshot: Snapshot) -> str:
    if snapshot.over:
        return OVER
    if snapshot.state is None:
        return OPENING
    return "" if snapshot.scene.mission else NO_MISSION


def _unheard(snapshot: Snapshot) -> str:
    """Return that nothing is heard: what is asked for would be done when the robot comes back."""
    return UNHEARD if snapshot.unheard_s else ""


def _why_not_go(snapshot: Snapshot, state: EngineState, entries: Entries | None) -> str:
    if not state.mission.paused:
        return "it is running"
    if reason := _unheard(snapshot):
        return reason
    if snapshot.untouched:
        program = snapshot.scene.loaded.program
        return phase_reason(snapshot, program.phase_of[program.start], entries)
    return state.why_not_resume()


def _why_not_step(snapshot: Snapshot, state: EngineState, entries: Entries | None) -> str:
    if not state.mission.paused:
        return ""  # it pauses after the step under way
    if snapshot.stopped_in:
        return f"choose a phase first: {CONTROLS['go']}"
    return _why_not_go(snapshot, state, entries)


def _why_not_skip(snapshot: Snapshot, state: EngineState) -> str:
    if state.mission.paused:
        return "nothing is skipped while paused"
    it = snapshot.scene.loaded.program.instructions[state.mission.pc]
    waits = isinstance(it, Wait | SwitchControl)
    return "" if waits and state.mission.begun else "nothing is waited for"


def why_not_mission(snapshot: Snapshot, loaded: LoadedMission) -> str:
    """Return why the mission cannot be chosen with the robot's present states; empty if it can."""
    scene, state = snapshot.scene, snapshot.state
    if loaded.loaded_robot.folder != scene.loaded.loaded_robot.folder:
        return f"it is for another robot, {loaded.robot.name}"
    held = state is not None and bool(scene.robot.held[state.robot.configuration])
    if held and loaded.robot.polarity != scene.robot.polarity:
        return f"it wants {loaded.robot.polarity} polarity, and the robot holds on in the other"
    return ""


# --- reasons, as they are shown -----------------------------------------------------------------


_SIGNS = {"unneeded": "=", "impossible": "✕"}


class Request(NamedTuple):
    """A request of the operator, and why it is not available; the reason is empty if it is."""

    key: str
    reason: str


def sign_of(reason: str) -> str:
    """Return ``=`` if the state is reached already, ``✕`` if it cannot be."""
    return _SIGNS.get(reason.partition(": ")[0], "✕")


def obstacles(
    asked: Mapping[str, Sequence[Request]], robot: RobotSpec, width: int, rows: int
) -> list[Text]:
    """Return every reason in as many lines as there is room; reached states come last.

    Args:
        asked: All requests, by the name that is shown if one reason holds for all.
        robot: The robot, whose regions are shown by their short names.
        width: Width of a line.
        rows: Number of lines.
    """
    short = {
        name: [it._replace(reason=_shortened(it.reason, robot)) for it in each]
        for name, each in asked.items()
    }
    found = sorted(_grouped(short).items(), key=lambda each: each[0][0] == "=")
    heads = [f"{reason[0]} {keys}  " for reason, keys in found]
    texts = [head + reason[2:] for head, (reason, _) in zip(heads, found, strict=True)]
    lines = []
    for head, shown in zip(heads, _fitting(texts, width, rows), strict=False):
        first, *more = shown
        lines.append(line((first[: len(head)], STRONG), (first[len(head) :], MUTED)))
        lines += [line((each, MUTED)) for each in more]
    return lines if found else [line(("everything can be asked for", MUTED))]


def _grouped(asked: Mapping[str, Sequence[Request]]) -> dict[str, str]:
    """Return the keys of each reason."""
    found: dict[str, list[str]] = {}
    for name, each in asked.items():
        reasons = {key: reason for key, reason in each if reason}
        if len(reasons) == len(each) > 1 and len(set(reasons.values())) == 1:
            found.setdefault(each[0].reason, []).append(name if len(asked) > 1 else "all")
            continue
        for key, reason in reasons.items():
            found.setdefault(reason, []).append(key)
    return {reason: " ".join(keys) for reason, keys in found.items()}


def _shortened(reason: str, robot: RobotSpec) -> str:
    """Return the sign of a reason, and its text without what does not fit."""
    if not reason:
        return ""
    kind, _, rest = reason.partition(": ")
    said = (rest if kind in _SIGNS else reason).replace("it needs ", "needs ", 1)
    before, first, _ = said.partition(" first (")
    said = f"{before} first" if first else said
    for region, label in zip(robot.regions, shortened(robot.regions), strict=True):
        said = said.replace(region, label)
    return f"{sign_of(reason)} {said}"


def _fitting(texts: Sequence[str], width: int, rows: int) -> list[list[str]]:
    """Wrap each text; while there are too many lines, drop the last one of the longest text."""
    most = [len(_wrapped(text, width, rows)) for text in texts]
    while sum(most) > rows and max(most) > 1:
        most[most.index(max(most))] -= 1
    return [_wrapped(text, width, count) for text, count in zip(texts, most, strict=True)][:rows]


def _wrapped(text: str, width: int, most: int) -> list[str]:
    return wrap(
        text, max(width, 8), subsequent_indent="  ", max_lines=max(most, 1), placeholder=" …"
    )
