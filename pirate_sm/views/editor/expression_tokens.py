"""The words of conditions inside YAML, by their kinds, for colours in an editor."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

from lsprotocol.types import SemanticTokenTypes

from pirate_sm.core.documents import Document, YamlNode
from pirate_sm.core.expressions import FUNCTIONS, KEYWORDS, ExpressionError, Token, tokenize
from pirate_sm.core.model_keys import condition_keys
from pirate_sm.views.editor.positions import Positions

_T = SemanticTokenTypes
TYPES: Final = [
    _T.Variable, _T.Parameter, _T.Number, _T.Operator, _T.Keyword, _T.Function, _T.EnumMember,
]  # fmt: skip
"""The kinds of words, which the editor gets once; after that their numbers."""

_OF_TOKENS: Final = {"number": _T.Number, "parameter": _T.Parameter, "operator": _T.Operator}


class Leaf(NamedTuple):
    """A text in a file, as it is written there.

    Attributes:
        key: The key that it, or its list, belongs to.
        start: Where it begins.
    """

    key: str
    start: int
    text: str

    @property
    def tokens(self) -> list[Token]:
        """Return the words of the condition; none for other texts and faulty conditions."""
        try:
            return tokenize(self.text)[:-1] if self.key in condition_keys() else []
        except ExpressionError:
            return []


def leaves(document: Document) -> Iterator[Leaf]:
    """Yield the texts of a file that stand on one line, without escapes."""
    return _leaves(document, document.root, "")


def _leaves(document: Document, node: YamlNode, key: str) -> Iterator[Leaf]:
    if isinstance(node.children, dict):
        inside = [(name, inner) for name, (inner, _, _) in node.children.items()]
    else:
        inside = [(key, inner) for inner in node.children or ()]
    for name, inner in inside:
        if node.start <= inner.start <= node.end:  # no alias, which stands elsewhere
            yield from _leaves(document, inner, name)
    if isinstance(node.value, str):
        start = node.start + document.text.startswith(('"', "'"), node.start)
        if node.value and document.text.startswith(node.value, start):
            yield Leaf(key, start, node.value)


def encoded(document: Document, positions: Positions) -> list[int]:
    """Return the words of all conditions as the protocol has them: each after the one before."""
    data, line, character = list[int](), 0, 0
    for leaf in sorted(leaves(document), key=lambda each: each.start):
        before, listed = "", False
        for token in leaf.tokens:
            begin = leaf.start + token.offset
            where = positions.between(begin, begin + len(token.text))
            new = where.start.line != line
            character = 0 if new else character
            data += [where.start.line - line, where.start.character - character]
            length = where.end.character - where.start.character
            data += [length, TYPES.index(_type(token, listed or before in ("==", "!="))), 0]
            line, character = where.start.line, where.start.character
            before, listed = token.text, token.text == "in" or (listed and token.text != ")")
    return data


def _type(token: Token, is_compared: bool) -> SemanticTokenTypes:
    """Return the kind of a word; a name that a signal is compared with is a word of that."""
    if token.kind != "name":
        return _OF_TOKENS.get(token.kind, _T.Operator)
    if token.text in KEYWORDS:
        return _T.Keyword
    if token.text in FUNCTIONS:
        return _T.Function
    return _T.EnumMember if is_compared else _T.Variable
