"""A rule about conditions that are never or always true for this robot in this pipe."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from math import inf, nan

from pirate_sm.checking.actuation_in_force import Actuated, InForce, under
from pirate_sm.checking.exploring.answers import Fact
from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.exploration_index import Explored
from pirate_sm.checking.exploring.piecewise_linear import borders, samples, signals
from pirate_sm.checking.exploring.signal_ranges import ANYTHING, Range, ranges
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.driving import driven_before, fastest_m_s, phases_after
from pirate_sm.checking.mission.mission_view import MissionView
from pirate_sm.checking.mission.wait_triggers import numbers_known
from pirate_sm.engine.mission.program import Branch, TriggerSpec, Wait
from pirate_sm.expressions import BOOLEAN, EnumType, Expression, tree
from pirate_sm.expressions.vocabulary import change_of
from pirate_sm.loading.mission import LoadedMission

BEGINNING_S = 5.0
"""How long commands may drive before a wait begins [decided]."""

STILL_M = 0.01
"""Largest distance by which a robot that does not drive is pushed or slips [decided]."""

_JOINT = "Joint"


def out_of_reach(view: MissionView) -> Iterator[Finding]:
    """Yield conditions in the mission's own file that cannot become true."""
    seen, loaded, places = view.seen, view.loaded, view.places
    check = _Reach(seen, loaded)
    told: set[str] = set()
    for wait in loaded.program.instructions:
        if not isinstance(wait, Wait) or not check.states(wait):
            continue
        for trigger in wait.triggers:
            place = places.read(trigger.place)
            own = place.file == loaded.documents[0].name and trigger.place not in told
            if trigger.condition is None or not own:
                continue
            found = check.judge(wait, trigger, trigger.condition)
            if found is not None:
                told.add(trigger.place)
                code, message = found
                yield places.finding(place, code, message)
    for branch in loaded.program.instructions:
        if not isinstance(branch, Branch) or branch.place in told:
            continue
        place, message = places.read(branch.place), check.asked(branch.condition)
        if message and place.file == loaded.documents[0].name:
            told.add(branch.place)
            yield places.finding(place, "condition.beyond", message)


_Said = tuple[str, str]


def _decided(condition: Expression) -> tuple[tuple[list[Fact], str], tuple[list[Fact], str]]:
    """Return two sets of facts, each with what a condition is if they are impossible."""
    node = condition.tree
    known = [(node, False), *numbers_known(node)]
    return ([(node, True)], "out of reach"), (known, "always true")


class _Reach:
    def __init__(self, seen: Sequence[Explored], loaded: LoadedMission) -> None:
        self._seen, self._loaded, self._robot = seen, loaded, loaded.robot
        numbers = loaded.robot.vocabulary.numbers
        self._odometry = numbers[loaded.robot.odometry] if loaded.robot.odometry >= 0 else ""
        self._changed = self._odometry and change_of(self._odometry)
        self._speed = numbers[loaded.robot.speed] if loaded.robot.speed >= 0 else ""
        self._spans = dict(ranges(loaded.loaded_robot.profile, loaded.robot))
        self._usual = self._with({})
        self._force = InForce(loaded.loaded_robot.profile, loaded.robot)
        self._no_load = fastest_m_s(loaded)
        self._driven = [driven_before(book.found, loaded) for book in seen]

    def _with(self, narrower: Mapping[str, Range]) -> Conditions:
        spans = {**self._spans, **narrower}
        return Conditions(self._robot.vocabulary.with_changes, spans, len(self._robot.regions))

    def states(self, wait: Wait) -> set[int]:
        """Return the configurations in which the wait is reached."""
        return {each.configuration for each in self._actuated(wait)}

    def _actuated(self, wait: Wait) -> set[Actuated]:
        """Return the same, each with the control in force."""
        waits = (book.waits[wait.phase, wait.place] for book in self._seen)
        return {each for waiting in waits for each in waiting.actuated}

    def judge(self, wait: Wait, trigger: TriggerSpec, condition: Expression) -> _Said | None:
        """Return the finding about a trigger; None if it can fire, or could never fire anywhere."""
        node = condition.tree
        if not self._possible(wait, [(node, True)], self._usual):
            return None  # reported there
        return (
            self._beyond(wait, condition)
            or self._at_start(wait, trigger, condition)
            or self._still(wait, condition)
            or self._word(wait, condition)
            or self._held(wait, trigger, node)
        )

    def asked(self, condition: Expression) -> str:
        """Return why the condition of a step is out of reach; empty if it is not."""
        every = self._robot.table.configurations
        for name, most, why in self._lasting(self._no_load, ""):
            if not self._is_about(condition, name, most):
                continue
            narrower = self._with({name: Range(-most, most)})
            for facts, said in _decided(condition):
                if self._usual.anywhere(facts, every) and not narrower.anywhere(facts, every):
                    return f"'{condition.text}' is {said}: {why}"
        return ""

    def _is_about(self, condition: Expression, name: str, most: float) -> bool:
        return bool(name) and most < inf and name in self._usual.free(condition.tree)

    def _possible(self, wait: Wait, facts: Sequence[Fact], conditions: Conditions) -> bool:
        table = self._robot.table
        return conditions.anywhere(facts, [table.configurations[n] for n in self.states(wait)])

    # --- true already -----------------------------------------------------------------------

    def _at_start(self, wait: Wait, trigger: TriggerSpec, condition: Expression) -> _Said | None:
        """Return a finding about a condition on odometry that is true where the run begins.

        Odometry is 0 there, and only commands have driven the robot since: in this wait, too, it
        drives only if the condition is false. What driving farther can only make false was true at
        0, too.
        """
        node = condition.tree
        if trigger.held_s or self._odometry not in self._usual.free(node):
            return None
        if any(wait.phase in driven_before(b.found, self._loaded, wait) for b in self._seen):
            return None
        ways = self._ways_before(wait)
        span = self._driven_to(ways, self._no_load * BEGINNING_S)
        for way, side in ((1, Range(0.0, inf)), (-1, Range(-inf, 0.0))):
            if ways == {way} and self._grows(node, side) == -way:
                span = Range(0.0, 0.0)
        false: list[Fact] = [(node, False), *numbers_known(node)]
        narrower = self._with({self._odometry: span})
        if not self._possible(wait, false, self._usual) or self._possible(wait, false, narrower):
            return None
        message = f"'{condition.text}' is true already as the wait begins: {self._odometry} is 0 "
        return "trigger.at_start", f"{message}where the run begins"

    def _ways_before(self, wait: Wait) -> set[int]:
        """Return which ways the robot may have been driven before the wait, and in it."""
        return {way for way, phases in self._driving.items() if wait.phase in phases}

    @cached_property
    def _driving(self) -> Mapping[int, frozenset[str]]:
        """The phases at or before which the robot drives forward (1) and backward (-1)."""
        found: dict[int, frozenset[str]] = {1: frozenset(), -1: frozenset()}
        for book in self._seen:
            begin: dict[int, list[int]] = {1: [], 0: [], -1: []}
            for number, node in enumerate(book.found.nodes):
                body = node.state.robot
                begin[self._way(Actuated(body.configuration, body.control))].append(number)
            for way in found:
                found[way] |= phases_after(book.found, begin[way])
        return found

    @staticmethod
    def _driven_to(ways: set[int], most_m: float) -> Range:
        """Return how far a robot comes that is driven these ways, at most so far."""
        return Range(-most_m if -1 in ways else -STILL_M, most_m if 1 in ways else STILL_M)

    # --- too fast, too far ------------------------------------------------------------------

    def _beyond(self, wait: Wait, condition: Expression) -> _Said | None:
        never, always = _decided(condition)
        for name, most, why in self._limits(wait):
            if not self._is_about(condition, name, most):
                continue
            narrower = self._with({name: Range(-most, most)})
            # What changes in a wait is 0 at its beginning, which is judged elsewhere.
            for facts, said in (never,) if name == self._changed else (never, always):
                possible = self._possible(wait, facts, self._usual)
                if possible and not self._possible(wait, facts, narrower):
                    return "condition.beyond", f"'{condition.text}' is {said}: {why}"
        return None

    def _limits(self, wait: Wait) -> Iterator[tuple[str, float, str]]:
        """Yield signals with their largest values in a wait, and the reasons."""
        fastest, there = self._fastest(wait)
        for name, most, why in self._lasting(fastest, there):
            yield name, most, why
            yield name and change_of(name), 2 * most if name == self._speed else most, why
        mission_s = self._loaded.program.time_limit_s
        ends_s = min([mission_s, wait.within_s, *(t.after_s for t in wait.triggers if t.after_s)])
        what = "mission" if ends_s == mission_s else "wait"
        why = f"the {what} ends after {ends_s:g} s, in which it drives less{there}"
        if not wait.counts_on:
            yield self._changed, fastest * ends_s, why
        if not any(wait.phase in phases for phases in self._driven):
            yield self._odometry, fastest * ends_s + self._no_load * BEGINNING_S, why

    def _fastest(self, wait: Wait) -> tuple[float, str]:
        """Return how fast the robot drives in a wait, m/s, and under which control, for people."""
        each = [(self._force.fastest_m_s(at), at.control) for at in self._actuated(wait)]
        fastest, control = max(each)
        if fastest >= self._no_load:
            return self._no_load, ""
        return fastest, under(self._robot, control)

    def _lasting(self, fastest: float, there: str) -> Iterator[tuple[str, float, str]]:
        """Yield the same for limits that apply to every condition."""
        pipe = self._loaded.pipe
        most = f"{fastest:.3g} m/s"
        usual = f"without a load the robot drives {most}"
        yield self._speed, fastest, f"the robot drives at most {most}{there}" if there else usual
        if pipe is not None:
            length = pipe.route().length_m
            yield self._odometry, length, f"the pipe is {length:.3g} m long"

    # --- the wrong way ----------------------------------------------------------------------

    def _still(self, wait: Wait, condition: Expression) -> _Said | None:
        """Return a finding about a condition on odometry alone that driving cannot make true."""
        node = condition.tree
        free = self._usual.free(node)
        if not self._odometry or not {self._odometry, self._changed} & free:
            return None
        ways = {self._way(each) for each in self._actuated(wait)}
        if self._changed in free and wait.counts_on:
            return None  # what an earlier wait has counted may have made it true nearly
        if self._changed in free:
            return self._not_on(wait, condition, self._changed, ways)
        if free == {self._odometry} and (said := self._in_vain(condition, ways)):
            return said
        said = self._not_on(wait, condition, self._odometry, self._ways_before(wait))
        at_first = f"{self._odometry} is 0 where the run begins"
        return said and ("trigger.at_start", f"{said[1]}, and {at_first}")

    def _in_vain(self, condition: Expression, ways: set[int]) -> _Said | None:
        """Return a finding about a condition on odometry alone, whatever it was before."""
        if ways == {0}:
            message = f"'{condition.text}' does not change: nothing drives in this wait"
            return "wait.still", message
        grows = self._grows(condition.tree)
        if len(ways) == 1 and grows and ways == {-grows}:
            how = ("grow", "back") if grows > 0 else ("shrink", "forward")
            message = f"'{condition.text}' waits for {self._odometry} to {how[0]}, and the robot "
            return "wait.still", f"{message}drives {how[1]}"
        return None

    def _not_on(self, wait: Wait, condition: Expression, name: str, ways: set[int]) -> _Said | None:
        """Return a finding about an unreachable condition on a distance driven these ways."""
        narrower = self._with({name: self._driven_to(ways, inf)})
        if self._possible(wait, [(condition.tree, True)], narrower):
            return None
        drives = "the robot drives forward" if 1 in ways else "the robot drives back"
        why = drives if {1, -1} & ways else "nothing drives in this wait"
        message = f"'{condition.text}' does not come true: {why}"
        return "wait.still", message

    def _way(self, at: Actuated) -> int:
        """Return 1 if the configuration drives forward, -1 backward, 0 if it drives no wheel."""
        metres = {wheel.slot: wheel.metres_per_rad for wheel in self._robot.wheels}
        driven = {slot for slots in self._robot.driven[at.configuration].values() for slot in slots}
        total = sum(
            write.value * metres.get(write.slot, 0.0)
            for write in self._force.last_writes(at)
            if write.slot in driven
        )
        return (total > 0) - (total < 0)

    def _grows(self, node: tree.Node, span: Range = ANYTHING) -> int:
        """Return 1 if the condition becomes true with growing odometry, -1 with falling, else 0."""
        place = self._robot.odometry
        marks: set[float] = set()
        for each in tree.walk(node):
            if isinstance(each, tree.Compare) and signals(each):
                marks |= borders(each, span)
        values = [nan] * len(self._robot.vocabulary.with_changes.numbers)
        truths = []
        for value in sorted(samples(marks, span)):
            values[place] = value
            words = [None] * len(self._robot.vocabulary.words)
            truths.append(Expression("", BOOLEAN, node).evaluate(values, words) is True)
        if truths == sorted(truths) and len(set(truths)) > 1:
            return 1
        return -1 if truths == sorted(truths, reverse=True) and len(set(truths)) > 1 else 0

    # --- words ------------------------------------------------------------------------------

    def _word(self, wait: Wait, condition: Expression) -> _Said | None:
        """Return a finding about a word that cannot occur in this pipe.

        A word with a condition of its own may occur anywhere.
        """
        pipe = self._loaded.pipe
        if pipe is None or pipe.route().crossings_m:
            return None
        vocabulary = self._robot.vocabulary
        anywhere = {each.word for each in self._robot.word_conditions}
        of_bends = [word for word in self._robot.detector_words if word not in anywhere]
        joint = () if anywhere else (_JOINT,)
        for name, values in (("detector", of_bends), ("segment", joint)):
            kind = vocabulary.types.get(name)
            if not isinstance(kind, EnumType) or name not in self._usual.free(condition.tree):
                continue
            signal = tree.Signal(name, "word", vocabulary.words.index(name))
            said: Fact = tree.Matches(signal, tuple(values)), False
            if not self._possible(wait, [(condition.tree, True), said], self._usual):
                message = f"'{condition.text}' waits for a bend, and the pipe has none"
                return "word.never", message
        return None

    def _held(self, wait: Wait, trigger: TriggerSpec, node: tree.Node) -> _Said | None:
        """Return a finding about a word that must be held longer than it is valid."""
        detector = self._loaded.loaded_robot.profile.detector
        if trigger.held_s <= detector.valid_for:
            return None
        if "detector" not in self._usual.free(node):
            return None
        words = self._robot.vocabulary.words
        known: Fact = tree.Known(tree.Signal("detector", "word", words.index("detector"))), False
        if self._possible(wait, [(node, True), known], self._usual):
            return None
        message = f"it must be held for {trigger.held_s:g} s, and a word of the detector is valid "
        return "word.held", f"{message}for {detector.valid_for:g} s"
