"""Compile the safety rules of a robot for :mod:`pirate_sm.core._engine.safety.rules`."""

from __future__ import annotations

from pirate_sm.core._engine.mission.program import RuleSpec
from pirate_sm.core._engine.robot.robot_spec import ChartTable
from pirate_sm.core._engine.safety import rules as watched
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
from pirate_sm.core._model.mission import Mission
from pirate_sm.core._model.profile import Profile
from pirate_sm.core._model.safety import SafetyRule
from pirate_sm.core.units import DIMENSIONLESS


def resolve_rules(profile: Profile, table: ChartTable, problems: Problems) -> tuple[RuleSpec, ...]:
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
    rule: SafetyRule, vocabulary: Vocabulary, path: Path, problems: Problems
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
