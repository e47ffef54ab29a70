"""Compile commands, held parts, rules of faults and of safety."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pirate_sm.core._engine import safety as watched
from pirate_sm.core._engine.mission.program import RuleSpec
from pirate_sm.core._engine.robot.robot_spec import (
    ChartTable,
    CommandSpec,
    FaultSpec,
    Owners,
    PostureSpec,
)
from pirate_sm.core._engine.sensing.board_spec import board_name
from pirate_sm.core._expressions import (
    EnumType,
    Expression,
    ExpressionError,
    NumberType,
    Vocabulary,
    compile_condition,
)
from pirate_sm.core._expressions.tree import Not
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.criteria import resolve_criterion
from pirate_sm.core._loading.robot.signals import Signals
from pirate_sm.core._model.faults import BuiltInFault
from pirate_sm.core._model.mission import Mission
from pirate_sm.core._model.robot import profile as model
from pirate_sm.core.spelling import one_of
from pirate_sm.core.units import (
    ANGLE,
    ANGULAR_SPEED,
    CURRENT,
    DIMENSIONLESS,
    SPEED,
    TORQUE,
    Quantity,
)


def resolve_parts(
    table: ChartTable, signals: Signals
) -> tuple[tuple[str, ...], tuple[frozenset[int], ...], tuple[frozenset[int], ...]]:
    """Return the parts, those held in each configuration, and the regions that hold each part."""
    conditions = []
    for name, part in signals.profile.body.parts.items():
        path: Path = ("body", "parts", name, "held")
        conditions.append(on_states(part.held, table, signals, path))
        joints = [joint.name for joint in signals.profile.body.joints]
        if part.apex not in joints:
            signals.problems.add_unknown(
                "robot.joint", ("body", "parts", name, "apex"), "joint", part.apex, joints
            )
    held = tuple(
        frozenset(i for i, condition in enumerate(conditions) if is_true(condition, states))
        for states in table.configurations
    )
    for number, name in enumerate(signals.profile.body.parts):
        if conditions[number] is not None and not any(number in parts for parts in held):
            path = ("body", "parts", name, "held")
            signals.problems.add(
                "robot.condition", path, f"no configuration ever holds the part '{name}'"
            )
    regions = tuple(
        frozenset(table.regions.index(name) for name in condition.names)
        if condition
        else frozenset()
        for condition in conditions
    )
    return tuple(signals.profile.body.parts), held, regions


def resolve_commands(
    table: ChartTable,
    held: tuple[frozenset[int], ...],
    signals: Signals,
    postures: Mapping[str, tuple[PostureSpec | None, ...]],
) -> tuple[tuple[CommandSpec, ...], tuple[tuple[bool, ...], ...]]:
    """Return the commands, and per configuration which of them are unneeded."""
    specs: list[CommandSpec] = []
    unneeded: list[list[bool]] = []
    for name in table.commands:
        command = signals.profile.commands[name]
        path: Path = ("commands", name)
        asks = on_states(command.asks_for, table, signals, (*path, "asks_for"))
        done = resolve_criterion(command.done, signals, (*path, "done"))
        met = [is_true(asks, states) for states in table.configurations]
        parts = [parts for parts, is_met in zip(held, met, strict=True) if is_met]
        every = frozenset.intersection(*parts) if parts else frozenset[int]()
        unneeded.append(met)
        posture = command.posture
        if posture is not None and posture not in postures:
            signals.problems.add_unknown(
                "robot.name", (*path, "posture"), "posture", posture, postures, none="no posture"
            )
        specs.append(
            CommandSpec(
                name,
                done,
                command.timeout,
                command.nominal,
                command.lets_go,
                postures.get(posture or "", ()),
                asks,
                every,
            )
        )
    return tuple(specs), tuple(zip(*unneeded, strict=True))


def resolve_owners(signals: Signals) -> Owners:
    """Return the boards, joints, wheels and parts that a fault can be of."""
    profile, names = signals.profile, signals.vocabulary.numbers
    drives = {slot.name: slot.drives for slot in profile.slots}
    things: dict[str, frozenset[str]] = {}
    measured: dict[int, str] = {}
    for board in profile.heard:
        name = board_name(board.id)
        of = {
            names.index(each.signal): drives.get(each.slot or "") or name
            for each in board.channels
            if each.signal
        }
        measured |= of
        things[name] = frozenset(of.values()) or frozenset({name})
    body = profile.body
    for part in body.parts:
        joints = {joint.name for joint in body.joints if joint.part == part}
        things[part] = frozenset(joints | {each.name for each in body.wheels if each.part == part})
    things |= {name: frozenset({name}) for name in drives.values() if name}
    return Owners(things, measured)


def resolve_faults(signals: Signals, parts: Sequence[str], owners: Owners) -> tuple[FaultSpec, ...]:
    """Return the fault rules, with one rule for each number of a ``for_each``.

    Conditions may use the numbers of :func:`constants_of`.
    """
    rules: list[FaultSpec] = []
    constants = constants_of(signals.profile)
    for number, fault in enumerate(signals.profile.faults):
        denies = frozenset(_denied(fault, number, parts, signals.problems))
        for index in fault.for_each or (None,):
            when, message = fault.when, fault.message
            if index is not None:
                when, message = when.replace("{i}", str(index)), message.replace("{i}", str(index))
            try:
                condition = compile_condition(when, signals.vocabulary, constants)
            except ExpressionError as error:
                signals.problems.add_expression(("faults", number, "when"), error)
                break
            _check_catchable(fault, number, rules, signals.problems)
            of = tuple(name.replace("{i}", str(index)) for name in fault.of)
            for place, name in enumerate(of):
                if name not in owners.things:
                    path: Path = ("faults", number, "of", place)
                    kind = "board, joint, wheel or part"
                    signals.problems.add_unknown("robot.name", path, kind, name, owners.things)
            of = of or fault.denies
            rules.append(
                FaultSpec(fault.code, message, condition, fault.held, fault.catchable, denies, of)
            )
    return tuple(rules)


def constants_of(profile: model.Profile) -> dict[str, Quantity]:
    """Return the numbers of the robot that conditions may use, by name.

    ``$JOINT_stop`` is a joint's end stop; ``$JOINT_stall`` and ``$JOINT_stall_current`` what its
    motor bears and draws at full duty when it stands, likewise of a wheel. ``$WHEEL_no_load`` and
    ``$WHEEL_no_load_rim`` are the speeds of its motor and its rim at full duty without load.
    """
    found = {f"{joint.name}_stop": Quantity(joint.end_stop, ANGLE) for joint in profile.body.joints}
    for slot in profile.slots:
        motor, driven = profile.motors.get(slot.motor), slot.joint or slot.wheel
        if motor is None or driven is None:
            continue
        if motor.stall_torque is not None:
            found[f"{driven}_stall"] = Quantity(motor.stall_torque, TORQUE)
        if motor.stall_current is not None:
            found[f"{driven}_stall_current"] = Quantity(motor.stall_current, CURRENT)
        if slot.wheel is not None and motor.no_load_speed is not None:
            rim_m_s = motor.no_load_speed * profile.body.wheel_radius
            found[f"{driven}_no_load"] = Quantity(motor.no_load_speed, ANGULAR_SPEED)
            found[f"{driven}_no_load_rim"] = Quantity(rim_m_s, SPEED)
    return found


def _denied(
    fault: model.FaultRule, number: int, parts: Sequence[str], problems: Problems
) -> Iterator[int]:
    """Yield the indexes of the parts whose clamps the fault denies."""
    for place, name in enumerate(fault.denies):
        if name in parts:
            yield parts.index(name)
            continue
        message = f"the robot has no part '{name}' that a chart state holds"
        at: Path = ("faults", number, "denies", place)
        problems.add_unknown("robot.name", at, "part", name, sorted(parts), message=message)


def _check_catchable(
    fault: model.FaultRule, number: int, rules: list[FaultSpec], problems: Problems
) -> None:
    """Report a code that is catchable in one rule and not in another."""
    known = {each.code: each.catchable for each in (*rules, *BuiltInFault)}
    if known.get(fault.code, fault.catchable) != fault.catchable:
        can, must = ("can", "true") if known[fault.code] else ("cannot", "false")
        key = "catchable" if "catchable" in fault.model_fields_set else "code"
        message = f"'{fault.code}' {can} be caught: `catchable` must be {must} here too"
        problems.add("robot.fault", ("faults", number, key), message)


def on_states(text: str, table: ChartTable, signals: Signals, path: Path) -> Expression | None:
    """Return a condition on the states of the regions; None after reporting other names."""
    try:
        condition = compile_condition(text, signals.vocabulary)
    except ExpressionError as error:
        signals.problems.add_expression(path, error)
        return None
    others = sorted(condition.names - set(table.regions))
    if others:
        message = f"only states count here, not {', '.join(others)}"
        signals.problems.add("robot.condition", path, message, expected=one_of(table.regions))
        return None
    return condition


def is_true(condition: Expression | None, states: tuple[str, ...]) -> bool:
    """Return whether a condition on the regions is true in these states."""
    return condition is not None and condition.evaluate((), states) is True


def resolve_rules(
    profile: model.Profile, table: ChartTable, problems: Problems
) -> tuple[RuleSpec, ...]:
    """Return all rules with compiled conditions; report rules with faults."""
    if not profile.rules:
        return ()
    kinds: dict[str, NumberType | EnumType] = {
        name: EnumType(states) for name, states in zip(table.regions, table.states, strict=True)
    }
    kinds[watched.COMMAND] = EnumType(table.commands)
    for name in watched.NUMBERS:
        if name in kinds:
            problems.add("robot.name", ("rules",), f"the region '{name}' hides a word of rules")
        kinds[name] = NumberType(DIMENSIONLESS)
    vocabulary = Vocabulary(kinds)
    found = []
    names: set[str] = set()
    for number, rule in enumerate(profile.rules):
        path: Path = ("rules", number)
        if rule.rule in names:
            problems.add("robot.rule", (*path, "rule"), f"'{rule.rule}' names another rule too")
        names.add(rule.rule)
        spec = _rule(rule, vocabulary, path, problems)
        if spec is not None:
            found.append(spec)
    return tuple(found)


def rules_for(mission: Mission, rules: tuple[RuleSpec, ...]) -> tuple[RuleSpec, ...]:
    """Return the rules without those that the mission waives with a reason."""
    return tuple(
        rule
        for rule in rules
        if not (rule.waived_by and getattr(mission, rule.waived_by) is not None)
    )


def _rule(
    rule: model.SafetyRule, vocabulary: Vocabulary, path: Path, problems: Problems
) -> RuleSpec | None:
    key = next(key for key in ("always", "never", "expect") if getattr(rule, key) is not None)
    text: str = getattr(rule, key)
    must = _condition(text, vocabulary, problems, path, key)
    after = None
    if rule.after is not None:
        after = _condition(rule.after, vocabulary, problems, path, "after")
        if after is None:
            return None
    if must is None:
        return None
    said = f"{key} {text}"
    if rule.within_steps is not None:
        said = f"expect {text} within {rule.within_steps} steps"
    if rule.after is not None:
        said += f" after {rule.after}"
    return RuleSpec(rule.rule, said, after, must, rule.within_steps, rule.why, rule.waived_by or "")


def _condition(
    text: str, vocabulary: Vocabulary, problems: Problems, path: Path, key: str
) -> Expression | None:
    """Return the compiled condition, negated for ``never``."""
    try:
        condition = compile_condition(text, vocabulary)
    except ExpressionError as error:
        problems.add_expression((*path, key), error)
        return None
    if key == "never":
        return Expression(f"not ({text})", condition.type, Not(condition.tree))
    return condition
