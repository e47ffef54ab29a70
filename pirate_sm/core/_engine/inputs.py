"""Apply the reports of backends and detectors to the engine's state."""

from __future__ import annotations

from math import nan

from pirate_sm.core._engine.control import sending
from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.control.torque_loop import RunningTorqueLoop
from pirate_sm.core._engine.mission.diverting import meet
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.resuming import reconnection
from pirate_sm.core._engine.robot import commands
from pirate_sm.core._engine.robot.robot_state import RobotState
from pirate_sm.core._engine.safety.faults import (
    STARTS_AGAIN,
    FoundFault,
    look,
    start_again,
    unsettle,
)
from pirate_sm.core._engine.sensing.conversion import forget_outdated, observe
from pirate_sm.core._engine.sensing.distance import judge
from pirate_sm.core._engine.sensing.traction import measured_outside, rolled, with_traction
from pirate_sm.core._engine.sensing.traction_memory import nothing_estimated
from pirate_sm.core._engine.state import EngineState
from pirate_sm.core._model.effects import Detected
from pirate_sm.core._model.events import (
    EVIDENCE_ENDS,
    DetectorWord,
    FaultReport,
    OutsideNumber,
    SensorFrame,
    SubmitResult,
)
from pirate_sm.core._model.fault_codes import BuiltInFault


def frame(moment: Moment, state: EngineState, event: SensorFrame) -> EngineState:
    """Apply a frame of a board to the state and handle the faults that it shows."""
    robot, body, now_s = moment.robot, state.robot, moment.now_s
    board = robot.boards.get(event.board)
    if board is None:
        return state
    sensing, reports = observe(
        robot, state.sensing, event, body.values, body.latest, now_s, sent=body.sent
    )
    if sensing.outside_until_s:
        sensing = forget_outdated(sensing, now_s)
    if board.wheels and sensing.distance.every_s > 0:
        pitch_rad = state.surveyed.reported.pitch_rad
        held, bores_m = robot.held[body.configuration], moment.program.bores_m
        sensing = judge(robot, sensing, body.values, pitch_rad, now_s, held, bores_m)
    spec = robot.traction
    if spec and board.wheels and (moment.follows_traction or sensing.sees_slip):
        sensing = rolled(spec, sensing, board, now_s)
        if board.position == spec.board:
            at, around = body.configuration, state.surveyed.reported
            sensing = with_traction(robot, spec, sensing, body.values, at, around, now_s)
    exhausted: list[FoundFault] = []
    if body.loops:
        seen = Circumstances(sensing.numbers, state.surveyed.reported.pitch_rad, now_s)
        body = sending.hear(board, body, seen)
        exhausted = _exhausted(moment, state.robot, body)
    words = state.obeyed_words(robot)
    faults, found = look(robot, state.faults, board, sensing, words, now_s)
    # Faster than replacing two fields by name; this runs for every frame.
    state = EngineState(body, sensing, state.mission, faults, *state[4:])
    for report in reports:
        state = meet(moment, state, FoundFault.reported(robot, report))
    for fault in (*found, *exhausted):
        state = meet(moment, state, fault)
    return state


def _exhausted(moment: Moment, before: RobotState, after: RobotState) -> list[FoundFault]:
    """Return a fault for each joint whose grip has just become exhausted."""
    known = {
        each.slot for each in before.loops if isinstance(each, RunningTorqueLoop) and each.exhausted
    }
    slots = moment.robot.slots
    return [
        FoundFault.built_in(
            BuiltInFault.GRIP_EXHAUSTED,
            f"{slots[each.slot].name} presses all it may, and friction may not bear the robot",
            slots[each.slot].drives,
        )
        for each in after.loops
        if isinstance(each, RunningTorqueLoop) and each.exhausted and each.slot not in known
    ]


def word(moment: Moment, state: EngineState, event: DetectorWord) -> EngineState:
    """Apply a detector's word, which stays valid for a limited time."""
    if event.word not in moment.robot.detector_words:
        moment.warn(f"the detector said '{event.word}', an unknown word")
        return state
    state = state._replace(word_until_s=moment.now_s + event.valid_for_s)
    if state.outside("detector") == event.word:
        return state
    moment.emit(Detected(event.word))
    return state.hearing(detector=event.word)


def outside_number(moment: Moment, state: EngineState, event: OutsideNumber) -> EngineState:
    """Take a number in that was measured outside; it counts for a time."""
    if event.signal not in moment.robot.outside:
        moment.warn(f"'{event.signal}' was measured outside, an unknown signal")
        return state
    index, valid_for_s = moment.robot.outside[event.signal]
    sensing, spec = state.sensing, moment.robot.traction
    numbers = list(sensing.numbers)
    numbers[index] = event.value
    traction, measured_s = sensing.traction, moment.now_s - event.age_s
    if spec and not (moment.follows_traction or sensing.sees_slip):
        traction = nothing_estimated(spec)  # what slip was seen last is of no use now
        for target in spec.targets:
            numbers[target] = nan
    traction = measured_outside(spec, traction, index, event.value, measured_s)
    others = tuple(each for each in sensing.outside_until_s if each[0] != index)
    until_s = (*others, (index, measured_s + valid_for_s))
    sensing = sensing._replace(numbers=tuple(numbers), traction=traction, outside_until_s=until_s)
    return state._replace(sensing=sensing)


def submitted(moment: Moment, state: EngineState, event: SubmitResult) -> EngineState:
    """Apply the result of an array; a rejected stop or loop array is a fault."""
    flight = state.robot.flight
    unconfirmed = sending.why_unconfirmed(moment.robot.link, state.robot, event, moment.now_s)
    robot, finished = commands.resolve(moment, state.robot, event)
    state = state.moved(moment.robot, robot)
    state = state.finished(finished)
    if unconfirmed:
        state = meet(moment, state, FoundFault.built_in(BuiltInFault.LINK_NO_ECHO, unconfirmed))
    if flight is None or event.setpoint_id != flight.setpoint_id:
        return state
    if event.status in {"rejected", "superseded"} and flight.purpose != "gate":
        # Only a command may be refused. Without any other array the state would be wrong.
        message = f"the backend has {event.status} setpoints: {event.reason or 'no reason'}"
        state = _refused(moment, state, message)
    return state


def _refused(moment: Moment, state: EngineState, message: str) -> EngineState:
    ending = state.mission.ending
    if ending is None:
        found = FoundFault.built_in(BuiltInFault.BACKEND_FAILED, message)
        return meet(moment, state, found)
    ending = ending._replace(message=f"{ending.message} ({message})")
    return state._replace(mission=state.mission._replace(ending=ending))


def fault_report(moment: Moment, state: EngineState, event: FaultReport) -> EngineState:
    """Handle a fault that a backend reports; after some faults nothing is known any more."""
    state = reconnection.lose(moment, state, event.code)
    if event.code not in STARTS_AGAIN:
        return meet(moment, state, FoundFault.reported(moment.robot, event))
    before = state
    sensing = start_again(moment.robot, state.sensing, moment.now_s, event.away_s)
    state = state._replace(sensing=sensing)
    words = state.obeyed_words(moment.robot)
    faults = unsettle(moment.robot, state.faults, state.sensing, words)
    state = state._replace(faults=faults)
    if moment.nominal or moment.alphabet < EVIDENCE_ENDS:
        return meet(moment, state, FoundFault.reported(moment.robot, event))
    state = reconnection.doubt(moment, before, state)
    state = meet(moment, state, FoundFault.reported(moment.robot, event))
    return reconnection.begin(moment, before, state, event)
