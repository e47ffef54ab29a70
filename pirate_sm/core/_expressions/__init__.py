"""Compile conditions and formulas: parsed against an allowlist, typed with units.

    text → lexer → parser → syntax tree with offsets → analysis (types, units, words) → tree
         → compiler → a Python function over signal values

The language has comparisons (also chained), `and or not`, `+ - * /`, parentheses, `abs min max`,
`in (a, b)`, `known(x)`, `change(signal)` in waits, numbers with units, words, `true` and `false`,
and `$parameters`, and nothing else. Its logic is three-valued (Kleene): an expression with an
unknown signal is unknown, unless the other signals decide it.
"""

from __future__ import annotations

from pirate_sm.core._expressions.compiler import Expression, compile_condition, compile_expression
from pirate_sm.core._expressions.parser import ExpressionError, ExpressionFault
from pirate_sm.core._expressions.vocabulary import (
    BOOLEAN,
    BooleanType,
    Constant,
    EnumType,
    NumberType,
    SignalSlot,
    Vocabulary,
)

__all__ = [
    "BOOLEAN",
    "BooleanType",
    "Constant",
    "EnumType",
    "Expression",
    "ExpressionError",
    "ExpressionFault",
    "NumberType",
    "SignalSlot",
    "Vocabulary",
    "compile_condition",
    "compile_expression",
]
