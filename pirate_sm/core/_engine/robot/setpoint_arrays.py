"""Setpoint arrays: what the stages of commands and the running loops write, and its submission.

A command with a posture first brings the robot to the posture, in the stage ``POSTURE``. The
stages of the states that it leads to follow.

The arrays of a command are awaited: until one is accepted or refused, only the safe array may
follow it. The arrays that the loops of states send are a *stream*: the newest array replaces older
ones, a command or the safe array may overtake it at any time, and nothing waits for it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isnan, nan

from pirate_sm.core._engine.moment import Moment, has_come
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.robot.actuation_spec import StageSpec
from pirate_sm.core._engine.robot.criteria import CriterionSpec, JointsArrived
from pirate_sm.core._engine.robot.duty_cycles import quantised
from pirate_sm.core._engine.robot.loops import (
    Circumstances,
    Loop,
    Loops,
    RunningPositionLoop,
    RunningTorqueLoop,
    RunningVelocityLoop,
    WheelTorqueLoop,
    begun,
    ends_with_command,
    loops_after,
)
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    POSTURE,
    RESTORING,
    STOPPED,
    Flight,
    Mark,
    Motion,
    Purpose,
    RobotState,
    known_values,
    posture_bounds,
    posture_of,
    states_of,
)
from pirate_sm.core._engine.sensing.board_spec import BoardSpec, LinkSpec
from pirate_sm.core._engine.sensing.known_signals import Sensing
from pirate_sm.core._model.events import SubmitResult
from pirate_sm.core.effects import Setpoints

# --- what a stage writes, and whether it has been reached -------------------------------------


def stage_array(
    robot: RobotSpec,
    state: RobotState,
    motion: Motion,
    sensing: Sensing,
    regions: tuple[int, ...],
    stage: int,
) -> tuple[Numbers, Loops]:
    """Return the array and the loops of one stage of the regions' states.

    A loop of a state continues where the stage does not write its slot. A posture that depends on
    an unknown angle changes nothing.
    """
    target = robot.table.configurations[motion.target]
    values = list(known_values(state.latest, sensing.numbers, robot))
    loops = {each.slot: each for each in state.loops if not ends_with_command(each)}
    posture = posture_of(robot, motion) if stage == POSTURE else None
    if posture is not None:
        if not motion.blind:
            _write(robot, sensing, posture.writes, values, loops)
        return tuple(values), tuple(loops.values())
    for region in regions:
        stages = state.stages(robot, region, target[region])
        writes = _slowed(robot, stages[min(stage, len(stages) - 1)], motion.share)
        _write(robot, sensing, writes, values, loops)
    return tuple(values), tuple(loops.values())


def followed(robot: RobotSpec, state: RobotState, motion: Motion, sensing: Sensing) -> RobotState:
    """Return the state with the angles that its position loops begin at and go to, as known now.

    A joint that a posture moves may open the apex whose angle the posture names.
    """
    if (known := _known_origin(state, motion, sensing)) is not motion:
        state = state._replace(motion=known)
    posture = posture_of(robot, motion) if motion.stage == POSTURE else None
    if posture is None:
        return state
    shares = {write.slot: write for write in posture.writes if write.share_of >= 0}
    loops = list(state.loops)
    for at, loop in enumerate(loops):
        if write := shares.get(loop.slot):
            loops[at] = begun(write, robot.slots[loop.slot], sensing.numbers, loop) or loop
    return state if tuple(loops) == state.loops else state._replace(loops=tuple(loops))


def switched_array(
    robot: RobotSpec, state: RobotState, sensing: Sensing, control: int
) -> tuple[Numbers, Loops]:
    """Return the array and the loops that actuate the present states by another control.

    Only slots are written to which the two controls write something else. Wheels that were stopped
    from outside their state stay stopped, and a joint that a command has brought to an angle stays
    there: commands alone drive and seek. Wheels keep to the speed that an operator has chosen. A
    joint is kept at its torque again if a pause or a fault has stopped its loop.
    """
    values = list(known_values(state.latest, sensing.numbers, robot))
    loops = {each.slot: each for each in state.loops}
    after = state._replace(control=control)
    for region, name in enumerate(states_of(robot, state)):
        if Mark("region", region, STOPPED) in state.marks:
            continue
        before = state.stages(robot, region, name)[-1]
        stage = after.stages(robot, region, name)[-1]
        changed = tuple(
            write._replace(how="set", value=0.0) if write.how == "seek" else write
            for write in stage
            if write not in before or (write.how == "bear" and _let_go(robot, write.slot, loops))
        )
        share = _share_in_force(robot, before, values, loops)
        _write(robot, sensing, _slowed(robot, changed, share), values, loops)
    return tuple(values), tuple(loops.values())


def _share_in_force(
    robot: RobotSpec, stage: StageSpec, values: Sequence[float], loops: Mapping[int, Loop]
) -> float:
    """Return the share, 0 to 1, that wheels now have of what the stage writes to them.

    It is less than 1 while an operator drives by hand at a lower speed.
    """
    driven = (it for it in stage if it.slot in robot.safe_zero and it.value)
    shares = [_asked(loops.get(it.slot), values[it.slot]) / it.value for it in driven]
    return max(0.0, min(1.0, max(shares, default=1.0)))


def _asked(loop: Loop | None, value: float) -> float:
    """Return what a wheel is asked for: the target of its loop, else its value."""
    match loop:
        case RunningVelocityLoop(target_rad_s=target) | WheelTorqueLoop(target_nm=target):
            return target
        case _:
            return value


def _let_go(robot: RobotSpec, slot: int, loops: Mapping[int, Loop]) -> bool:
    """Return whether a joint's torque loop should run and does not."""
    return robot.slots[slot].held_torque is not None and slot not in loops


def unsettled(state: RobotState, sensing: Sensing) -> list[int]:
    """Return the slots whose joint does not bear the torque that its torque loop asks for."""
    loops = [each for each in state.loops if isinstance(each, RunningTorqueLoop)]
    return [each.slot for each in loops if not each.settled(sensing.numbers)]


def unknown_angle(robot: RobotSpec, stage: StageSpec, sensing: Sensing) -> str:
    """Return which unknown signal the stage's angles depend on, as a reason; empty if none."""
    for write in stage:
        if write.share_of >= 0 and isnan(sensing.numbers[write.share_of]):
            name = robot.vocabulary.numbers[write.share_of]
            return f"{name} is unknown, which the angle for {robot.slots[write.slot].name} needs"
    return ""


def is_done(
    robot: RobotSpec, state: RobotState, motion: Motion, done: CriterionSpec, sensing: Sensing
) -> bool:
    """Whether the stage in force is done; a posture also needs every joint at its angle."""
    if motion.blind or not done.holds(sensing.numbers, state.values, state.loops):
        return False
    return all(each.holds(sensing.numbers) for each in posture_bounds(robot, state, motion))


def stage_origin(state: RobotState, stage: int, sensing: Sensing) -> Numbers:
    """Return the signals when a stage began: now, or in the first try of a repeated command."""
    tried = state.tried
    return tried.origin if tried is not None and tried.stage == stage else sensing.numbers


def _known_origin(state: RobotState, motion: Motion, sensing: Sensing) -> Motion:
    """Return the motion with the first known angle of each joint whose board was silent before."""
    origin, numbers = list(motion.origin), sensing.numbers
    for loop in state.seekers if origin else ():
        if isnan(origin[loop.angle]):
            origin[loop.angle] = numbers[loop.angle]
    return motion if tuple(origin) == motion.origin else motion._replace(origin=tuple(origin))


def unmoved_loops(
    state: RobotState, motion: Motion, done: CriterionSpec, sensing: Sensing
) -> tuple[RunningPositionLoop, ...]:
    """Return the position loops if none of their joints has moved: no wall has stopped them.

    A command that restores what a run had before it was cut off, and one that repeats a stage
    which an earlier try has passed, finds its joints moved already.
    """
    passed = state.tried is not None and motion.stage < state.tried.stage
    asked = () if passed or motion.place == RESTORING else done.asked(JointsArrived)
    unmoved = asked and all(
        loop.unmoved(sensing.numbers, motion.origin, asked[0].moved_rad) for loop in state.seekers
    )
    return state.seekers if unmoved else ()


def pushed_harder(state: RobotState, unmoved: Loops) -> Loops:
    """Return the running loops, of which these push with all that they may."""
    return tuple(
        each.harder() if isinstance(each, RunningPositionLoop) and each in unmoved else each
        for each in state.loops
    )


def looped_values(robot: RobotSpec, state: RobotState, sensing: Sensing) -> Numbers:
    """Return the accepted values with the present duty of each loop."""
    values = list(state.values)
    for loop in state.loops:
        resolution = robot.slots[loop.slot].resolution
        values[loop.slot] = quantised(loop.duty(sensing.numbers, sensing.loss), resolution)
    return tuple(values)


def without_loops(state: RobotState) -> Numbers:
    """Return the newest values with zero for every slot that a position loop has driven."""
    driven = state.seeking.difference(
        each.slot for each in state.loops if not ends_with_command(each)
    )
    if not driven:
        return state.latest
    return tuple(0.0 if slot in driven else value for slot, value in enumerate(state.latest))


def _slowed(robot: RobotSpec, stage: StageSpec, share: float) -> StageSpec:
    """Return the stage with this share of what it writes to wheels."""
    if share == 1.0:
        return stage
    slowed = robot.safe_zero
    return tuple(it._replace(value=it.value * share) if it.slot in slowed else it for it in stage)


def _write(
    robot: RobotSpec,
    sensing: Sensing,
    stage: StageSpec,
    values: list[float],
    loops: dict[int, Loop],
) -> None:
    for write in stage:
        slot = robot.slots[write.slot]
        if write.how == "set":
            values[write.slot] = write.value
            loops.pop(write.slot, None)
        elif loop := begun(write, slot, sensing.numbers, loops.get(write.slot)):
            loops[write.slot] = loop
            values[write.slot] = quantised(
                loop.duty(sensing.numbers, sensing.loss), slot.resolution
            )


# --- submission -------------------------------------------------------------------------------


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
    loops = loops_after(board, state.loops, seen)
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
