"""Keep what has shown the state of each region and the clamp of each part, and when."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.core._engine.evidence import NOTHING, Evidence
from pirate_sm.core._engine.robot.criteria import AcceptedSpec
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import DECLARED, Mark, RobotState, states_of
from pirate_sm.core._engine.robot.sensor_verdict import spec_of

Proofs = tuple[Evidence, ...]
"""The evidence of each region's state, then of each part's clamp."""


def proofs_at_start(robot: RobotSpec, body: RobotState, now: Evidence) -> Proofs:
    """Return the evidence at the start of a run: what a person has declared, or is assumed."""
    said = now._replace(source="person"), now._replace(source="assumption")
    return tuple(
        (said[doubt is None] if state else NOTHING) for _, state, doubt in _believed(robot, body)
    )


def proofs_after(
    robot: RobotSpec, before: RobotState, after: RobotState, proofs: Proofs, now: Evidence
) -> Proofs:
    """Return the evidence after a step.

    Args:
        robot: The robot.
        before: The robot's state before the step.
        after: Its state after the step.
        proofs: The evidence before the step.
        now: The evidence of what sensors have shown in this step.
    """
    found = list(proofs)
    both = zip(_believed(robot, before), _believed(robot, after), strict=True)
    for at, ((_, earlier, doubted), (declared, state, doubt)) in enumerate(both):
        if (earlier, doubted) == (state, doubt):
            continue
        if not state or (doubt is not None and doubt.command < DECLARED):
            found[at] = NOTHING
        elif doubt is None:
            motion = before.motion
            given = declared._replace(command=motion.command) if motion else declared
            echoed = _proof(robot, after, doubted or given) == "echo"
            found[at] = now._replace(source="echo") if echoed else now
        elif doubt.command >= 0:
            found[at] = now._replace(source="echo")
        # What is declared, or stopped, was known before: by older evidence.
    return tuple(found)


def _proof(robot: RobotSpec, body: RobotState, cause: Mark) -> str:
    """Return what confirms a state: by its command's criterion, or by that for what is declared."""
    if cause.command >= 0:
        return robot.commands[cause.command].proof
    spec = spec_of(robot, states_of(robot, body), cause)
    return "echo" if isinstance(spec, AcceptedSpec) else "sensor"


def _believed(robot: RobotSpec, body: RobotState) -> Iterator[tuple[Mark, str, Mark | None]]:
    """Yield each region and part as one declared, with its state, and its mark if it has one."""
    marks = {(mark.kind, mark.which): mark for mark in sorted(body.marks)}
    held = robot.held[body.configuration]
    for region, name in enumerate(states_of(robot, body)):
        yield Mark("region", region, DECLARED), name, marks.get(("region", region))
    for part in range(len(robot.parts)):
        holds = "holds" if part in held else ""
        yield Mark("part", part, DECLARED), holds, marks.get(("part", part))
