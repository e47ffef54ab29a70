"""Rules about faults and safety rules: their conditions must depend on what happens."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from pirate_sm.checking.exploring.answers import Fact
from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.signal_ranges import Range, ranges
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.documents import Path
from pirate_sm.core.expressions import tree

_CONSTANT = {True: "this is true whatever the sensors show", False: "this can never be true"}


def fault_conditions(view: RobotView) -> Iterator[Finding]:
    """Yield fault rules, and words with a condition, that are never true or always true."""
    conditions = _conditions(view)
    rules = iter(view.loaded.normal.faults)
    for number, fault in enumerate(view.profile.faults):
        written_out = [next(rules) for _ in fault.for_each or (None,)]
        path: Path = ("faults", number, "when")
        for rule in written_out:
            verdict = _verdict(view, conditions, rule.when.tree)
            if verdict is None:
                continue
            word, never = ("always", "") if verdict else ("never", "never ")
            message = f"{_CONSTANT[verdict]}, so {fault.code} is {never}raised"
            yield view.at(path, f"robot.fault_{word}", message, offset=0)
            break
    for said in view.loaded.normal.word_conditions:
        if (verdict := _verdict(view, conditions, said.when.tree)) is not None:
            word, never = ("always", "") if verdict else ("never", "never ")
            message = f"{_CONSTANT[verdict]}: '{said.word}' would {never}be said"
            path = ("detector", "words", said.word, "when")
            yield view.at(path, f"robot.fault_{word}", message, offset=0)


def rule_conditions(view: RobotView) -> Iterator[Finding]:
    """Yield safety rules that no combination of states, clamps and driven wheels breaks.

    The chart alone keeps them, or their condition can never be anything else.
    """
    moments = tuple(_moments(view)) if view.loaded.rules else ()
    for number, rule in enumerate(view.loaded.rules):
        after, must, given = rule.after, rule.must, view.profile.rules[number]
        begins = not after or any(after.evaluate(*each) is True for each in moments)
        kept = {must.evaluate(*each) is not False for each in moments}
        if begins and len(kept) > 1:
            continue
        if not begins:
            spoken = "never applies: nothing can break it"
        elif kept == {False} and not given.expect:
            spoken = "is broken whatever is commanded"
        else:
            spoken = "is kept by every command: nothing can break it"
        keys = ("always", "never", "expect") if begins else ("after",)
        path = ("rules", number, next(key for key in keys if getattr(given, key)))
        yield view.at(path, "robot.rule_never", f"the rule '{rule.name}' {spoken}", offset=0)


def _moments(view: RobotView) -> Iterator[tuple[tuple[float, ...], tuple[str | None, ...]]]:
    """Yield the numbers and words that rules may see: after no command, and after each."""
    robot, table = view.loaded.normal, view.loaded.table
    driven, idle = set[tuple[int, str, int]](), set[tuple[int, str, int]]()
    staged = {(each.region, each.state) for each in view.written if each.stage}
    for each in view.written:
        if each.write.slot in robot.safe_zero:
            key = each.region, each.state, each.write.slot
            if each.write.turns or each.write.how == "keep":
                driven.add(key)
            if not each.write.turns or key[:2] in staged:  # perhaps in another stage
                idle.add(key)
    commands: dict[int, set[str | None]] = {}
    for number, name in enumerate(table.commands):
        for _, after in view.moves(number):
            commands.setdefault(after, {None}).add(name)
    for index, states in enumerate(table.configurations):
        most = sum(states[region] == state for region, state, _ in driven)
        least = sum(states[region] == state for region, state, _ in driven - idle)
        clamps = len(robot.held[index])
        for confirmed, turning in product(range(clamps + 1), range(least, most + 1)):
            numbers = float(clamps), float(confirmed), float(turning)
            for command in commands.get(index, {None}):
                yield numbers, (*states, command)


def _conditions(view: RobotView, *, rim_m_s: bool = False) -> Conditions:
    """Return what conditions can be, but for the angles of joints.

    A rule may look for a joint beyond its end stop, which only a faulty sensor shows, and for a
    speed beyond that of its wheels, unless ``rim_m_s``.
    """
    robot = view.loaded.normal
    joints = {joint.name for joint in view.profile.body.joints}
    known = ranges(view.profile, robot)
    spans = {name: span for name, span in known.items() if name not in joints}
    if rim_m_s and robot.speed >= 0:
        top_m_s = max(each.top_m_s for each in robot.wheels)
        spans[robot.vocabulary.numbers[robot.speed]] = Range(-top_m_s, top_m_s)
    return Conditions(robot.vocabulary, spans, len(robot.regions))


def _verdict(view: RobotView, conditions: Conditions, node: tree.Node) -> bool | None:
    """Return the constant value of the condition for known signals; None if it varies."""
    signals = [each for each in tree.walk(node) if isinstance(each, tree.Signal)]
    known: list[Fact] = [(tree.Known(each), True) for each in dict.fromkeys(signals)]
    seen = view.configurations({each.name for each in signals})
    true_in = [states for states in seen if conditions.ask([(node, True)], states).possible]
    if not true_in:
        return False
    if not any(conditions.ask([(node, False), *known], states).possible for states in seen):
        return True
    if not any(each.kind == "number" for each in signals):
        return None
    # By the speeds that motors reach it may be true whatever happens, where its states are.
    usual = _conditions(view, rim_m_s=True)
    if not any(usual.ask([(node, False), *known], states).possible for states in true_in):
        return True
    return None
