"""Apply what comes from outside: reports of backends, detectors, scripts; operators' requests."""

from __future__ import annotations

from math import nan
from typing import assert_never

from pirate_sm.core._engine import start_check
from pirate_sm.core._engine.mission import flow
from pirate_sm.core._engine.mission.flow import meet
from pirate_sm.core._engine.mission.program import Program, SwitchControl
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.robot import commands, setpoint_arrays
from pirate_sm.core._engine.robot.loops import Circumstances, RunningTorqueLoop
from pirate_sm.core._engine.robot.robot_state import Finished, RobotState
from pirate_sm.core._engine.safety import STARTS_AGAIN, FoundFault, look, start_again, unsettle
from pirate_sm.core._engine.sensing.known_signals import nothing_estimated
from pirate_sm.core._engine.sensing.odometry import judge
from pirate_sm.core._engine.sensing.signal_table import forget_outdated, observe
from pirate_sm.core._engine.sensing.traction import measured_outside, rolled, with_traction
from pirate_sm.core._engine.state import OUTSIDE, EngineState
from pirate_sm.core._model.events import (
    EVIDENCE_ENDS,
    Abort,
    Answer,
    Breakpoints,
    CommandFailed,
    DetectorWord,
    EnvironmentReport,
    FaultReport,
    GoTo,
    Observation,
    OperatorCommand,
    OutsideNumber,
    Pause,
    Request,
    Resume,
    SensorFrame,
    SignalReport,
    Skip,
    Step,
    SubmitResult,
)
from pirate_sm.core._model.faults import BuiltInFault
from pirate_sm.core.effects import CommandStatus, Detected, Environment, Log

# --- backends and detectors -------------------------------------------------------------------


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
        body = setpoint_arrays.hear(board, body, seen)
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


def environment_report(moment: Moment, state: EngineState, event: EnvironmentReport) -> EngineState:
    """Take a report from outside in; what it knows counts while it is valid."""
    said = event._asdict()
    until_s = moment.now_s + said.pop("valid_for_s")
    surveyed = state.surveyed._replace(
        outside=Environment(**said), outside_until_s=until_s, due_s=moment.now_s
    )
    return state._replace(surveyed=surveyed)


def submitted(moment: Moment, state: EngineState, event: SubmitResult) -> EngineState:
    """Apply the result of an array; a rejected stop or loop array is a fault."""
    flight = state.robot.flight
    unconfirmed = setpoint_arrays.why_unconfirmed(
        moment.robot.link, state.robot, event, moment.now_s
    )
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
    state = start_check.doubt_if_lost(moment, state, event.code)
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
    state = start_check.doubt_all(moment, before, state)
    state = meet(moment, state, FoundFault.reported(moment.robot, event))
    return start_check.begin_again(moment, before, state, event)


# --- scripts instead of sensors, in runs where commands take their nominal time --------------


def signal_report(moment: Moment, state: EngineState, report: SignalReport) -> EngineState:
    """Set the signals that conditions see to those of the script; refuse that on real sensors."""
    if not moment.nominal:
        moment.warn("a script cannot replace the signals of real sensors")
        return state
    names = moment.robot.vocabulary.with_changes.numbers
    sensing = state.sensing
    numbers = list(sensing.told or sensing.numbers)
    if any(name.startswith("change(") for name, _ in report.numbers):
        numbers += [nan] * (len(names) - len(numbers))
    for name, value in report.numbers:
        if name in names:
            numbers[names.index(name)] = value
        else:
            moment.warn(f"the script says '{name}', an unknown signal")
    for name, word in report.words:
        if name in OUTSIDE:
            state = state.hearing(**{name: word})
        else:
            moment.warn(f"the script says '{name}', which no script can set")
    return state._replace(sensing=sensing._replace(told=tuple(numbers)))


def command_failed(moment: Moment, state: EngineState, event: CommandFailed) -> EngineState:
    """Let the command under way fail as by its timeout, unless its array is still in flight.

    A switch of the control fails once its array is accepted, since it is done then on paper.
    """
    body = state.robot
    if not (moment.nominal and awaits_torques(moment.program, state)):
        if not moment.nominal or body.motion is None or body.awaited is not None:
            moment.warn("no command is under way that a script could let fail")
            return state
        body = commands.fail(moment, body, event.reason)
    mission = state.mission._replace(result=Finished(False, event.reason))
    return state._replace(robot=body, mission=mission)


def awaits_torques(program: Program, state: EngineState) -> bool:
    """Whether the mission switches its control and that can fail: a joint shall bear a torque."""
    mission, body = state.mission, state.robot
    return (
        mission.begun
        and mission.result is None
        and isinstance(program.instructions[mission.pc], SwitchControl)
        and any(isinstance(each, RunningTorqueLoop) for each in body.loops)
    )


# --- the operator, for the engine and for views ----------------------------------------------


def obey(moment: Moment, state: EngineState, request: Request) -> EngineState:  # noqa: C901 - one case for each request
    """Carry out a request of the operator, or emit a warning that says why it is refused."""
    match request:
        case OperatorCommand():
            return _command(moment, state, request)
        case Observation():
            moment.emit(Log("info", f"{request.words} (operator)"))
            return state
        case Answer() | Skip() if state.mission.paused:
            answers = isinstance(request, Answer)
            what = "no answer is taken" if answers else "nothing is passed over"
            moment.warn(f"{what} while paused")
            return state
        case Answer(choice):
            return state._replace(mission=state.mission._replace(answer=choice))
        case Skip(trigger):
            return state._replace(mission=state.mission._replace(skipped=trigger))
        case Pause():
            return flow.want_pause(state._replace(mission=state.mission._replace(until="")))
        case Resume():
            return _resume(moment, state, until=request.until)
        case Step():
            return _resume(moment, state, one_step=True)
        case Breakpoints(at):
            return state._replace(mission=state.mission._replace(breakpoints=at))
        case GoTo():
            return flow.go_to(moment, state, request)
        case Abort(reason):
            return flow.end(moment, state, "interrupted", reason)
        case _:
            assert_never(request)


def _resume(
    moment: Moment, state: EngineState, *, one_step: bool = False, until: str = ""
) -> EngineState:
    """Resume the mission, past a breakpoint at its current instruction."""
    before = state.mission
    state = flow.resume(moment, state, one_step=one_step)
    if state.mission.paused:
        return state
    passes = before.passes or before.paused or before.pause_wanted
    return state._replace(mission=state.mission._replace(passes=passes, until=until))


def _command(moment: Moment, state: EngineState, event: OperatorCommand) -> EngineState:
    """Begin the command or refuse it with a reason; a command suspended by a pause ends."""
    index = moment.robot.table.command_index.get(event.command)
    if index is None:
        reason = "impossible: there is no such command"
    else:
        state = flow.lapse_unheard(moment, state)
        reason = state.why_not_command(moment.robot, index, at_once=event.at_once)
    if not 0 <= event.share <= 1:
        reason = reason or "impossible: the speed must be 0 to 100 %"
    if reason or index is None:
        moment.emit(CommandStatus(event.command, "refused", reason))
        return state
    state = flow.take_over(moment, state)
    body = state.robot
    if body.motion is not None:
        body = commands.fail(moment, body, flow.TAKEN_OVER)
    body = commands.begin(moment, body, state.sensing, index, None, "", share=event.share)
    return state._replace(robot=body)
