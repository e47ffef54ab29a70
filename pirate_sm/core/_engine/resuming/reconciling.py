"""Compare the possible states of a robot with its sensors, after a crash or unrecorded."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from itertools import compress
from math import inf, nan
from typing import Literal, NamedTuple, TypeAlias

from pirate_sm.core._engine.mission.program import Program
from pirate_sm.core._engine.moment import has_come
from pirate_sm.core._engine.records import Numbers
from pirate_sm.core._engine.resuming.hypotheses import Hypothesis, hypotheses
from pirate_sm.core._engine.robot.criteria import OF_WHEELS
from pirate_sm.core._engine.robot.declared_states import Watched, declared_in, since
from pirate_sm.core._engine.robot.evidence import Shown, kind_of, shown_by, spec_of, verdict
from pirate_sm.core._engine.robot.robot_spec import RobotSpec
from pirate_sm.core._engine.robot.robot_state import (
    DECLARED,
    DENIED,
    STOPPED,
    Mark,
    RobotState,
    at_rest_in,
    states_of,
)
from pirate_sm.core._engine.sensing.known_signals import nothing_known
from pirate_sm.core._engine.sensing.signal_table import forget_stale, observe, slots_read
from pirate_sm.core._engine.state import OUTSIDE, EngineState
from pirate_sm.core._engine.unwatched import DarkWay, changed, dark_way
from pirate_sm.core._model.events import SensorFrame

Frames: TypeAlias = Sequence[tuple[float, SensorFrame]]
"""Frames of the boards, each with the time of its arrival, s."""

Word = Literal["confirmed", "contradicted", "unknown"]


class StateVerdict(NamedTuple):
    """What the sensors show about one region's state or one part's clamp.

    Attributes:
        mark: The region or part.
        about: Its name.
        state: The name of the region's state; ``holds`` for a part.
        why: Why it is not confirmed; empty if it is.
        shown: What was compared.
    """

    mark: Mark
    about: str
    state: str
    word: Word
    why: str
    shown: tuple[Shown, ...]


class VerdictTable(NamedTuple):
    """What the sensors show about one hypothesis.

    Attributes:
        refusals: Why the mission must not go on if the robot is there.
    """

    hypothesis: Hypothesis
    verdicts: tuple[StateVerdict, ...]
    refusals: tuple[str, ...] = ()

    def having(self, word: Word) -> frozenset[str]:
        """Return the names of the regions and parts that have this verdict.

        Without the names of their states: wheels that stand confirm several of these.
        """
        return frozenset(each.about for each in self.verdicts if each.word == word)


class Reconciled(NamedTuple):
    """What looking at the robot has shown.

    Attributes:
        tables: One for each hypothesis, the recorded one first.
        chosen: The table of the hypothesis that counts; None if there is none, or a person must
            choose.
        choices: The tables among which a person must choose.
        refusals: Why the mission cannot go on, whatever a person says. Empty if it can.
        questions: What the wheels show that the motors cannot have done; a person must say
            where the robot is.
        turning: Whether a wheel turns: send the safe array, then look again.
        way: How far the robot has driven meanwhile.
        numbers: The signals at the end of the look.
    """

    tables: tuple[VerdictTable, ...]
    chosen: VerdictTable | None
    choices: tuple[VerdictTable, ...]
    refusals: tuple[str, ...]
    questions: tuple[str, ...]
    turning: bool
    way: DarkWay
    numbers: Numbers

    def is_as(self, before: Reconciled, robot: RobotSpec) -> bool:
        """Return whether the robot is still as an earlier look has shown it."""
        words = [
            [(each.mark, each.word) for table in seen.tables for each in table.verdicts]
            for seen in (self, before)
        ]
        rolled_m = [
            abs((self.numbers[wheel.angle] - before.numbers[wheel.angle]) * wheel.metres_per_rad)
            for wheel in robot.wheels
        ]
        rolled = any(way_m > robot.sight.dark.agree_m for way_m in rolled_m)
        return words[0] == words[1] and self.refusals == before.refusals and not rolled

    def shown_instead(self, robot: RobotSpec) -> tuple[VerdictTable, ...]:
        """Return the configurations that the sensors show instead of the declared one.

        The first table is of the declared one, as in :func:`adoptable`. Of those without a
        contradiction the ones count of which most is confirmed. What the sensors cannot tell apart
        is taken as declared; otherwise a person must choose.

        Returns:
            The configurations. None if nothing contradicts the declared one, if a wheel turns, or
            if everything is contradicted.
        """
        declared = self.tables[0]
        if self.turning or not declared.having("contradicted"):
            return ()
        states = robot.table.configurations
        wanted = states[declared.hypothesis.body.configuration]

        def kept(table: VerdictTable) -> int:
            names = states[table.hypothesis.body.configuration]
            return sum(name == other for name, other in zip(names, wanted, strict=True))

        possible = [
            (table.having("confirmed"), kept(table), table)
            for table in self.tables
            if not table.having("contradicted") and not table.refusals
        ]
        return tuple(
            table
            for shown, count, table in possible
            if not any(shown < other or (shown == other and count < n) for other, n, _ in possible)
        )


def reconcile(
    robot: RobotSpec,
    program: Program,
    last: EngineState,
    frames: Frames,
    now_s: float,
    driven_s: float,
    maybe: int | None = None,
    found: Sequence[Hypothesis] = (),
) -> Reconciled:
    """Return what the boards have shown, and which hypothesis counts.

    Args:
        robot: The robot.
        program: The mission.
        last: The engine's last recorded state.
        frames: What the boards have reported while nothing but a stop was written, in order of
            time. A second is enough; ``for`` of the profile's ``seen`` is the least.
        now_s: The end of the look, by the clock of the frames.
        driven_s: How long the wheels may have been driven since ``last``; infinite if nobody knows.
        maybe: As for :func:`.hypotheses.hypotheses`.
        found: Where the robot may be, if that is not what follows from the recording.
    """
    found = found or hypotheses(robot, program, last, maybe)
    read = slots_read(robot)
    courses = dict[Numbers, _Course]()
    tables = []
    for each in found:
        seen_as = tuple(each.body.values[slot] for slot in read)
        if seen_as not in courses:
            courses[seen_as] = _Course(robot, program, each.body, frames, now_s)
        tables.append(courses[seen_as].table(last, each))
    numbers = next(iter(courses.values())).steps[-1][1]
    drove = any(last.robot.latest[slot] for slot in robot.safe_zero)
    driven_s = driven_s if drove or any(each.drives for each in found) else 0.0
    way = dark_way(robot, last, numbers, driven_s)
    refusals = list(_silent(robot, frames, now_s))
    if last.robot.motion is None and not driven_s:
        refusals += changed(robot, last.sensing.numbers, found[0].body.marks, numbers)
    chosen, choices, none = _choose(robot, tables)
    return Reconciled(
        tuple(tables),
        chosen,
        choices,
        (*refusals, *(chosen.refusals if chosen else ()), *none),
        (way.moved,) if way.moved else (),
        turning(robot, numbers),
        way,
        numbers,
    )


def turning(robot: RobotSpec, numbers: Numbers) -> bool:
    """Return whether a wheel turns that would stand still if it were stopped."""
    return any(
        sign.contradicts(numbers)
        for states in robot.sight.states
        for spec in states.values()
        if spec.kind == "stopped"
        for sign in spec.signs
    )


# --- a robot that nobody has recorded ---------------------------------------------------------


def adoptable(robot: RobotSpec, declared: int) -> tuple[Hypothesis, ...]:
    """Return the configurations in which a robot may stand, the declared one first.

    Those that drive wheels are left out: wheels that stand show none of them.
    """
    others = (each for each in range(len(robot.table.configurations)) if not robot.driven[each])
    every = dict.fromkeys((declared, *others))
    return tuple(Hypothesis("adopted", declared_in(robot, each)) for each in every)


# --- inside -----------------------------------------------------------------------------------


class _Course:
    """What the boards show of a robot with the setpoints of a hypothesis, and what that says.

    Where setpoints differ that no signal depends on, the signals are the same: hypotheses share
    their course, and what they declare alike is judged once.

    Attributes:
        steps: The signals after each frame and at the end of the look; old ones are unknown.
    """

    def __init__(
        self, robot: RobotSpec, program: Program, body: RobotState, frames: Frames, now_s: float
    ) -> None:
        self._robot, self._now_s, self._diameter_m = robot, now_s, program.diameter_m
        self._watched: dict[Hashable, Watched] = {}
        began_s = frames[0][0] if frames else now_s
        sensing = nothing_known(robot)
        sensing = sensing._replace(heard_s=(began_s,) * len(robot.boards), checked_s=began_s)
        self.steps: list[tuple[float, Numbers]] = []
        for at_s, frame in frames:
            sensing, _ = observe(robot, sensing, frame, body.values, body.values, at_s, sent=False)
            self.steps.append((at_s, forget_stale(robot, sensing, at_s).numbers))
        self.steps.append((now_s, forget_stale(robot, sensing, now_s).numbers))

    def table(self, last: EngineState, hypothesis: Hypothesis) -> VerdictTable:
        """Return what the sensors show about a hypothesis.

        A verdict counts if it has lasted, to the end of the look, as long as the profile asks for.
        What is unknown agrees with nothing. What the recording had not confirmed is not
        contradicted: its command was under way.
        """
        robot, now_s, body = self._robot, self._now_s, hypothesis.body
        names, numbers = states_of(robot, body), self.steps[-1][1]
        judged = []
        for mark in sorted(mark for mark in body.marks if mark.command != STOPPED):
            it = self._judged(body, mark)
            confirmed = it.is_confirmed(now_s)
            denied = mark.command == DECLARED and it.is_denied(now_s)
            word: Word = "confirmed" if confirmed else "contradicted" if denied else "unknown"
            why = "" if confirmed else it.told if denied else _why_unknown(robot, names, mark)
            if mark.kind == "region":
                about, state = robot.regions[mark.which], names[mark.which]
            else:
                about, state = robot.parts[mark.which], "holds"
            spec = spec_of(robot, names, mark)
            shown = shown_by(robot, spec, last.sensing.numbers, numbers, self._diameter_m)
            judged.append(StateVerdict(mark, about, state, word, why, shown))
        hypothesis = hypothesis._replace(body=_redeclared(last, body, judged))
        refusals = tuple(dict.fromkeys(self._refusals(names)))
        return VerdictTable(hypothesis, tuple(judged), refusals)

    def _judged(self, body: RobotState, mark: Mark) -> Watched:
        """Return what the sensors have shown about a mark until the end of the look."""
        robot, setpoints = self._robot, at_rest_in(self._robot, body.configuration).values
        state = states_of(robot, body)[mark.which] if mark.kind == "region" else ""
        joints = (joint for part in robot.sight.parts if part for joint in part.joints)
        of_joints = tuple(setpoints[joint.slot] for joint in joints)
        alike = mark, state, robot.held[body.configuration], of_joints
        if alike not in self._watched:
            it = Watched(mark)
            for at_s, numbers in self.steps:
                shown = verdict(robot, setpoints, body, mark, numbers, self._diameter_m)
                it = it.after(shown, at_s)
            self._watched[alike] = it
        return self._watched[alike]

    def _refusals(self, names: tuple[str, ...]) -> Iterator[str]:
        """Yield the faults with which no mission may continue, in these states."""
        words = (*names, *(None for _ in OUTSIDE))
        for rule in self._robot.faults:
            if not rule.catchable:
                since_s = nan
                for at_s, numbers in self.steps:
                    since_s = since(since_s, rule.when.evaluate(numbers, words) is True, at_s)
                if has_come(self._now_s, since_s + rule.held_s):
                    yield f"{rule.code}: {rule.message}"


def _redeclared(last: EngineState, body: RobotState, judged: Sequence[StateVerdict]) -> RobotState:
    """Return the robot with what the sensors show now declared, although they had not before."""
    shown = {
        each.mark
        for each in judged
        if each.word == "confirmed" and each.mark not in last.robot.marks
    }
    again = {mark._replace(command=DECLARED) for mark in shown}
    return body._replace(marks=(body.marks - shown) | again)


def _why_unknown(robot: RobotSpec, names: tuple[str, ...], mark: Mark) -> str:
    if mark.command >= 0:
        return f"{robot.commands[mark.command].name} was not done when the recording ends"
    if mark.command == DENIED:
        return "it is contradicted in the recording already"
    match kind_of(robot, names, mark):
        case "":
            return "no sensor shows it"
        case "accepted":
            return "nothing measures it; the first accepted array that holds it confirms it"
        case "turning":
            return "the wheels are taken to stand; a command must drive them again"
        case _:
            return "the sensors show it neither so nor otherwise for long enough"


def _silent(robot: RobotSpec, frames: Frames, now_s: float) -> Iterator[str]:
    """Yield the boards that do not report at the end of the look."""
    heard = {frame.board: at_s for at_s, frame in frames}
    for number, board in robot.boards.items():
        if not now_s - heard.get(number, -inf) < robot.link.stale_after_s:
            yield f"board {number} ({board.module}) does not report"


def _choose(
    robot: RobotSpec, tables: Sequence[VerdictTable]
) -> tuple[VerdictTable | None, tuple[VerdictTable, ...], tuple[str, ...]]:
    """Return the table that counts, or those among which a person chooses, or why there is none.

    The one without a contradiction counts. Of several the one whose confirmations include those
    of the others, and are more. Wheels are stopped before the look, so what they do says nothing:
    of tables that differ in nothing else the first counts.
    """
    rolling = [
        any(spec.kind in OF_WHEELS for spec in states.values()) for states in robot.sight.states
    ]
    wheels = set(compress(robot.regions, rolling))
    differing: dict[frozenset[tuple[str, str]], VerdictTable] = {}
    for table in tables:
        if not table.having("contradicted"):
            states = {(each.about, each.state) for each in table.verdicts}
            differing.setdefault(frozenset(s for s in states if s[0] not in wheels), table)
    possible = tuple(differing.values())
    for each in possible:
        others = [other.having("confirmed") - wheels for other in possible if other is not each]
        if all(each.having("confirmed") - wheels > other for other in others):
            return each, (), ()
    if possible:
        return None, possible, ()
    reasons = (
        f"{each.about} was recorded as {each.state}, but {each.why}"
        for table in tables
        for each in table.verdicts
        if each.word == "contradicted"
    )
    return None, (), tuple(dict.fromkeys(reasons))
