"""Resolve names, words, types and dimensions in the syntax; report all faults at once."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, NamedTuple, cast

from pirate_sm.core._expressions import tree
from pirate_sm.core._expressions.parser import (
    AnyPart,
    ArithmeticPart,
    CallPart,
    ComparisonPart,
    ExpressionError,
    ExpressionFault,
    LogicPart,
    MembershipPart,
    NamePart,
    NumberPart,
    OperationPart,
    ParameterPart,
    TruthPart,
    UnaryPart,
    refusal,
)
from pirate_sm.core._expressions.vocabulary import (
    BOOLEAN,
    BooleanType,
    Constant,
    EnumType,
    NumberType,
    Type,
    Vocabulary,
    change_of,
)
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.core.units import DIMENSIONLESS, Dimension, example

DEEPEST_TREE: Final = 48  # keeps the generated code within the limits of Python's parser


class Typed(NamedTuple):
    """A node of the tree with its type."""

    node: tree.Node
    type: Type


def analyse(part: AnyPart, vocabulary: Vocabulary, parameters: Mapping[str, Constant]) -> Typed:
    """Return the typed tree of an expression.

    Raises:
        ExpressionError: Names are unknown, or types or dimensions do not fit.
    """
    analysis = _Analysis(vocabulary, parameters)
    typed = analysis.value(part)
    if analysis.faults or typed is None:
        raise ExpressionError(analysis.faults)
    return typed


class _Analysis:
    """Walks the syntax; a result of None means that a fault is already recorded."""

    def __init__(self, vocabulary: Vocabulary, parameters: Mapping[str, Constant]) -> None:
        self.faults: list[ExpressionFault] = []
        self._vocabulary = vocabulary
        self._parameters = parameters
        self._depth = 0

    def _fault(self, part: AnyPart, message: str, suggestion: str = "") -> None:
        self.faults.append(ExpressionFault(message, part.offset, suggestion, part.length))

    def value(self, part: AnyPart) -> Typed | None:
        """Return the typed node of a part of any type."""
        self._depth += 1
        if self._depth > DEEPEST_TREE:
            message = f"the expression is nested deeper than {DEEPEST_TREE} levels"
            raise refusal(message, part.offset)
        typed = self._value(part)
        self._depth -= 1
        return typed

    def _value(self, part: AnyPart) -> Typed | None:
        match part:
            case NumberPart(quantity=quantity):
                return Typed(tree.Number(quantity.value), NumberType(quantity.dimension))
            case TruthPart():
                return Typed(tree.TruthValue(part.value), BOOLEAN)
            case NamePart():
                return self._signal(part)
            case ParameterPart():
                return self._parameter(part)
            case _:
                return self._operation(part)

    def _operation(self, part: OperationPart) -> Typed | None:
        match part:
            case UnaryPart():
                return self._unary(part)
            case ArithmeticPart():
                return self._arithmetic(part)
            case ComparisonPart():
                return self._comparison(part)
            case MembershipPart():
                return self._membership(part)
            case LogicPart():
                return self._logic(part)
            case CallPart():
                return self._call(part)

    def _unary(self, part: UnaryPart) -> Typed | None:
        if part.operator == "not":
            condition = self._condition(part.operand, "'not'")
            return Typed(tree.Not(condition), BOOLEAN) if condition else None
        number = self._number(part.operand, "'-'")
        return Typed(tree.Negate(number.node), number.type) if number else None

    def _signal(self, part: NamePart) -> Typed | None:
        kind = self._vocabulary.types.get(part.name)
        if kind is None:
            self._fault(part, f"unknown name '{part.name}'", self._nearest_name(part.name))
            return None
        slot = self._vocabulary.slot(part.name)
        return Typed(tree.Signal(part.name, slot.kind, slot.index), kind)

    def _nearest_name(self, name: str) -> str:
        return nearest(name, [*self._vocabulary.types, "true", "false"]) or ""

    def _parameter(self, part: ParameterPart) -> Typed | None:
        constant = self._constant(part)
        if constant is None:
            return None
        if isinstance(constant, bool):
            return Typed(tree.TruthValue(constant), BOOLEAN)
        if isinstance(constant, str):
            message = f"'${part.name}' is a word: it can only be compared with == or in"
            self._fault(part, message)
            return None
        return Typed(tree.Number(constant.value), NumberType(constant.dimension))

    def _constant(self, part: ParameterPart) -> Constant | None:
        if part.name not in self._parameters:
            close = nearest(part.name, self._parameters)
            suggestion = f"${close}" if close else ""
            self._fault(part, f"there is no parameter '${part.name}'", suggestion)
            return None
        return self._parameters[part.name]

    def _condition(self, part: AnyPart, user: str) -> tree.Node | None:
        """Return the node of a part that must be a condition."""
        typed = self.value(part)
        if typed is None:
            return None
        if not isinstance(typed.type, BooleanType):
            message = f"{user} needs a condition, not {self._named(part, typed)}"
            self._fault(part, message + self._comparison_hint(part, typed))
            return None
        return typed.node

    def _number(self, part: AnyPart, user: str) -> Typed | None:
        """Return the typed node of a part that must be a number."""
        typed = self.value(part)
        if typed is None:
            return None
        if not isinstance(typed.type, NumberType):
            self._fault(part, f"{user} needs a number, not {self._named(part, typed)}")
            return None
        return typed

    @staticmethod
    def _named(part: AnyPart, typed: Typed) -> str:
        return f"'{part.name}', {typed.type}" if isinstance(part, NamePart) else f"{typed.type}"

    @staticmethod
    def _comparison_hint(part: AnyPart, typed: Typed) -> str:
        if isinstance(part, NamePart) and isinstance(typed.type, EnumType):
            return f": compare it, as in '{part.name} == {typed.type.values[0]}'"
        return ""

    def _arithmetic(self, part: ArithmeticPart) -> Typed | None:
        user = f"'{part.operator}'"
        left, right = self._number(part.left, user), self._number(part.right, user)
        if left is None or right is None:
            return None
        above, below = _dimension(left), _dimension(right)
        operator = cast("tree.ArithmeticOperator", part.operator)
        node = tree.Arithmetic(operator, left.node, right.node)
        if operator == "*":
            return Typed(node, NumberType(above * below))
        if operator == "/":
            return Typed(node, NumberType(above / below))
        verb = "add" if operator == "+" else "subtract"
        if not self._same_dimension(part, (part.left, left), (part.right, right), verb):
            return None
        return Typed(node, left.type)

    def _same_dimension(
        self, at: AnyPart, left: tuple[AnyPart, Typed], right: tuple[AnyPart, Typed], verb: str
    ) -> bool:
        """Return whether two numbers have the same dimension; otherwise record a fault."""
        if left[1].type == right[1].type:
            return True
        for (part, typed), (_, other) in ((left, right), (right, left)):
            number = _bare_number(part)
            if number and _dimension(typed) == DIMENSIONLESS:
                unit = example(_dimension(other)).partition(" ")[2]
                message = f"'{number}' needs a unit here: the other side is {other.type}"
                self._fault(part, message, f"{number} {unit}")
                return False
        self._fault(at, f"cannot {verb} {left[1].type} and {right[1].type}")
        return False

    def _comparison(self, part: ComparisonPart) -> Typed | None:
        before, pairs = part.first, []
        for operator, offset, after in part.rest:
            sign = ComparisonPart(offset, len(operator), before, ())
            pairs.append(self._pair(sign, operator, before, after))
            before = after
        nodes = [node for node in pairs if node is not None]
        if len(nodes) < len(pairs):
            return None
        return Typed(nodes[0] if len(nodes) == 1 else tree.And(tuple(nodes)), BOOLEAN)

    def _pair(
        self, at: ComparisonPart, operator: str, left: AnyPart, right: AnyPart
    ) -> tree.Node | None:
        for part, other in ((left, right), (right, left)):
            kind = self._enum_type(part)
            if kind is not None:
                return self._word_pair(at, operator, (part, kind), other)
        if self._unknown_signal(left, right):
            return None
        user = f"'{operator}'"
        for part, other in ((left, right), (right, left)):
            if self._is_word(part) and self._number(other, user) is None:
                return None  # the fault is the unknown signal
        first, second = self._number(left, user), self._number(right, user)
        if first is None or second is None:
            return None
        if not self._same_dimension(at, (left, first), (right, second), "compare"):
            return None
        return tree.Compare(cast("tree.CompareOperator", operator), first.node, second.node)

    def _unknown_signal(self, left: AnyPart, right: AnyPart) -> bool:
        """Return whether both sides are unknown names; record a fault for one of them."""
        types = self._vocabulary.types
        names = [
            part for part in (left, right) if isinstance(part, NamePart) and part.name not in types
        ]
        if len(names) < 2:
            return False
        self._signal(next((part for part in names if not self._is_word(part)), names[0]))
        return True

    def _is_word(self, part: AnyPart) -> bool:
        """Return whether a part is a word of some signal and not the name of a signal."""
        known = self._vocabulary
        return isinstance(part, NamePart) and part.name in known.said - known.types.keys()

    def _enum_type(self, part: AnyPart) -> EnumType | None:
        kind = self._vocabulary.types.get(part.name) if isinstance(part, NamePart) else None
        return kind if isinstance(kind, EnumType) else None

    def _word_pair(
        self, at: ComparisonPart, operator: str, left: tuple[AnyPart, EnumType], other: AnyPart
    ) -> tree.Node | None:
        """Return the comparison of a signal with a word or with another word signal."""
        part, kind = left
        if operator not in ("==", "!="):
            self._fault(at, f"words have no order: '{operator}' cannot compare them", "==")
            return None
        typed = self.value(part)
        assert typed is not None
        signal = cast("tree.Signal", typed.node)
        node: tree.Node | None
        other_kind = self._enum_type(other)
        if other_kind is not None and not (
            isinstance(other, NamePart) and other.name in kind.values
        ):
            node = self._same_word(at, signal, kind, other)
        else:
            word = self._word(signal, kind, other)
            node = tree.Matches(signal, (word,)) if word else None
        return tree.Not(node) if node and operator == "!=" else node

    def _same_word(
        self, at: ComparisonPart, signal: tree.Signal, kind: EnumType, other: AnyPart
    ) -> tree.Node | None:
        typed = self.value(other)
        assert typed is not None
        second = cast("tree.Signal", typed.node)
        assert isinstance(typed.type, EnumType)
        common = [word for word in kind.values if word in typed.type.values]
        if not common:
            self._fault(at, f"'{signal.name}' and '{second.name}' have no word in common")
            return None
        return tree.Or(
            tuple(
                tree.And((tree.Matches(signal, (word,)), tree.Matches(second, (word,))))
                for word in common
            )
        )

    def _word(self, signal: tree.Signal, kind: EnumType, part: AnyPart) -> str | None:
        """Return the word that a part denotes, which must be one of the signal's words."""
        if isinstance(part, ParameterPart):
            constant = self._constant(part)
            if constant is None:
                return None
            word, shown = str(constant), f"${part.name} = {constant}"
            valid = isinstance(constant, str) and word in kind.values
        elif isinstance(part, NamePart):
            word = shown = part.name
            valid = word in kind.values
        else:
            self._fault(part, f"'{signal.name}' is a word: {one_of(kind.values)}")
            return None
        if valid:
            return word
        message = f"'{signal.name}' is never '{shown}', only {one_of(kind.values)}"
        self._fault(part, message, nearest(word, kind.values) or "")
        return None

    def _membership(self, part: MembershipPart) -> Typed | None:
        kind = self._enum_type(part.operand)
        typed = self.value(part.operand)
        if typed is None:
            return None
        if kind is None:
            message = f"'in' is for signals with words, not for {typed.type}"
            self._fault(part.operand, message)
            return None
        signal = cast("tree.Signal", typed.node)
        words = [self._word(signal, kind, item) for item in part.items]
        known = tuple(word for word in words if word is not None)
        if len(known) < len(words):
            return None
        node = tree.Matches(signal, known)
        return Typed(tree.Not(node) if part.negated else node, BOOLEAN)

    def _logic(self, part: LogicPart) -> Typed | None:
        nodes = [self._condition(item, f"'{part.operator}'") for item in part.parts]
        known = tuple(node for node in nodes if node is not None)
        if len(known) < len(nodes):
            return None
        return Typed(tree.And(known) if part.operator == "and" else tree.Or(known), BOOLEAN)

    def _call(self, part: CallPart) -> Typed | None:
        if part.function == "change":
            return self._change(part)
        single = part.function in ("abs", "known")
        if single and len(part.arguments) != 1:
            self._fault(part, f"'{part.function}' takes one value, not {len(part.arguments)}")
            return None
        if part.function == "known":
            typed = self.value(part.arguments[0])
            return Typed(tree.Known(typed.node), BOOLEAN) if typed else None
        numbers = [self._number(item, f"'{part.function}'") for item in part.arguments]
        known = [number for number in numbers if number is not None]
        if len(known) < len(numbers):
            return None
        first = (part.arguments[0], known[0])
        for item, number in zip(part.arguments[1:], known[1:], strict=True):
            if not self._same_dimension(part, first, (item, number), "compare"):
                return None
        name = cast("tree.FunctionName", part.function)
        return Typed(tree.Call(name, tuple(number.node for number in known)), known[0].type)

    def _change(self, part: CallPart) -> Typed | None:
        """Return the node for the change of a signal since a wait began."""
        if not any(name.startswith("change(") for name in self._vocabulary.types):
            message = "'change' counts from the beginning of a wait: use it in the `when` of a wait"
            self._fault(part, message)
            return None
        (signal, *others) = part.arguments
        if others or not isinstance(signal, NamePart):
            self._fault(part, "'change' takes the name of one signal, as in change(odometry)")
            return None
        number = self._number(signal, "'change'")
        if number is None:
            return None
        name = change_of(signal.name)
        slot = self._vocabulary.slot(name)
        return Typed(tree.Signal(name, slot.kind, slot.index), number.type)


def _dimension(typed: Typed) -> Dimension:
    assert isinstance(typed.type, NumberType)
    return typed.type.dimension


def _bare_number(part: AnyPart) -> str:
    """Return a number as written, with its sign; empty for any other part."""
    if isinstance(part, UnaryPart) and part.operator == "-":
        number = _bare_number(part.operand)
        return f"-{number}" if number else ""
    return part.text if isinstance(part, NumberPart) else ""
