"""Decides which requests of the operator are possible now, with the engine's reasons."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.plans import why_not_from
from pirate_sm.core.engine import EngineState
from pirate_sm.core.events import GoTo, Resume
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import SwitchControl, Wait, why_not_command, why_not_on, why_not_to
from pirate_sm.core.robot import RobotSpec, RobotState, marks_after, refusal, state_change
from pirate_sm.views.console.key_bindings import CONTROLS, ways
from pirate_sm.views.showing.snapshot import Snapshot

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
    if why_not_to(program, state, program.phase_of[program.start]):
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
    reason = _unheard(snapshot) or why_not_command(robot, state, index, at_once=True)
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
    """Return the fault that makes a drive doubtful now; empty if none does, or it is no drive."""
    drives = command in ways(snapshot.scene.robot)
    return next(iter(snapshot.doubts.values()), "") if drives else ""


def phase_reason(snapshot: Snapshot, phase: str, entries: Entries | None) -> str:
    """Return why the mission cannot be handed back at the phase now; empty if it can."""
    state = snapshot.state
    if snapshot.over or state is None:
        return OVER if snapshot.over else OPENING
    obstacle = _unheard(snapshot) or why_not_to(snapshot.scene.loaded.program, state, phase)
    if obstacle:
        return obstacle
    return LOOKING if entries is None else entries.get(phase, LOOKING)


def hand_back(snapshot: Snapshot, phase: str) -> GoTo:
    """Return the event that hands the mission back there with the robot's present states."""
    assert snapshot.state is not None
    change = state_change(snapshot.scene.robot, snapshot.state.robot)
    return GoTo(phase, change.states, change.unconfirmed)


def going_on(snapshot: Snapshot) -> GoTo | Resume:
    """Return the event that starts or resumes the mission."""
    program = snapshot.scene.loaded.program
    if snapshot.untouched:
        return hand_back(snapshot, program.phase_of[program.start])
    return Resume()


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
    return why_not_on(state)


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
