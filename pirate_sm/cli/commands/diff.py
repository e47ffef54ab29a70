"""`pirate diff`: compares what two versions of a mission can do.

The JSON is described by ``docs/schemas/diff.schema.json``.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from textwrap import wrap

from pirate_sm.checking.mission_behaviour import abilities_of
from pirate_sm.checking.mission_differences import Kind, MissionDifference, compare
from pirate_sm.cli.options.checks import DiffOptions
from pirate_sm.cli.options.declaring import read_settings
from pirate_sm.cli.output.terminal import writable
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.library import shown
from pirate_sm.core.loading import load_mission
from pirate_sm.core.visible import visible

SAME, DIFFERENT = 0, 1


FORMAT = 1


_KINDS: tuple[Kind, ...] = ("gained", "lost", "changed", "renamed")


_WIDTH = 100


def run_diff(options: DiffOptions) -> int:
    """Print the differences; return the exit code, which says whether there are any.

    Raises:
        LoadError: One of the versions cannot be loaded.
        UsageError: A version does not exist, or is too large to compare.
    """
    old, new = (library.find_mission(each) for each in (options.old, options.new))
    settings = read_settings(options.settings)
    before, after = (
        abilities_of(load_mission(path, robot=options.robot, settings=settings))
        for path in (old, new)
    )
    difference = compare(before, after)
    if difference.same and difference.cut_off:
        which = " and ".join(f"the {each} one" for each in difference.cut_off)
        raise UsageError(
            f"too much can happen to compare all of it ({which}): nothing differs "
            "in what was looked at"
        )
    write = _json if options.format == "json" else _text
    sys.stdout.write(write(difference, shown(old), shown(new)) + "\n")
    return SAME if difference.same else DIFFERENT


def _text(difference: MissionDifference, old: str, new: str) -> str:
    lines = [f"{old} → {new}: {_summary(difference)}"]
    for kind in _KINDS:
        changes = difference.of(kind)
        lines += ["", kind] if changes else []
        for change in changes:
            lines += wrap(
                visible(change.text),
                _WIDTH,
                initial_indent="  ",
                subsequent_indent="      ",
                break_long_words=False,
                break_on_hyphens=False,
            )
    for which in difference.cut_off:
        lines += ["", f"in the {which} version too much can happen to look at all of it"]
    return writable("\n".join(lines))


def _summary(difference: MissionDifference) -> str:
    counts = ((kind, len(difference.of(kind))) for kind in _KINDS)
    counted = ", ".join(f"{count} {kind}" for kind, count in counts if count)
    return f"both can do the same{', ' if counted else ''}{counted}" if difference.same else counted


def _json(difference: MissionDifference, old: str, new: str) -> str:
    whole = {
        "format": FORMAT,
        "old": old,
        "new": new,
        "same": difference.same,
        "cut_off": list(difference.cut_off),
        "changes": [asdict(each) for each in difference.changes],
    }
    return json.dumps(whole, indent=1)
