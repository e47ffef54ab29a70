"""Explore breadth-first everything that can happen to a mission, with the engine that runs it.

Two states of the engine count as equal if mission and robot can only continue in the same way.
Times and array numbers are ignored, and of a wait only the conditions that have become true count.
Each state is first found by the smallest number of events.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from math import inf, isfinite, isnan, nan
from typing import Any, Final, NamedTuple

from pirate_sm.checking.exploring.asking_program import Oracle
from pirate_sm.checking.exploring.conditions import (
    NOWHERE,
    Conditions,
    Fact,
    StepAnswers,
    TooManyQuestionsError,
    Trigger,
)
from pirate_sm.checking.exploring.exploration import (
    BEGINS,
    Exploration,
    Explored,
    ExploredState,
    ExploredStep,
    index_exploration,
)
from pirate_sm.checking.exploring.possible_events import Moves, PossibleEvent
from pirate_sm.checking.exploring.signal_ranges import ranges
from pirate_sm.core.effects import Effect, Setpoints, StateChange, TriggerFired, WakeAt
from pirate_sm.core.engine import Engine, EngineState, has_come
from pirate_sm.core.events import Tick
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import BranchKey, Do, Program, Raise, Require, Say, TriggerSpec, Wait
from pirate_sm.core.robot import RobotSpec, RobotState

# --- sensors that alternate ----------------------------------------------------------------------
# The exploration distinguishes states of a wait by which conditions have become true, not by when.
# It therefore misses a wait that continues because first one condition breaks and then another,
# such as ``known(x)`` and ``not known(x)``, each held for 2 s, with ``within`` 3 s. `lasting`
# finds such outcomes: sensors may change at any time and any number of times.


LEAST_RIVALS = 2
"""Smallest number of conditions that can alternate; the exploration covers fewer."""


def lasting(
    wait: Wait, state: EngineState, conditions: Conditions
) -> Iterator[tuple[EngineState, float]]:
    """Yield states just before an outcome of the wait, each with the time of the outcome.

    In each of them at most one condition has been true all the time, and no other condition has
    been true for long enough.

    Args:
        wait: What waits.
        state: The state in which the wait has just begun.
        conditions: What can be true together.
    """
    limit_s = min([wait.within_s, *(t.after_s for t in wait.triggers if t.after_s is not None)])
    for chosen in (-1, *(n for n, each in enumerate(wait.triggers) if _is_held(each))):
        after_s = limit_s if chosen < 0 else wait.triggers[chosen].held_s
        if not isfinite(after_s) or after_s > limit_s:
            continue
        rivals = [
            each
            for number, each in enumerate(wait.triggers)
            if _is_held(each)
            and number != chosen
            and (each.held_s, number) < (after_s, len(wait.triggers) if chosen < 0 else chosen)
        ]
        if len(rivals) < LEAST_RIVALS or not _can_last(wait, chosen, rivals, state, conditions):
            continue
        armed_s = state.mission.armed_s
        since = tuple(armed_s if n == chosen else nan for n in range(len(wait.triggers)))
        yield state._replace(mission=state.mission._replace(since=since)), armed_s + after_s


def _is_held(trigger: TriggerSpec) -> bool:
    return trigger.condition is not None and trigger.held_s > 0


def _can_last(
    wait: Wait, chosen: int, rivals: list[TriggerSpec], state: EngineState, conditions: Conditions
) -> bool:
    """Return whether each rival can break while the chosen condition holds and nothing fires."""
    facts: list[Fact] = [
        (each.condition.tree, False)
        for each in wait.triggers
        if each.condition is not None and each.held_s == 0
    ]
    held = wait.triggers[chosen].condition if chosen >= 0 else None
    if held is not None:
        facts.append((held.tree, True))
    return all(
        conditions.ask((*facts, (each.condition.tree, False)), state.words).possible
        for each in rivals
        if each.condition is not None
    )


# --- the exploration -----------------------------------------------------------------------------


MOST_NODES = 50_000

MOST_WORK = 100_000
"""Limit of the work of one exploration: steps of the engine with their questions and results;
about seven seconds."""

_EFFECTS_A_STEP = 20
_TESTS_A_STEP = 20
"""Number of questions that take about as long as a simple step."""

START = PossibleEvent("start", Tick(), 0.0)

_QUIET = frozenset({Setpoints, StateChange, WakeAt})


def explore(
    robot: RobotSpec,
    program: Program,
    conditions: Conditions,
    most: int = MOST_NODES,
    body: RobotState | None = None,
    most_work: float = MOST_WORK,
) -> Exploration:
    """Return everything that can happen to the mission, up to the limits.

    Sure steps are explored first, so that a state counts as unsure only if it cannot be reached
    without undecided assumptions.

    Args:
        robot: The robot.
        program: The mission.
        conditions: Decides which conditions can be true together.
        most: Largest number of states.
        body: The robot's commanded state; None for the program's initial configuration.
        most_work: Largest amount of work.
    """
    oracle = Oracle(conditions, robot.table.configurations[program.start_configuration])
    program = _telling(replace(program, time_limit_s=inf, most_phases=inf))
    asking = oracle.program(program)
    taken: list[BranchKey] = []
    walk = _Walk(
        Engine(robot, asking, nominal=True, taken=taken),
        taken,
        oracle,
        Moves(robot, asking, conditions),
        Exploration(program, robot, branches=oracle.branches),
        most,
        most_work,
    )
    walk.begin(body)
    walk.go_on()
    return walk.found


def _telling(program: Program) -> Program:
    """Return the program with a log line at the beginning of each call, to make it visible."""
    instructions = [*program.instructions]
    said: list[tuple[Say, int]] = []
    for index, each in enumerate(program.instructions):
        if isinstance(each, Require) and each.place:
            instructions[index] = each._replace(next=len(instructions) + len(said))
            said.append((Say("info", f"{BEGINS}{each.place}", each.next), index))
    return replace(
        program,
        instructions=(*instructions, *(say for say, _ in said)),
        handlers=(*program.handlers, *(program.handlers[index] for _, index in said)),
        phase_of=(*program.phase_of, *(program.phase_of[index] for _, index in said)),
    )


class _Arrival(NamedTuple):
    """Where a step of the engine has come to: the node before, what happened, what came of it."""

    source: int
    move: PossibleEvent
    state: EngineState
    effects: tuple[Effect, ...]
    moment: StepAnswers
    taken: tuple[BranchKey, ...]


@dataclass
class _Walk:
    engine: Engine
    taken: list[BranchKey]
    oracle: Oracle
    moves: Moves
    found: Exploration
    most: int
    most_work: float
    _known: dict[Any, int] = field(default_factory=dict)
    _sure: deque[int] = field(default_factory=deque)
    _unsure: deque[int] = field(default_factory=deque)
    _outlasted: set[Any] = field(default_factory=set)
    _held_back: list[_Arrival] = field(default_factory=list)

    def begin(self, body: RobotState | None) -> None:
        self._try(-1, START, partial(self.engine.start, body=body))

    def go_on(self) -> None:
        while self.found.complete:
            if self._sure:
                self._leave(self._sure.popleft())
            elif self._held_back:
                held, self._held_back = self._held_back, []
                for arrival in held:
                    self._enter(arrival, sure=False)
            elif self._unsure:
                self._leave(self._unsure.popleft())
            elif not self._outlast():
                return

    def _outlast(self) -> bool:
        """Try alternating sensors, and return whether a wait has led to a new state."""
        steps = len(self.found.steps) + len(self._held_back)
        fired: dict[Any, set[str]] = defaultdict(set)
        for done in self.found.steps:
            for effect in done.effects:
                if isinstance(effect, TriggerFired) and done.source >= 0:
                    key = key_of_wait(self.found.nodes[done.source].state)
                    fired[key].add(effect.trigger)
        for index, node in enumerate(list(self.found.nodes)):
            it = self._wait_of(node.state)
            if it is None or node.over or (key := key_of_wait(node.state)) in self._outlasted:
                continue
            self._outlasted.add(key)
            for state, at_s in lasting(it, node.state, self.moves.conditions):
                move = PossibleEvent("lasting", Tick(), at_s)
                step = partial(self.engine.step, state, move.event, at_s)
                self._try(index, move, step, _due(it, state, at_s), fired[key])
        return len(self.found.steps) + len(self._held_back) > steps

    def _leave(self, index: int) -> None:
        node = self.found.nodes[index]
        if node.over:
            return
        state = node.state
        wait = self._wait_of(state)
        for move in self.moves.of(state, node.now):
            if not self.found.complete:
                return
            due = () if wait is None else _due(wait, state, move.at_s)
            self._try(index, move, partial(self.engine.step, state, move.event, move.at_s), due)

    def _wait_of(self, state: EngineState) -> Wait | None:
        """Return the wait that the state is in, None without one."""
        it = self.engine.program.instructions[state.mission.pc]
        return it if state.mission.begun and isinstance(it, Wait) else None

    def _waits(self, result: tuple[EngineState, tuple[Effect, ...]]) -> int:
        """Return the index of the wait that a result is in, or ``NOWHERE``."""
        return NOWHERE if self._wait_of(result[0]) is None else result[0].mission.pc

    def _try(
        self,
        source: int,
        move: PossibleEvent,
        step: Callable[[], tuple[EngineState, tuple[Effect, ...]]],
        due: Collection[Trigger] = (),
        known: Collection[str] | None = None,
    ) -> None:
        """Record the results of a step of the engine, up to the limits.

        Args:
            source: Index of the state before.
            move: The event.
            step: The step of the engine.
            due: Triggers that fire if their condition is still true.
            known: If given, only results count in which a trigger outside of these has fired.
        """
        conditions, tests = self.moves.conditions, self.moves.conditions.tests
        try:
            for (state, effects), moment in self.oracle.every(step, self._waits, due):
                if known is None or any(
                    isinstance(each, TriggerFired) and each.trigger not in known for each in effects
                ):
                    taken = tuple(self.taken)
                    self._arrive(_Arrival(source, move, state, effects, moment, taken))
                self.taken.clear()
                more = (conditions.tests - tests) / _TESTS_A_STEP
                tests = conditions.tests
                self.found.work += 1 + len(effects) / _EFFECTS_A_STEP + more
                if self.found.work > self.most_work or not self.found.complete:
                    self.found.complete = False
                    return
        except TooManyQuestionsError:
            self.found.complete = False

    def _arrive(self, it: _Arrival) -> None:
        if it.moment.answer.sure and (it.source < 0 or self.found.nodes[it.source].sure):
            self._enter(it, sure=True)
        else:  # postponed until all sure steps are known
            self._held_back.append(it)

    def _enter(self, it: _Arrival, *, sure: bool) -> None:
        told = tuple([effect for effect in it.effects if type(effect) not in _QUIET])
        fresh = len(self.found.nodes)
        target = self._known.setdefault(key_of(it.state), fresh)
        if target == it.source and not told:
            return
        if target == fresh:
            if target >= self.most:
                self.found.complete = False
                return
            self.found.nodes.append(
                ExploredState(it.state, it.move.at_s, len(self.found.steps), sure)
            )
            (self._sure if sure else self._unsure).append(target)
        for branch in it.taken:
            self.found.taken.setdefault(branch, len(self.found.steps))
        self.found.steps.append(ExploredStep(it.source, target, it.move, told, it.moment, sure))


def _due(wait: Wait, state: EngineState, now: float) -> Collection[Trigger]:
    """Return the triggers that fire now if their condition is still true."""
    mission = state.mission
    return [
        (mission.pc, number)
        for number, (each, since) in enumerate(zip(wait.triggers, mission.since, strict=True))
        if not isnan(since) and has_come(mission.clock(now), since + each.held_s)
    ]


def key_of(state: EngineState) -> Any:
    """Return a key that is equal for states that can only continue in the same way."""
    mission, body = state.mission, state.robot
    flight, motion = body.flight, body.motion
    robot = (
        (body.configuration, body.marks, body.control, body.values, body.seeking),
        flight and (flight.purpose, flight.values),
        motion and (motion.command, motion.stage, isnan(motion.accepted_s)),
        state.rules,
    )
    if mission.diverting is not None:  # the place of the fault is irrelevant now
        where = mission.diverting.go, mission.diverting.go_name, mission.stopped, mission.handling
        return where, motion and bool(motion.place), robot
    return (
        (mission.pc, mission.begun, mission.tries, mission.handling, mission.ended),
        mission.result.done if mission.result else None,
        tuple(map(isnan, mission.since)),
        mission.ending and (mission.ending.outcome, mission.ending.end),
        motion and motion.place,
        robot,
    )


def key_of_wait(state: EngineState) -> Any:
    """Return the same key, independent of the conditions that have become true."""
    return key_of(state._replace(mission=state.mission._replace(since=())))


# --- missions ------------------------------------------------------------------------------------


MOST_ASSUMPTIONS = 20
"""How often the exploration is repeated without steps that can never run."""


def conditions_of(loaded: LoadedMission) -> Conditions:
    """Return the decision procedure for conditions on the mission's robot."""
    spans = ranges(loaded.loaded_robot.profile, loaded.robot)
    return Conditions(loaded.robot.vocabulary.with_changes, spans, len(loaded.robot.regions))


class _Shared(NamedTuple):
    """Explorations of a program, for other missions that differ from it in their pipe alone.

    Attributes:
        robot: The robot as its profile has it.
        conditions: The conditions with the answers that they have found.
    """

    robot: RobotSpec
    program: Program
    conditions: Conditions
    explored: Sequence[Explored]


_SHARED: Final = deque[_Shared]()
"""The last, and those before it as far as all are at most ``MOST_SHARED`` of work."""
MOST_SHARED = MOST_WORK / 2
"""About 60 MB, as all shipped missions; an editor has another program at each key. [decided]"""

_OF_A_PIPE = frozenset({"commands", "sight"})
"""What a pipe changes in a robot: the torque with which its clamps count as closed."""


def explore_mission(loaded: LoadedMission) -> tuple[Sequence[Explored], Conditions]:
    """Explore a mission, or return what was found in a mission that differs in its pipe alone.

    In an exploration sensors show nothing and commands are done by their time, so that neither the
    pipe's diameters nor the torques of clamps have a part in it. It is done without them.

    Returns:
        The explorations, see :func:`_explored`, and the conditions with their answers.
    """
    usual, robot = loaded.loaded_robot.oriented(loaded.robot.polarity), loaded.robot
    others = (each.name for each in fields(robot) if each.name not in _OF_A_PIPE)
    own = any(getattr(robot, name) is not getattr(usual, name) for name in others)
    usual = robot if own else usual
    program = replace(loaded.program, diameter_m=None, bores_m=())
    for known in tuple(_SHARED):
        if known.robot is usual and known.program == program:
            return known.explored, known.conditions.copied()
    conditions = conditions_of(loaded)
    explored = _explored(replace(usual), program, conditions)
    _SHARED.append(_Shared(usual, program, conditions.copied(), explored))
    while (
        len(_SHARED) > 1
        and sum(book.found.work for each in tuple(_SHARED) for book in each.explored) > MOST_SHARED
    ):
        _SHARED.popleft()
    return explored, conditions


def _explored(robot: RobotSpec, program: Program, conditions: Conditions) -> list[Explored]:
    """Explore a program repeatedly, each time without the steps that can never run.

    After a certain refusal the check continues without the step, to find later faults as well. All
    explorations together are limited to the work of one.
    """
    explored: list[Explored] = []
    left: float = MOST_WORK
    for _ in range(MOST_ASSUMPTIONS):
        book = index_exploration(explore(robot, program, conditions, most_work=left))
        left -= book.found.work
        known = {place for earlier in explored for place in earlier.visits}
        explored.append(book)
        stuck = {
            place
            for place, visits in book.visits.items()
            if place not in known and visits.never_fine
        }
        if not stuck or not book.found.complete:
            break
        program = _without(program, stuck)
    return explored


def _without(program: Program, places: set[str]) -> Program:
    """Return the program without the steps or calls at these places."""
    instructions = tuple(
        Require((), "", _after(program, index), each.failed, "")
        if isinstance(each, Do | Require) and each.place in places
        else each
        for index, each in enumerate(program.instructions)
    )
    return replace(program, instructions=instructions)


def _after(program: Program, index: int) -> int:
    """Return the instruction after a step; after a call, the target of its success."""
    step = program.instructions[index]
    assert isinstance(step, Do | Require)
    if isinstance(step, Do):
        return step.next
    for end in program.instructions[index + 1 :]:
        if isinstance(end, Say):
            return end.next
        if not isinstance(end, Raise):
            break
    return step.next  # it has no end that succeeds


def explore_corrected(
    explored: Sequence[Explored], loaded: LoadedMission, conditions: Conditions
) -> list[Explored]:
    """Explore a mission whose refused steps and broken rules have been corrected.

    Parts that are reached, needed or fired only then are not reported as never reached, needed or
    fired.
    """
    last = explored[-1]
    refused = {
        place for book in explored for place, visits in book.visits.items() if visits.refused
    }
    broken = any(book.broken for book in explored)
    if not last.found.complete or not (refused or broken):
        return []
    program = last.found.program
    instructions = tuple(
        each._replace(failed=_after(program, index))
        if isinstance(each, Do | Require) and each.place in refused
        else each
        for index, each in enumerate(program.instructions)
    )
    corrected = replace(program, instructions=instructions, rules=() if broken else program.rules)
    left = MOST_WORK - sum(book.found.work for book in explored)
    return [index_exploration(explore(loaded.robot, corrected, conditions, most_work=left))]
