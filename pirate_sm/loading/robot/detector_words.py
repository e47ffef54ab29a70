"""Resolve the words of a detector: their conditions, and what they mean for a passed bend."""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.engine.robot.robot_spec import WordCondition
from pirate_sm.expressions import ExpressionError, compile_condition
from pirate_sm.loading.robot.signals import Signals
from pirate_sm.model import profile as model


def resolve_words(signals: Signals) -> tuple[WordCondition, ...]:
    """Return the conditions of the words that have one, in the profile's order; report faults."""
    return tuple(_conditions(signals))


def _conditions(signals: Signals) -> Iterator[WordCondition]:
    for name, word in signals.profile.detector.words.items():
        if word.when is None:
            continue
        try:
            when = compile_condition(word.when, signals.vocabulary)
        except ExpressionError as error:
            signals.problems.add_expression(("detector", "words", name, "when"), error)
            continue
        yield WordCondition(name, when, word.held)


def words_behind(profile: model.Profile) -> frozenset[str]:
    """Return the detector's words that mean that the last wheel has passed the bend."""
    last = profile.body.wheels[-1].name
    return frozenset(
        name
        for name, word in profile.detector.words.items()
        if word.forward and word.forward.wheel == last and word.forward.passed >= 0.0
    )
