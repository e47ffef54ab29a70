"""Shows why keys are grey: each reason once, with its keys."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import NamedTuple

from rich.text import Text

from pirate_sm.core.robot import RobotSpec
from pirate_sm.views.showing.effect_lines import shortened
from pirate_sm.views.showing.text_styles import MUTED, STRONG, line

_SIGNS = {"unneeded": "=", "impossible": "✕"}


class Request(NamedTuple):
    """A request of the operator, and why it is not available; the reason is empty if it is."""

    key: str
    reason: str


def sign_of(reason: str) -> str:
    """Return ``=`` if the state is reached already, ``✕`` if it cannot be."""
    return _SIGNS.get(reason.partition(": ")[0], "✕")


def obstacles(
    asked: Mapping[str, Sequence[Request]], robot: RobotSpec, width: int, rows: int
) -> list[Text]:
    """Return every reason in as many lines as there is room; reached states come last.

    Args:
        asked: All requests, by the name that is shown if one reason holds for all.
        robot: The robot, whose regions are shown by their short names.
        width: Width of a line.
        rows: Number of lines.
    """
    short = {
        name: [it._replace(reason=_shortened(it.reason, robot)) for it in each]
        for name, each in asked.items()
    }
    found = sorted(_grouped(short).items(), key=lambda each: each[0][0] == "=")
    heads = [f"{reason[0]} {keys}  " for reason, keys in found]
    texts = [head + reason[2:] for head, (reason, _) in zip(heads, found, strict=True)]
    lines = []
    for head, shown in zip(heads, _fitting(texts, width, rows), strict=False):
        first, *more = shown
        lines.append(line((first[: len(head)], STRONG), (first[len(head) :], MUTED)))
        lines += [line((each, MUTED)) for each in more]
    return lines if found else [line(("everything can be asked for", MUTED))]


def _grouped(asked: Mapping[str, Sequence[Request]]) -> dict[str, str]:
    """Return the keys of each reason."""
    found: dict[str, list[str]] = {}
    for name, each in asked.items():
        reasons = {key: reason for key, reason in each if reason}
        if len(reasons) == len(each) > 1 and len(set(reasons.values())) == 1:
            found.setdefault(each[0].reason, []).append(name if len(asked) > 1 else "all")
            continue
        for key, reason in reasons.items():
            found.setdefault(reason, []).append(key)
    return {reason: " ".join(keys) for reason, keys in found.items()}


def _shortened(reason: str, robot: RobotSpec) -> str:
    """Return the sign of a reason, and what it says without what there is no room for."""
    if not reason:
        return ""
    kind, _, rest = reason.partition(": ")
    said = (rest if kind in _SIGNS else reason).replace("it needs ", "needs ", 1)
    before, first, _ = said.partition(" first (")
    said = f"{before} first" if first else said
    for region, label in zip(robot.regions, shortened(robot.regions), strict=True):
        said = said.replace(region, label)
    return f"{sign_of(reason)} {said}"


def _fitting(texts: Sequence[str], width: int, rows: int) -> list[list[str]]:
    """Wrap each text; while there are too many lines, drop the last one of the longest text."""
    most = [len(_wrapped(text, width, rows)) for text in texts]
    while sum(most) > rows and max(most) > 1:
        most[most.index(max(most))] -= 1
    return [_wrapped(text, width, count) for text, count in zip(texts, most, strict=True)][:rows]


def _wrapped(text: str, width: int, most: int) -> list[str]:
    return wrap(
        text, max(width, 8), subsequent_indent="  ", max_lines=max(most, 1), placeholder=" …"
    )
