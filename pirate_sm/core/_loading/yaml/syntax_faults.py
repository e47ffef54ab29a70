"""Translate YAML syntax errors into messages for people who do not know the grammar."""

from __future__ import annotations

import json
from typing import Final

import yaml

from pirate_sm.core._loading.yaml.nodes import YamlFault, YamlNode

# A part of the parser's message, our message, and the expected input.
_ADVICE: Final = (
    (
        "mapping values are not allowed",
        "a ':' is not allowed here",
        "the same indentation as the line before, or text with ': ' in quotes",
    ),
    ("entries are not allowed", "a '- ' is not allowed here", "list items on lines of their own"),
    ("tab character", "a tab cannot indent a line", "blanks"),
    ("unknown escape", "an unknown escape in double quotes", "single quotes, or '\\\\' for '\\'"),
    ("flow node", "a value, or a closing bracket, is missing", ""),
    ("node content", "no value can begin here", ""),
    ("flow sequence", "a '[' is not closed, or a ',' is missing", "',' or ']'"),
    ("flow mapping", "a '{' is not closed, or a ',' is missing", "',' or '}'"),
    ("end of stream", "a quote is not closed", "the closing quote"),
    ("expected ':'", "a ':' is missing after a key", "'key: value', with a space after the ':'"),
    (
        "block mapping",
        "this does not continue the mapping",
        "'key: value' in line with the keys above, and nothing after a closing quote",
    ),
    ("block collection", "this does not continue the list", "'- ' in line with the items above"),
)


def syntax_fault(error: yaml.MarkedYAMLError, innermost: YamlNode | None) -> YamlFault:
    """Return a syntax error as a fault with a helpful message."""
    said = f"{error.context or ''} {error.problem or ''}"
    mark, opening = error.problem_mark or error.context_mark, error.context_mark
    if ("end of stream" in said or "expected ':'" in said) and opening is not None:
        mark = opening
    line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
    if "flow" in said and innermost is not None and line > innermost.line:
        # The parser notices a missing end only some lines later, so report the beginning.
        line, column = innermost.line, innermost.column
    if "cannot start any token" in said:
        return _bad_character(error, line, column)
    for needle, message, expected in _ADVICE:
        if needle in said:
            return YamlFault("syntax", line, column, message, expected)
    return YamlFault("syntax", line, column, f"is not YAML: {error.problem or error.context}")


def _bad_character(error: yaml.MarkedYAMLError, line: int, column: int) -> YamlFault:
    """Return the fault of an invalid first character, usually a tab, '%', '@' or '`'."""
    # Only PyYAML's own parser names it; for both, a tab is what people trip over at a line start.
    if "'\\t'" in (error.problem or "") or column == 1:
        return YamlFault("syntax", line, column, "a tab cannot indent a line", "blanks")
    message = "a value cannot begin with this character"
    return YamlFault("syntax", line, column, message, "the text in quotes")


def key_fault(key: YamlNode) -> YamlFault:
    """Return the fault of a key that is not text."""
    if isinstance(key.value, dict | list):
        message = "a mapping or list cannot be a key"
        expected = "text as the key; text in braces or brackets needs quotes"
    else:
        shown = json.dumps(key.value)
        message = f"the key '{shown}' is not text"
        expected = f"text as the key; in quotes ('{shown}') it is text"
    return YamlFault("key", key.line, key.column, message, expected)
