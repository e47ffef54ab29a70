"""The roles of text on a terminal, and their colours; alone, since a check needs no other view."""

from collections.abc import Mapping

MUTED, STRONG, GOOD, WARN, BAD, ACCENT = "muted", "bold", "good", "warn", "bad", "accent"

ON_A_TERMINAL: Mapping[str, str] = {
    MUTED: "dim",
    STRONG: "bold",
    GOOD: "bright_blue",
    WARN: "yellow",
    BAD: "bright_red",
    ACCENT: "cyan",
}
"""How the roles of text look in the colours that every terminal has, and may change [decided]:
blue, yellow and red stay apart in each kind of colour vision, green and red do not."""
