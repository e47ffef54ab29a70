"""A rule about faults: the condition of a fault rule must depend on the signals."""

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
