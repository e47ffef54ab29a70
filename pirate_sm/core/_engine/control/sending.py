"""Submit setpoint arrays and track whether they are accepted.

The arrays of a command are awaited: until one is accepted or refused, only the safe array may
follow it. The arrays that the loops of states send are a *stream*: the newest array replaces older
ones, a command or the safe array may overtake it at any time, and nothing waits for it.
"""

from __future__ import annotations

from math import inf, nan

from pirate_sm.core._engine.control.circumstances import Circumstances
from pirate_sm.core._engine.control.loops import Loops, after_frame, ends_with_command
from pirate_sm.core._engine.control.stages import looped_values
from pirate_sm.core._engine.deadlines import has_come
from pirate_sm.core._engine.moment import Moment
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.robot_state import Flight, Motion, Purpose, RobotState
from pirate_sm.core._engine.sensing.board_spec import BoardSpec, LinkSpec
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._model.effects import Setpoints
from pirate_sm.core._model.events import SubmitResult


def send(
    moment: Moment,
    state: RobotState,
    motion: Motion | None,
    values: Numbers,
    loops: Loops,
    purpose: Purpose,
) -> RobotState:
    """Submit an array and replace the running loops.

    Args:
        moment: The time, the robot and program, and the effects so far.
        state: The robot's state.
        motion: The command under way from now on.
        values: The array.
        loops: All loops that run from now on.
        purpose: What the array is for.
    """
    moment.emit(Setpoints(state.next_id, values))
    slots = moment.robot.slots
    seeking = [
        each.slot for each in loops if ends_with_command(each) or slots[each.slot].self_locking
    ]
    older, overtaken, since_s = state.flight, state.overtaken, moment.now_s
    if older is not None and older.purpose == "stream":
        overtaken, since_s = (*overtaken, older), older.since_s
    flight = Flight(
        state.next_id,
        values,
        purpose,
        seeking=frozenset(seeking),
        since_s=since_s if purpose == "stream" else nan,
        before=state.loops if purpose == "gate" else (),
    )
    return state._replace(
        next_id=state.next_id + 1,
        flight=flight,
        motion=motion,
        loops=loops,
        sent=True,
        overtaken=overtaken,
    )


def send_if_new(
    moment: Moment, state: RobotState, motion: Motion | None, values: Numbers, loops: Loops
) -> RobotState:
    """Submit an array of the command under way if it differs from the last one sent."""
    if values != state.latest:
        return send(moment, state, motion, values, loops, "loop")
    if motion is state.motion and loops is state.loops:
        return state
    return state._replace(motion=motion, loops=loops)


def resend(moment: Moment, state: RobotState, sensing: Sensing) -> RobotState:
    """Resend an unconfirmed array when that is due; of a stream only the newest array."""
    flight = state.flight
    if flight is None or not has_come(moment.now_s, flight.resend_at_s):
        return state
    if (newer := stream(moment, state, sensing)) is not state:
        return newer
    moment.emit(Setpoints(flight.setpoint_id, flight.values))
    return state._replace(flight=flight._replace(tries=flight.tries + 1, resend_at_s=inf))


def stream(moment: Moment, state: RobotState, sensing: Sensing) -> RobotState:
    """Submit the present duties of the loops of states, if they differ from the last array sent.

    Nothing is submitted while an array is awaited. While position loops run, the arrays of their
    command carry the duties of all loops.
    """
    if state.awaited is not None or state.seekers:
        return state
    values = looped_values(moment.robot, state, sensing)
    if values == state.latest:
        return state
    return send(moment, state, state.motion, values, state.loops, "stream")


def hear(board: BoardSpec, state: RobotState, seen: Circumstances) -> RobotState:
    """Return the robot after a frame of the board, with what its loops have learned.

    While a command's first array is pending its loops do not run yet, so the frame does not
    update them.
    """
    flight = state.flight
    if flight is not None and flight.purpose == "gate":
        return state
    loops = after_frame(board, state.loops, seen)
    return state if loops is state.loops else state._replace(loops=loops)


def overtaken_result(moment: Moment, state: RobotState, result: SubmitResult) -> RobotState:
    """Handle the result of a stream array that a newer array has overtaken."""
    older = state.overtaken
    for at, each in enumerate(older):
        if each.setpoint_id != result.setpoint_id:
            continue
        if result.status != "accepted":
            return state._replace(overtaken=older[:at] + older[at + 1 :])
        flight = state.flight and state.flight._replace(since_s=moment.now_s)
        return state._replace(
            values=each.values, seeking=each.seeking, overtaken=older[at + 1 :], flight=flight
        )
    return state


def why_unconfirmed(link: LinkSpec, state: RobotState, result: SubmitResult, now_s: float) -> str:
    """Return why the link counts as broken after a result; empty where it does not.

    Args:
        link: Limits of the link. A stream may stay unconfirmed for as long as a board may be
            silent.
        state: The robot's state before the result.
        result: The result of an array.
        now_s: The time.
    """
    flight = state.flight
    if flight is None or result.status != "unknown":
        return ""
    if flight.purpose == "stream":
        ours = {flight.setpoint_id, *(each.setpoint_id for each in state.overtaken)}
        if result.setpoint_id in ours and has_come(now_s, flight.since_s + link.silent_after_s):
            return f"the setpoints of loops were not confirmed for {link.silent_after_s:g} s"
    elif result.setpoint_id == flight.setpoint_id and flight.tries > link.resend_limit:
        return f"setpoints were not confirmed after {link.resend_limit} repeats"
    return ""
