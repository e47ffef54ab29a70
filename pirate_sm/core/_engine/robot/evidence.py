"""What has shown something, and when: evidence, and that of each state and clamp.

Evidence is the source, the time and the connection. That of a signal of a board is the board's last
report; nothing is stored for it. Only what outlives a report has evidence of its own. The age is
computed when it is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isnan, nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import DECLARED, Mark, RobotState, states_of
from pirate_sm.core._engine.robot.state_verdicts import kind_of

Source: TypeAlias = Literal["sensor", "echo", "person", "assumption", "nothing"]
"""What has shown something. An echo shows that an array has arrived, never what it has moved."""


SHOWN: Mapping[Source, str] = {
    "sensor": "shown by sensors",
    "echo": "setpoints confirmed",
    "person": "declared",
    "assumption": "assumed",
    "nothing": "shown by nothing",
}
"""How each source has shown something, for people."""


class Evidence(NamedTuple):
    """The evidence of one state, signal or place.

    Attributes:
        at_s: When it was shown, by the engine's clock; NaN if nothing has shown it.
        connection: In which connection, see :attr:`.Sensing.connection`.
    """

    source: Source
    at_s: float
    connection: int

    def age_s(self, now_s: float) -> float:
        """Return how old it is, s; NaN if nothing has shown it."""
        return now_s - self.at_s

    def in_words(self, now_s: float) -> str:
        """Return it for people, with its age."""
        ago = "" if isnan(self.at_s) else f" {self.age_s(now_s):.1f} s ago"
        return f"{SHOWN[self.source]}{ago}"


NOTHING = Evidence("nothing", nan, 0)
"""Nothing has shown it."""


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
    kind = kind_of(robot, states_of(robot, body), cause)
    return "echo" if kind == "accepted" else "sensor"


def _believed(robot: RobotSpec, body: RobotState) -> Iterator[tuple[Mark, str, Mark | None]]:
    """Yield each region and part as one declared, with its state, and its mark if it has one."""
    marks = {(mark.kind, mark.which): mark for mark in sorted(body.marks)}
    held = robot.held[body.configuration]
    for region, name in enumerate(states_of(robot, body)):
        yield Mark("region", region, DECLARED), name, marks.get(("region", region))
    for part in range(len(robot.parts)):
        holds = "holds" if part in held else ""
        yield Mark("part", part, DECLARED), holds, marks.get(("part", part))
