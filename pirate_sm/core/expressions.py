"""Conditions and formulas, compiled and typed with units."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._expressions import (
    BOOLEAN,
    EnumType,
    Expression,
    ExpressionError,
    NumberType,
    Vocabulary,
    compile_condition,
    compile_expression,
    machine,
    tree,
)
from pirate_sm.core._expressions.compiler import Code, depth_of
from pirate_sm.core._expressions.machine import DEEPEST
from pirate_sm.core._expressions.parser import Token, tokenize
from pirate_sm.core._expressions.vocabulary import FUNCTIONS, KEYWORDS, change_of
