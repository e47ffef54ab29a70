"""In what state a run has left the robot, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.robot import DECLARED, Mark, at_rest_in, confirmed_parts, verdict

if TYPE_CHECKING:
    from pirate_sm.robot.backends.serial.link.health import LinkHealth


def left_state(
    engine: Engine, state: EngineState | None, sent: tuple[float, ...], link: LinkHealth | None
) -> str:
    """Return in what state a run has left the robot: its wheels and what holds it.

    Args:
        engine: The engine of the run.
        state: The engine's state at the end; None if it has not begun.
        sent: The last array that was sent; empty if none was.
        link: How the link is; None where there is none.
    """
    robot = engine.robot
    if not sent:
        return "nothing was sent: the robot is as it was"
    if state is None:
        return "what holds the robot is not known"
    accepted = state.robot.flight is None and state.robot.values == sent
    if link is not None:  # it also knows what became of an array sent past the engine
        accepted = link.stopped and (accepted or not state.mission.ended)
    stopped = not any(sent[slot] for slot in robot.safe_zero)
    wheels = "wheels set to zero" if stopped else "the wheels may TURN: no safe array was sent"
    if not accepted:
        wheels = f"{wheels}, NOT confirmed by the robot"
    held = [
        f"{robot.parts[part]} clamped ({_by_what(engine, state, part)})"
        for part in sorted(robot.held[state.robot.configuration])
    ]
    return "; ".join([wheels, *(held or ["no part is clamped"])])


def _by_what(engine: Engine, state: EngineState, part: int) -> str:
    """Return what shows that a part is clamped, at the end and not only when it was clamped."""
    if engine.nominal:
        return "without sensors"
    robot, body = engine.robot, state.robot
    rest, mark = at_rest_in(robot, body.configuration).values, Mark("part", part, DECLARED)
    seen = verdict(robot, rest, body, mark, state.sensing.numbers, engine.program.diameter_m)
    if seen.agrees and part in confirmed_parts(robot, body):
        return "confirmed by sensors"
    proof = engine.evidence(state)[robot.parts[part]]
    if proof.source != "sensor":
        return "NOT confirmed by sensors"
    now_s = max(state.sensing.checked_s, proof.at_s)  # an answer may have come after all frames
    return f"{proof.in_words(now_s)}, NOT seen by them now"
