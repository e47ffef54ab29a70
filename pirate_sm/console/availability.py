"""Tell what the operator may ask for now, and why not the rest, in the engine's words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from pirate_sm.checking.plans.phase_entry import why_not_from
from pirate_sm.console.key_bindings import CONTROLS
from pirate_sm.engine.mission.operator import why_not_command
from pirate_sm.engine.mission.pausing import why_not_on, why_not_to
from pirate_sm.engine.mission.program import SwitchControl, Wait
from pirate_sm.engine.robot.robot_state import RobotState, state_change
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.model.events import GoTo, Resume
from pirate_sm.showing.snapshot import Scene, Snapshot

OVER = "the run is over"
OPENING = "the backend is being opened"
NO_MISSION = "no mission is chosen: press m"
LOOKING = "being looked at"

_PLACE = re.compile(r"\((?P<file>[^()]+):(?P<line>\d+):\d+\)")

Entries = Mapping[str, str]
"""Per phase why the mission cannot be handed back there, as far as that has been looked at."""


class Control(NamedTuple):
    """Something that the operator can do with a mission; ``reason`` is empty when he can."""

    name: str
    key: str
    label: str
    reason: str


class Situation(NamedTuple):
    """All that decides where a mission can be handed back."""

    mission: int
    configuration: int
    unconfirmed: tuple[str, ...]


def situation_of(snapshot: Snapshot) -> Situation | None:
    """Return the situation while nothing is under way; None where nothing can be handed back."""
    state = snapshot.state
    program = snapshot.scene.loaded.program
    if state is None or not snapshot.scene.mission:
        return None
    if why_not_to(program, state, program.phase_of[program.start]):
        return None
    change = state_change(snapshot.scene.robot, state.robot)
    return Situation(id(snapshot.scene), state.robot.configuration, change.unconfirmed)


def look_at_entries(scene: Scene, body: RobotState) -> Entries:
    """Return why the mission cannot start at each phase; takes some milliseconds each."""
    document, phases = Path(scene.loaded.documents[0].name), scene.loaded.program.phases
    return {
        phase: without_path(why_not_from(scene.loaded, phase, body), document) for phase in phases
    }


def without_path(reason: str, document: Path) -> str:
    """Return a reason with each ``(file:line:column)`` as a line, and its mission if another's.

    Args:
        reason: What the engine or the check says.
        document: The file of the mission at hand.
    """

    def shorter(place: re.Match[str]) -> str:
        file = Path(place["file"])
        return f"(line {place['line']}{'' if file == document else f' of {file.stem}'})"

    return _PLACE.sub(shorter, reason)


def command_reason(snapshot: Snapshot, command: str) -> str:
    """Return why the engine would refuse the command now; empty: it would not."""
    if snapshot.over:
        return OVER
    if snapshot.state is None:
        return OPENING
    index = snapshot.scene.robot.table.command_index[command]
    return why_not_command(snapshot.scene.robot, snapshot.state, index)


def phase_reason(snapshot: Snapshot, phase: str, entries: Entries | None) -> str:
    """Return why the mission cannot be handed back at the phase now; empty: it can."""
    state = snapshot.state
    if snapshot.over or state is None:
        return OVER if snapshot.over else OPENING
    obstacle = why_not_to(snapshot.scene.loaded.program, state, phase)
    if obstacle:
        return obstacle
    return LOOKING if entries is None else entries.get(phase, LOOKING)


def untouched(snapshot: Snapshot) -> bool:
    """Return whether the mission has not begun."""
    state = snapshot.state
    start = snapshot.scene.loaded.program.start
    return state is not None and state.mission.pc == start and not state.mission.begun


def hand_back(snapshot: Snapshot, phase: str) -> GoTo:
    """Return the event that hands the mission back there, as the robot is in this snapshot."""
    assert snapshot.state is not None
    change = state_change(snapshot.scene.robot, snapshot.state.robot)
    return GoTo(phase, change.states, change.unconfirmed)


def going_on(snapshot: Snapshot) -> GoTo | Resume:
    """Return the event that starts the mission, or lets it go on."""
    program = snapshot.scene.loaded.program
    if untouched(snapshot):
        return hand_back(snapshot, program.phase_of[program.start])
    return Resume()


def controls(snapshot: Snapshot, entries: Entries | None) -> tuple[Control, ...]:
    """Return everything that can be done with a mission, in the order of its keys."""
    fresh = untouched(snapshot)
    return (
        _control("go", "Start" if fresh else "Resume", _why_not_go(snapshot, entries)),
        _control("pause", "Pause", _why_not_pause(snapshot)),
        _control("step", "Next step", _why_not_step(snapshot, entries)),
        _control("skip", "Skip the wait", _why_not_skip(snapshot)),
        _control("hand_back", "Hand back at …", _general(snapshot) or _why_not_paused(snapshot)),
        _control("abort", "Abort", _why_not_abort(snapshot)),
    )


def _control(name: str, label: str, reason: str) -> Control:
    return Control(name, CONTROLS[name], label, reason)


def _general(snapshot: Snapshot) -> str:
    if snapshot.over:
        return OVER
    if snapshot.state is None:
        return OPENING
    return "" if snapshot.scene.mission else NO_MISSION


def _why_not_paused(snapshot: Snapshot) -> str:
    assert snapshot.state is not None
    return "" if snapshot.state.mission.paused else "pause the mission first"


def _why_not_go(snapshot: Snapshot, entries: Entries | None) -> str:
    general = _general(snapshot)
    if general or snapshot.state is None:
        return general
    if not snapshot.state.mission.paused:
        return "it is running"
    if untouched(snapshot):
        program = snapshot.scene.loaded.program
        return phase_reason(snapshot, program.phase_of[program.start], entries)
    return why_not_on(snapshot.state)


def _why_not_step(snapshot: Snapshot, entries: Entries | None) -> str:
    state = snapshot.state
    if not _general(snapshot) and state is not None and not state.mission.paused:
        return ""  # it pauses after the step under way
    return _why_not_go(snapshot, entries)


def _why_not_pause(snapshot: Snapshot) -> str:
    general = _general(snapshot)
    if general or snapshot.state is None:
        return general
    mission = snapshot.state.mission
    return "it is paused" if mission.paused or mission.pause_wanted else ""


def _why_not_skip(snapshot: Snapshot) -> str:
    general = _general(snapshot)
    if general or snapshot.state is None:
        return general
    mission = snapshot.state.mission
    if mission.paused:
        return "nothing is passed over while paused"
    it = snapshot.scene.loaded.program.instructions[mission.pc]
    waits = isinstance(it, Wait | SwitchControl)
    return "" if waits and mission.begun else "nothing is waited for"


def _why_not_abort(snapshot: Snapshot) -> str:
    general = _general(snapshot)
    if general:
        return general
    return "it has not begun" if untouched(snapshot) else ""


def why_not_mission(snapshot: Snapshot, loaded: LoadedMission) -> str:
    """Return why the mission cannot be taken up with the robot as it is; empty: it can."""
    scene, state = snapshot.scene, snapshot.state
    if loaded.loaded_robot.folder != scene.loaded.loaded_robot.folder:
        return f"it is for another robot, {loaded.robot.name}"
    held = state is not None and bool(scene.robot.held[state.robot.configuration])
    if held and loaded.robot.polarity != scene.robot.polarity:
        return f"it wants {loaded.robot.polarity} polarity, and the robot holds on in the other"
    return ""
