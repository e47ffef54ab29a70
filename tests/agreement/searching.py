"""All event sequences of a small mission up to a length, one after the other, by brute force.

It knows nothing of how the exploration tells states apart, or of what conditions can be: sensors
show every combination of some values, and two moments are one only if all times agree as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from math import inf, isfinite, isnan, nan, prod
from typing import NamedTuple

from agreement.running import conditions_in
from pirate_sm.checking.exploring.signal_ranges import ANYTHING, ranges
from pirate_sm.core import effects as fx
from pirate_sm.core import events as ev
from pirate_sm.core._engine.robot import robot_state
from pirate_sm.core._engine.state import OUTSIDE
from pirate_sm.core.engine import Engine, EngineState
from pirate_sm.core.expressions import EnumType, tree
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.program import Question, Wait

MOST_SHOWN = 60
MOST_STEPS = 30_000


class TooMuchError(Exception):
    """The mission is not small."""


class _At(NamedTuple):
    state: EngineState
    now: float


class Search:
    """Tries everything.

    Raises:
        TooMuchError: Sensors could show too much, or compare two signals.
    """

    def __init__(self, loaded: LoadedMission) -> None:
        program = replace(loaded.program, time_limit_s=inf)
        self.loaded, self.program = loaded, program
        self.engine = Engine(loaded.robot, program, nominal=True)
        self.reports = [*_reports(loaded)]
        self.steps = 0

    def length(self, wanted: Callable[[fx.Effect], bool], most: int) -> int | None:
        """The fewest events, the start among them, until it happens; None: more than ``most``.

        Raises:
            TooMuchError: There are too many courses.
        """
        known: set[object] = set()
        layer: list[_At] = []
        for report in self.reports:
            state, effects = self.engine.start(0.0, (report,))
            if any(map(wanted, effects)):
                return 1
            layer += _new(state, 0.0, known)
        for length in range(2, most + 1):
            before, layer = layer, []
            for at in before:
                for state, now, effects in self._after(at):
                    if any(map(wanted, effects)):
                        return length
                    layer += _new(state, now, known)
        return None

    def _after(self, at: _At) -> Iterator[tuple[EngineState, float, Sequence[fx.Effect]]]:
        if at.state.mission.ended or at.state.mission.ending:
            return
        for report in self.reports:
            shown, _ = self.engine.step(at.state, report, at.now)
            for event, now in self._events(shown, at.now):
                self.steps += 1
                if self.steps > MOST_STEPS:
                    raise TooMuchError
                state, effects = self.engine.step(shown, event, now)
                yield state, now, effects

    def _events(self, state: EngineState, now: float) -> Iterator[tuple[ev.Event, float]]:
        body, wake = state.robot, state.wake_at_s
        yield ev.Tick(), now
        if isfinite(wake):
            yield ev.Tick(), wake
            yield ev.Tick(), now + (wake - now) / 2
        if body.flight is not None:
            for status in ("accepted", "rejected", "superseded"):
                yield ev.SubmitResult(body.flight.setpoint_id, status, ""), now
        if body.motion is not None:
            yield ev.CommandFailed("tried"), now
        it = self.program.instructions[state.mission.pc]
        if isinstance(it, Wait):
            yield from ((ev.Answer(each.answer), now) for each in it.triggers if each.answer)
        elif isinstance(it, Question):
            yield from ((ev.Answer(choice), now) for choice, _ in it.choices)
        yield from ((fault, now) for fault in self._faults(state))

    def _faults(self, state: EngineState) -> Iterator[ev.FaultReport]:
        robot = self.loaded.robot
        words = (*robot_state.obeyed(robot, state.robot), *state.words[-len(OUTSIDE) :])
        for code in {each.code for each in self.program.handlers[state.mission.pc]}:
            rules = [fault for fault in robot.faults if fault.code == code]
            # What a rule reads may be shown by nothing that the mission reads: then it may hold.
            if not rules:
                yield ev.FaultReport(code, "tried")
            for rule in rules:
                if rule.when.evaluate(_blind(robot), words) is not False:
                    yield ev.FaultReport(code, rule.message)


def _blind(robot: object) -> tuple[float, ...]:
    return (nan,) * len(robot.vocabulary.numbers)  # type: ignore[attr-defined]


def _new(state: EngineState, now: float, known: set[object]) -> Iterator[_At]:
    key = _key(state, now)
    if key not in known:
        known.add(key)
        yield _At(state, now)


def _key(state: EngineState, now: float) -> object:
    mission, body = state.mission, state.robot
    since = tuple(None if isnan(each) else round(now - each, 6) for each in mission.since)
    flight = body.flight and body.flight._replace(setpoint_id=0)
    motion = body.motion and (
        body.motion.command,
        body.motion.place,
        body.motion.stage,
        isnan(body.motion.accepted_s) or round(now - body.motion.accepted_s, 6),
    )
    return (
        mission._replace(armed_s=round(now - mission.armed_s, 6), since=since, cause=""),
        body.configuration, body.marks, flight, motion, body.seeking, state.rules,
        repr(body.values),
    )  # fmt: skip


def _reports(loaded: LoadedMission) -> Iterator[ev.SignalReport]:
    """Every combination of values between and on the borders of the mission's conditions."""
    nodes = [node for each in conditions_in(loaded.program) for node in tree.walk(each.tree)]
    for node in nodes:
        names = {each.name for each in tree.walk(node) if isinstance(each, tree.Signal)}
        if isinstance(node, tree.Compare) and len(names) > 1:
            raise TooMuchError
    spans = ranges(loaded.loaded_robot.profile, loaded.robot)
    marks = sorted({node.value for node in nodes if isinstance(node, tree.Number)})
    numbers: dict[str, list[float]] = {}
    words: dict[str, list[str | None]] = {}
    for name, kind in sorted({(n.name, n.kind) for n in nodes if isinstance(n, tree.Signal)}):
        if name in loaded.robot.regions:
            continue
        if kind == "number":
            span = spans.get(name, ANYTHING)
            near = [s * (mark + d) for mark in marks for d in (-1e-4, 0.0, 1e-4) for s in (1, -1)]
            numbers[name] = [nan, *sorted({each for each in (*near, 0.0)
                                           if span.low <= each <= span.high})]  # fmt: skip
        else:
            type_ = loaded.robot.vocabulary.types[name]
            assert isinstance(type_, EnumType)
            words[name] = [None, *type_.values]
    if prod(len(each) for each in (*numbers.values(), *words.values())) > MOST_SHOWN:
        raise TooMuchError
    for values in product(*numbers.values()):
        for spoken in product(*words.values()):
            yield ev.SignalReport(
                tuple(zip(numbers, values, strict=True)), tuple(zip(words, spoken, strict=True))
            )
