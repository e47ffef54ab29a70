"""A rule about conditions that are never or always true for this robot in this pipe."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Set
from functools import cache, cached_property
from math import degrees, inf, nan, radians

from pirate_sm.checking.actuation_in_force import Actuated, InForce, under
from pirate_sm.checking.exploring.conditions import Conditions, Fact
from pirate_sm.checking.exploring.signal_ranges import ANYTHING, Range, borders, samples, signals
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.mission.mission_view import MissionView, driven_before, fastest_m_s, led_to
from pirate_sm.checking.mission.wait_triggers import numbers_known
from pirate_sm.checking.pipe.at_waits import AtWaits
from pirate_sm.core.expressions import BOOLEAN, EnumType, Expression, change_of, tree
from pirate_sm.core.program import Branch, TriggerSpec, Wait
from pirate_sm.core.robot import SlotSpec, Write

# --- ranges that are kept ------------------------------------------------------------------------


STILL_M_S = 0.01
"""Largest speed against its drive that is noise [decided]."""

ANGLE_OFF_RAD = radians(15)
"""How far a joint may be off the angle that its board was asked for [decided]."""

WOUND = 4.0
"""Largest torque in a loop's joint, as a share of what the loop keeps [decided]: in a simulated
bend others have wound springs to twice their own motor's torque."""

Limit = tuple[str, Range, str]
"""A signal, its range, and the reason."""


def about(most: float) -> Range:
    """Return the range of what is at most so large, to either side."""
    return Range(-most, most)


def kept_ranges(
    force: InForce, at: Collection[Actuated], ways: set[int], speed: str, names: Set[str]
) -> Iterator[Limit]:
    """Yield the ranges of the speed, of angles that boards keep, and of torques under loops.

    Args:
        force: What is active.
        at: In which configurations and under which controls the wait begins.
        ways: Which ways the robot drives in these.
        speed: The signal of the robot's speed; empty without one.
        names: The signals whose ranges are wanted.
    """
    for way, side in ((1, Range(-STILL_M_S, inf)), (-1, Range(-inf, STILL_M_S))):
        if ways == {way}:
            yield speed, side, f"the robot drives {'forward' if way > 0 else 'back'} in this wait"
    numbers = force.robot.vocabulary.numbers
    for number, slot in enumerate(force.robot.slots):
        if not any(each >= 0 and numbers[each] in names for each in (slot.angle, slot.torque)):
            continue
        writes = [write for each in at if (write := force.last_of(each, number)) is not None]
        if len(writes) < len(at):
            continue
        if (angle := _angle(slot, force, at, number)) is not None:
            yield numbers[slot.angle], *angle
        if slot.torque >= 0 and all(write.how == "bear" for write in writes):
            loops = (w for each in at for w in force.last_writes(each) if w.how == "bear")
            most = max(map(_borne_nm, loops))  # joints of one part wind each other
            yield numbers[slot.torque], about(most * WOUND), f"a loop keeps {most:.3g} Nm at most"


def _angle(
    slot: SlotSpec, force: InForce, at: Collection[Actuated], number: int
) -> tuple[Range, str] | None:
    """Return the range of an angle that a board has brought to other angles than 0."""
    if slot.unit != "angle" or slot.angle < 0:
        return None
    asked = set[float]()
    for write in {write for each in at for write in force.may_follow(each, number)}:
        if write is None or write.how != "set" or write.share_of >= 0:
            return None
        asked.add(write.value)
    if asked == {0.0}:
        return None
    span = Range(min(*asked, 0.0) - ANGLE_OFF_RAD, max(*asked, 0.0) + ANGLE_OFF_RAD)
    said = " or ".join(f"{degrees(each):.4g} deg" for each in sorted(asked))
    return span, f"a command has brought it to {said}"


def _borne_nm(write: Write) -> float:
    """Return the largest torque that a loop is asked for, Nm."""
    return abs(write.value) if write.grip is None else write.grip.at_most_nm


# --- conditions out of reach ---------------------------------------------------------------------


BEGINNING_S = 5.0
"""How long commands may drive before a wait begins [decided]."""

STILL_M = 0.01
"""Largest distance by which a robot that does not drive is pushed or slips [decided]."""


def out_of_reach(view: MissionView) -> Iterator[Finding]:
    """Yield conditions in the mission's own file that cannot become true."""
    loaded, places, check = view.loaded, view.places, _Reach(view)
    reported: set[str] = set()
    for at, wait in enumerate(loaded.program.instructions):
        if not isinstance(wait, Wait) or not check.states(wait):
            continue
        for trigger in wait.triggers:
            if trigger.place in reported:
                continue
            place = places.read(trigger.place)
            found = None
            if place.file == loaded.documents[0].name:
                found = check.judge(at, wait, trigger)
            elif view.in_pipe is not None:
                found = check.too_far(at, wait, trigger)
                place = view.in_pipe.own_place(at, trigger.place) if found else place
            if found is not None:
                reported.add(trigger.place)
                code, message = found
                yield places.finding(place, code, message)
    yield from _branches(view, check, reported)


def _branches(view: MissionView, check: _Reach, reported: set[str]) -> Iterator[Finding]:
    """Yield conditions of steps that cannot become true."""
    for branch in view.loaded.program.instructions:
        if isinstance(branch, Branch) and branch.place not in reported:
            place, message = view.places.read(branch.place), check.asked(branch.condition)
            if message and place.file == view.loaded.documents[0].name:
                reported.add(branch.place)
                yield view.places.finding(place, "condition.beyond", message)


_Said = tuple[str, str]


def _decided(condition: Expression) -> tuple[tuple[list[Fact], str], tuple[list[Fact], str]]:
    """Return two sets of facts, each with what a condition is if they are impossible."""
    node = condition.tree
    known = [(node, False), *numbers_known(node)]
    return ([(node, True)], "out of reach"), (known, "always true")


class _Reach:
    def __init__(self, view: MissionView) -> None:
        loaded, self._in_pipe, self._usual = view.loaded, view.in_pipe, view.conditions
        self._seen, self._loaded, self._robot = view.seen, loaded, loaded.robot
        numbers = loaded.robot.vocabulary.numbers
        self._odometry = numbers[loaded.robot.odometry] if loaded.robot.odometry >= 0 else ""
        self._changed = self._odometry and change_of(self._odometry)
        self._of_way = frozenset({self._odometry, self._changed} - {""})
        self._speed = numbers[loaded.robot.speed] if loaded.robot.speed >= 0 else ""
        self._force = InForce(loaded.loaded_robot.profile, loaded.robot)
        self._no_load = fastest_m_s(loaded)

    @cached_property
    def _route(self) -> AtWaits | None:
        return AtWaits(self._in_pipe) if self._in_pipe is not None else None

    @cached_property
    def _driven(self) -> Sequence[Mapping[str, set[str]]]:
        """Per exploration and phase some waits before it in which the robot has driven."""
        explorations, driven = [book.found for book in self._seen], self._robot.driven
        return [led_to(found, driven_before(found, driven)) for found in explorations]

    def states(self, wait: Wait) -> set[int]:
        """Return the configurations in which the wait is reached."""
        return {each.configuration for each in self._actuated(wait)}

    def _actuated(self, wait: Wait) -> set[Actuated]:
        """Return the same, each with the active control."""
        waits = (book.waits[wait.phase, wait.place] for book in self._seen)
        return {each for waiting in waits for each in waiting.actuated}

    def judge(self, at: int, wait: Wait, trigger: TriggerSpec) -> _Said | None:
        """Return the finding about a trigger; None if it can fire, or could never fire anywhere."""
        condition = trigger.condition
        if condition is None:
            return None
        node = condition.tree
        if not self._possible(wait, [(node, True)], self._usual):
            return None  # reported there
        return (
            self._beyond(wait, condition, self._limits(at, wait, self._usual.free(node)))
            or self._at_start(wait, trigger, condition)
            or self._still(wait, condition)
            or self._word(at, wait, condition)
            or self._held(wait, trigger, node)
        )

    def asked(self, condition: Expression) -> str:
        """Return why the condition of a step is out of reach; empty if it is not."""
        every = self._robot.table.configurations
        for name, span, why in self._lasting(self._no_load, ""):
            if not self._is_about(condition, name, span):
                continue
            narrower = self._usual.within({name: span})
            for facts, said in _decided(condition):
                if self._usual.anywhere(facts, every) and not narrower.anywhere(facts, every):
                    return f"'{condition.text}' is {said}: {why}"
        return ""

    def _is_about(self, condition: Expression, name: str, span: Range) -> bool:
        return bool(name) and span != ANYTHING and name in self._usual.free(condition.tree)

    def _possible(self, wait: Wait, facts: Sequence[Fact], conditions: Conditions) -> bool:
        table = self._robot.table
        return conditions.anywhere(facts, [table.configurations[n] for n in self.states(wait)])

    # --- true already -----------------------------------------------------------------------

    def _at_start(self, wait: Wait, trigger: TriggerSpec, condition: Expression) -> _Said | None:
        """Return a finding about a condition on odometry that is true where the run begins.

        Odometry is 0 there, and only commands have driven the robot since: in this wait, too, it
        drives only if the condition is false. What driving farther can only make false was true at
        0, too, and what is true at 0 and ahead of it is so immediately.
        """
        node = condition.tree
        if trigger.held_s or self._odometry not in self._usual.free(node):
            return None
        if any(each.get(wait.phase, set()) - {wait.place} for each in self._driven):
            return None
        ways = self._ways_before(wait)
        span = self._driven_to(ways, self._no_load * BEGINNING_S)
        for way, side in ((1, Range(0.0, inf)), (-1, Range(-inf, 0.0))):
            if ways != {way}:
                continue
            if self._grows(node, side) == -way:
                span = Range(0.0, 0.0)
            elif "$" not in condition.text:  # a parameter may be 0 so that nothing is waited for
                span = side
        false: list[Fact] = [(node, False), *numbers_known(node)]
        narrower = self._usual.within({self._odometry: span})
        if not self._possible(wait, false, self._usual) or self._possible(wait, false, narrower):
            return None
        message = f"'{condition.text}' is true already as the wait begins: {self._odometry} is 0 "
        return "trigger.at_start", f"{message}where the run begins"

    def _ways_before(self, wait: Wait) -> set[int]:
        """Return which ways the robot may have been driven before the wait, and in it."""
        return set[int]().union(*(each.get(wait.phase, ()) for each in self._driving))

    @cached_property
    def _driving(self) -> Sequence[Mapping[str, set[int]]]:
        """Per exploration and phase which ways the robot has driven before it, and in it."""
        way, found = cache(self._way), []
        for book in self._seen:
            bodies = [node.state.robot for node in book.found.nodes]
            ways = [way(Actuated(each.configuration, each.control)) for each in bodies]
            found.append(led_to(book.found, [(n, each) for n, each in enumerate(ways) if each]))
        return found

    @staticmethod
    def _driven_to(ways: set[int], most_m: float) -> Range:
        """Return how far a robot comes that is driven these ways, at most so far."""
        return Range(-most_m if -1 in ways else -STILL_M, most_m if 1 in ways else STILL_M)

    # --- too fast, too far ------------------------------------------------------------------

    def too_far(self, at: int, wait: Wait, trigger: TriggerSpec) -> _Said | None:
        """Return the finding about a way of a called mission for which there is no room or time."""
        condition = trigger.condition
        if condition is None or self._usual.free(condition.tree).isdisjoint(self._of_way):
            return None
        if not self._possible(wait, [(condition.tree, True)], self._usual):
            return None
        return self._beyond(wait, condition, self._ways(at, wait))

    def _beyond(self, wait: Wait, condition: Expression, limits: Iterable[Limit]) -> _Said | None:
        never, always = _decided(condition)
        for name, span, why in limits:
            if not self._is_about(condition, name, span):
                continue
            narrower = self._usual.within({name: span})
            # What changes in a wait is 0 at its beginning, which is judged elsewhere.
            for facts, said in (never,) if name == self._changed else (never, always):
                possible = self._possible(wait, facts, self._usual)
                if possible and not self._possible(wait, facts, narrower):
                    return "condition.beyond", f"'{condition.text}' is {said}: {why}"
        return None

    def _ways(self, at: int, wait: Wait) -> Iterator[Limit]:
        """Yield how far the robot comes in a wait, on its route and in its time."""
        if self._route is not None:
            here_m, ever_m, why = self._route.most_m(at)
            yield self._odometry, about(ever_m), why
            if not wait.counts_on:
                yield self._changed, about(here_m), why
        fastest, there = self._fastest(wait)
        mission_s = self._loaded.program.time_limit_s
        ends_s = min([mission_s, wait.within_s, *(t.after_s for t in wait.triggers if t.after_s)])
        what = "mission" if ends_s == mission_s else "wait"
        why = f"the {what} ends after {ends_s:g} s, in which it drives less{there}"
        if not wait.counts_on:
            yield self._changed, about(fastest * ends_s), why
        if not any(wait.phase in phases for phases in self._driven):
            yield self._odometry, about(fastest * ends_s + self._no_load * BEGINNING_S), why

    def _limits(self, at: int, wait: Wait, names: Set[str]) -> Iterator[Limit]:
        """Yield the ranges of signals of these names in a wait, and the reasons."""
        if not names.isdisjoint({self._speed, change_of(self._speed), *self._of_way}):
            for name, span, why in self._lasting(*self._fastest(wait)):
                yield name, span, why
                twice = 2 if name == self._speed else 1
                yield name and change_of(name), Range(span.low * twice, span.high * twice), why
        at_wait = self._actuated(wait)
        ways = {self._way(each) for each in at_wait} if self._speed in names else set[int]()
        yield from kept_ranges(self._force, at_wait, ways, self._speed, names)
        if not names.isdisjoint(self._of_way):
            yield from self._ways(at, wait)

    def _fastest(self, wait: Wait) -> tuple[float, str]:
        """Return how fast the robot drives in a wait, m/s, and under which control, for people."""
        each = [(self._force.fastest_m_s(at), at.control) for at in self._actuated(wait)]
        fastest, control = max(each)
        if fastest >= self._no_load:
            return self._no_load, ""
        return fastest, under(self._robot, control)

    def _lasting(self, fastest: float, there: str) -> Iterator[Limit]:
        """Yield the same for limits that apply to every condition."""
        most = f"{fastest:.3g} m/s"
        usual = f"without a load the robot drives {most}"
        yield (
            self._speed,
            about(fastest),
            f"the robot drives at most {most}{there}" if there else usual,
        )
        if self._length_m < inf:
            yield self._odometry, about(self._length_m), f"the pipe is {self._length_m:.3g} m long"

    @cached_property
    def _length_m(self) -> float:
        return self._loaded.pipe.route().length_m if self._loaded.pipe is not None else inf

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
        narrower = self._usual.within({name: self._driven_to(ways, inf)})
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

    def _word(self, at: int, wait: Wait, condition: Expression) -> _Said | None:
        """Return a finding about a word that cannot occur in this pipe, or in this wait.

        A word with a condition of its own may occur anywhere.
        """
        vocabulary, free = self._robot.vocabulary, self._usual.free(condition.tree)
        names = [name for name in free if isinstance(vocabulary.types.get(name), EnumType)]
        silent = self._route.silent(at) if names and self._route is not None else ()
        for name, values, why, here in silent:
            if name not in names:
                continue
            signal = tree.Signal(name, "word", vocabulary.words.index(name))
            said: Fact = tree.Matches(signal, tuple(sorted(values))), False
            if not self._possible(wait, [(condition.tree, True), said], self._usual):
                return "word.route" if here else "word.never", f"'{condition.text}' {why}"
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
