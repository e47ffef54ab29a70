"""Rules about the behaviour that a profile describes: commands, faults, safety rules, signs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from pirate_sm.checking.actuation_in_force import Actuated
from pirate_sm.checking.exploring.conditions import Conditions, Fact
from pirate_sm.checking.exploring.signal_ranges import Range, ranges
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.robot.robot_view import RobotView
from pirate_sm.core.documents import LoadError, Path, read_document
from pirate_sm.core.errors import UsageError
from pirate_sm.core.expressions import tree
from pirate_sm.core.library import find_mission
from pirate_sm.core.loading import references
from pirate_sm.core.robot import HeldSpec, SeenSpec

# --- commands ------------------------------------------------------------------------------------


def command_targets(view: RobotView) -> Iterator[Finding]:
    """Yield commands whose `asks_for` does not describe the states that they lead to."""
    table, unneeded = view.loaded.table, view.loaded.normal.unneeded
    for number, name in enumerate(table.commands):
        if view.profile.commands[name].asks_for.strip() == "false":
            continue  # a toggle is never unneeded
        message = ""
        met = [row[number] for row in unneeded]
        if not any(met):
            message = f"no combination of states is ever what {name} asks for"
        elif all(met):
            message = f"every combination of states is what {name} asks for"
        else:
            missed = [after for _, after in view.moves(number) if not met[after]]
            if missed:
                pairs = zip(table.regions, table.configurations[missed[0]], strict=True)
                states = ", ".join(f"{region} {state}" for region, state in pairs)
                message = f"{name} leads to {states}, which is not what it asks for"
        if message:
            yield view.at(("commands", name, "asks_for"), "robot.asks_for", message, offset=0)


def travel_missions(view: RobotView) -> Iterator[Finding]:
    """Yield missions and states of `travel` that are not there, and a `last` without its way."""
    travel, table = view.profile.travel, view.loaded.table
    if travel is None:
        return
    named: list[tuple[Path, str]] = [(("last",), travel.last)]
    named += [(("turns", n, "call"), each.call) for n, each in enumerate(travel.turns)]
    for number, passage in enumerate(travel.passages):
        calls = enumerate(passage.calls)
        named += [(("passages", number, "calls", place), call) for place, call in calls]
    for path, name in named:
        message = ""
        try:
            file = find_mission(name, view.loaded.folder)
            mission = read_document(references.followed(file, view.loaded.folder)).data
            parameters = mission.get("parameters")
            known = parameters if isinstance(parameters, Mapping) else {}
            if path == ("last",) and "way" not in known:
                message = f"'{name}' has no parameter `way`, by which it would drive on"
        except UsageError as error:
            message = str(error)
        except (LoadError, AttributeError):
            continue  # reported for the mission
        if message:
            yield view.at(("travel", *path), "robot.reference", message)
    states = dict(zip(table.regions, table.states, strict=True))
    for region, state in travel.starts_in.items():
        if state not in states.get(region, ()):
            message = f"{region} has no state '{state}'"
            yield view.at(("travel", "starts_in", region), "robot.reference", message)


# --- faults and safety rules ---------------------------------------------------------------------


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


# --- signs of states -----------------------------------------------------------------------------


def unseen_states(view: RobotView) -> Iterator[Finding]:
    """Yield states and parts for which the profile has no criterion."""
    profile, table = view.profile, view.loaded.table
    seen = profile.seen
    if "seen" not in profile.model_fields_set:
        message = "the profile does not say how sensors show the robot's states: add `seen`"
        yield view.at(("robot",), "robot.unseen", message, key=True)
        return
    for region, states in zip(table.regions, table.states, strict=True):
        missing = [state for state in states if state not in seen.states.get(region, {})]
        if missing:
            path: Path = ("seen", "states", region) if region in seen.states else ("seen",)
            message = f"`seen` has no criterion for {region}: {', '.join(missing)}"
            yield view.at(path, "robot.unseen", message, key=True)
    parts = [name for name in profile.body.parts if name not in seen.parts]
    if parts:
        message = f"`seen` has no criterion for held parts: {', '.join(parts)}"
        path = ("seen", "parts") if seen.parts else ("seen",)
        yield view.at(path, "robot.unseen", message, key=True)


def impossible_signs(view: RobotView) -> Iterator[Finding]:
    """Yield criteria that the sensors can never meet, or never for long enough."""
    robot = view.loaded.normal
    seen = [spec for each in robot.sight.states for spec in each.values() if spec.needs]
    lasting = [each.for_s for each in (*robot.sight.parts, *seen) if each is not None]
    if lasting and min(lasting) >= robot.sight.within_s:
        message = f"nothing can be confirmed: {_too_long(view, min(lasting))}"
        yield view.at(("seen", "within"), "robot.seen_never", message)
        return
    for number, held in enumerate(robot.sight.parts):
        if held is not None:
            path: Path = ("seen", "parts", robot.parts[number])
            yield from _said(view, path, robot.parts[number], _part(view, number, held))
    for number, states in enumerate(robot.sight.states):
        region = robot.regions[number]
        for name, spec in states.items():
            about = f"{region} {name}"
            yield from _said(view, ("seen", "states", region, name), about, _state(view, spec))


def _said(
    view: RobotView, path: Path, about: str, reasons: Iterable[tuple[str, str]]
) -> Iterator[Finding]:
    """Yield a finding about the first of the reasons, each of which has a key."""
    for key, why in reasons:
        if why:
            message = f"this can never confirm '{about}': {why}"
            yield view.at((*path, key), "robot.seen_never", message)
            return


def _part(view: RobotView, part: int, spec: HeldSpec) -> Iterator[tuple[str, str]]:
    yield "for", _too_long(view, spec.for_s)
    needed = [index for joint in spec.joints for index in (joint.torque, joint.rate)]
    yield "loaded", view.unmeasured([*needed, spec.diameter, spec.apex])
    yield "torque", _too_strong(view, part, spec)
    if spec.open_rad <= 0:
        yield "end_stop", "its apex is never farther than this from its end stop"


def _state(view: RobotView, spec: SeenSpec) -> Iterator[tuple[str, str]]:
    if spec.needs is not None:
        yield "for", _too_long(view, spec.for_s)
        yield "kind", view.unheard(spec.needs)


def _too_long(view: RobotView, for_s: float) -> str:
    within_s = view.loaded.normal.sight.within_s
    if for_s < within_s:
        return ""
    return f"it must hold for {for_s:g} s, but the start check takes only {within_s:g} s"


def _too_strong(view: RobotView, part: int, spec: HeldSpec) -> str:
    """Return why no state that holds the part gives the required torque; empty if one does."""
    robot = view.loaded.normal
    holding = [number for number, held in enumerate(robot.held) if part in held]
    for joint in spec.joints:
        most = max((view.in_force.most_nm(Actuated(n), joint.slot) for n in holding), default=0.0)
        if most <= joint.needed_nm:
            return (
                f"its motor gives '{view.profile.slots[joint.slot].joint}' at most"
                f" {most:.3g} Nm there, and {joint.needed_nm:.3g} Nm are asked for"
            )
    return ""
