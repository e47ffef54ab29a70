"""Parts of English sentences: durations, lists, numbers, full stops."""

from __future__ import annotations


def seconds(duration_s: float) -> str:
    """Return a duration in words: ``0.52 s``, ``12.3 s``, ``4 min 05 s``."""
    if duration_s >= 119.5:
        minutes, rest = divmod(round(duration_s), 60)
        return f"{minutes} min {rest:02d} s"
    return f"{duration_s:.2f} s" if duration_s < 9.95 else f"{duration_s:.1f} s"


def number_of(count: int, one: str, more: str) -> str:
    """Return a number with the singular or the plural of a word."""
    return f"{count} {one if count == 1 else more}"


def sentence(text: str) -> str:
    """Return the text with a capital first letter and a full stop."""
    return full_stop(text[:1].upper() + text[1:])


def full_stop(text: str) -> str:
    """Return the text with a full stop, unless it ends a sentence already."""
    return text if text.endswith((".", "!", "?", "…")) else f"{text}."
