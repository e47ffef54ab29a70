"""Rules about faults and safety rules: their conditions must depend on what happens."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.exploring.answers import Fact
from pirate_sm.checking.exploring.conditions import Conditions
from pirate_sm.checking.exploring.signal_ranges import ranges
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.expressions import tree


def fault_conditions(view: RobotView) -> Iterator[Finding]:
    """Yield fault rules that are never true or always true."""
    conditions = _conditions(view)
    rules = iter(view.loaded.normal.faults)
    for number, fault in enumerate(view.profile.faults):
        written_out = [next(rules) for _ in fault.for_each or (None,)]
        path = ("faults", number, "when")
        for rule in written_out:
            verdict = _verdict(view, conditions, rule.when.tree)
            if verdict is None:
                continue
            word = "always" if verdict else "never"
            message = f"this can {'only' if verdict else 'never'} be true, so {fault.code} is"
            message += " raised whatever happens" if verdict else " never raised"
            yield view.at(path, f"robot.fault_{word}", message, offset=0)
            break


def rule_conditions(view: RobotView) -> Iterator[Finding]:
    """Yield safety rules that no combination of states, clamps and driven wheels breaks.

    The chart alone keeps them, or their condition can never be anything else.
    """
    for number, rule in enumerate(view.loaded.rules):
        after, must, given = rule.after, rule.must, view.profile.rules[number]
        begins = not after or any(after.evaluate(*each) is True for each in _moments(view))
        if not begins or all(must.evaluate(*each) is not False for each in _moments(view)):
            spoken = "is kept by every command" if begins else "never applies"
            keys = ("always", "never", "expect") if begins else ("after",)
            path = ("rules", number, next(key for key in keys if getattr(given, key)))
            message = f"the rule '{rule.name}' {spoken}: nothing can break it"
            yield view.at(path, "robot.rule_never", message, offset=0)


def _moments(view: RobotView) -> Iterator[tuple[tuple[float, ...], tuple[str | None, ...]]]:
    """Yield the numbers and words that rules may see: after no command, and after each."""
    robot, table = view.loaded.normal, view.loaded.table
    driven = {
        (each.region, each.state, each.write.slot) for each in view.written if each.write.turns
    }
    commands: dict[int, set[str | None]] = {}
    for number, name in enumerate(table.commands):
        for _, after in view.moves(number):
            commands.setdefault(after, {None}).add(name)
    for index, states in enumerate(table.configurations):
        turning = {slot for region, state, slot in driven if states[region] == state}
        clamps = len(robot.held[index])
        for confirmed in range(clamps + 1):
            numbers = float(clamps), float(confirmed), float(len(turning & set(robot.safe_zero)))
            for command in commands.get(index, {None}):
                yield numbers, (*states, command)


def _conditions(view: RobotView) -> Conditions:
    """Return what conditions can be, but for the angles of joints.

    A rule may look for a joint beyond its end stop, which only a faulty sensor shows.
    """
    robot = view.loaded.normal
    joints = {joint.name for joint in view.profile.body.joints}
    known = ranges(view.profile, robot)
    spans = {name: span for name, span in known.items() if name not in joints}
    return Conditions(robot.vocabulary, spans, len(robot.regions))


def _verdict(view: RobotView, conditions: Conditions, node: tree.Node) -> bool | None:
    """Return the constant value of the condition for known signals; None if it varies."""
    signals = [each for each in tree.walk(node) if isinstance(each, tree.Signal)]
    known: list[Fact] = [(tree.Known(each), True) for each in dict.fromkeys(signals)]
    seen = view.configurations({each.name for each in signals})
    if not any(conditions.ask([(node, True)], states).possible for states in seen):
        return False
    if not any(conditions.ask([(node, False), *known], states).possible for states in seen):
        return True
    return None
