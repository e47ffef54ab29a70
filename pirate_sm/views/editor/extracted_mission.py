"""Some phases of a mission as a mission of their own, which the first one calls.

A call has two ways out: it is done, or it has failed. So the phases may lead to one place where
all is well, and to one where something has failed. Their text is moved as it is: the places that
they lead to become the ends of the new mission.
"""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from contextlib import suppress
from itertools import accumulate
from typing import Any, Final, NamedTuple

from pirate_sm.checking.exploring.explore import explore_mission
from pirate_sm.core.documents import Document, YamlNode
from pirate_sm.core.effects import PhaseChange
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.robot import states_of
from pirate_sm.views.editor.outline import end_of

_NO_PLACES: Final = ("continue", "fail", "here", "never")


class Extracted(NamedTuple):
    """A mission whose phases are called, and the mission that they have become.

    Attributes:
        caller: The text of the mission that calls.
        called: The text of the new mission.
    """

    caller: str
    called: str


class _Lead(NamedTuple):
    """Where something in a phase leads.

    Attributes:
        fails: Whether it leads there only after something has failed, or has not come in time.
    """

    to: str
    fails: bool


class _Ways(NamedTuple):
    """How the selected phases are entered and left.

    Attributes:
        first: The phase that the others lead to.
        done: Where they lead if all is well.
        failed: Where they lead if something has failed; None: where all failures lead.
    """

    first: str
    done: str
    failed: str | None


def selected_phases(document: Document, start: int, end: int) -> list[str]:
    """Return the names of the phases that have a part between two indexes of the text."""
    with suppress(UsageError):
        places = _phase_lines(document).items()
        return [name for name, (begin, last) in places if begin < end and start < last]
    return []


def extracted(loaded: LoadedMission, names: list[str], new: str) -> Extracted:
    """Return a mission with some of its phases in a mission of their own.

    Args:
        loaded: The mission.
        names: The phases, in the order of the file.
        new: The name of the new mission.

    Raises:
        UsageError: A call cannot take the place of these phases; the message says why.
    """
    document = loaded.documents[0]
    text, data = document.text, document.data
    ways, places = _ways(data, names), _phase_lines(document)
    moved = [text[slice(*places[name])].rstrip() + "\n" for name in names]
    used = [each for each in data.get("parameters") or () if _uses("".join(moved), each)]
    margin = " " * (_node(document, "phases", ways.first)[2] - 1)
    caller = text
    for name in reversed(names):
        begin, end = places[name]
        call = _call(ways, new, used, margin) if name == names[0] else ""
        caller = caller[:begin] + call + caller[end:]
    ends = {ways.done: f"{{succeed: On to {ways.done}}}"}
    leads = {each.to for name in names for each in _leads(data["phases"][name])}
    if ways.failed is not None and ways.failed in leads:
        ends.setdefault(ways.failed, '{fail: "{cause}"}')
    parameters = [_parameter(document, each, margin) for each in used]
    lines = [
        *_head(loaded, ways, new),
        *(["parameters:\n"] if used else []),
        *parameters,
        f"start: {ways.first}\nphases:\n",
        *moved,
        "ends:\n",
        *(f"{margin}{name}: {end}\n" for name, end in ends.items()),
    ]
    return Extracted(caller, "".join(lines))


def _ways(data: Mapping[str, Any], names: list[str]) -> _Ways:
    """Return how phases are entered and left.

    Raises:
        UsageError: There are more ways than a call has.
    """
    phases, usual = data["phases"], data.get("on_failure")
    if len(names) == len(phases):
        raise UsageError("no phase would be left in this mission")
    if usual in names:
        raise UsageError(f"all failures of this mission lead to '{usual}', which must stay in it")
    outside = {**data, "phases": {name: it for name, it in phases.items() if name not in names}}
    entered = [each for each in dict.fromkeys(_targets(outside)) if each in names]
    if len(entered) != 1:
        said = " and ".join(f"'{each}'" for each in entered) or "none of them"
        raise UsageError(f"a call begins in one place, and other phases lead to {said}")
    inside = [phases[name] for name in names]
    if any("counts_on" in str(each) for each in inside):
        raise UsageError("`counts_on` counts from a wait of this mission, which a call cannot")
    leads = [each for phase in inside for each in _leads(phase) if each.to not in names]
    if "resume" in str(inside) and any(phase.get("resume") in phases for phase in inside):
        raise UsageError("`resume` names a phase, which may be in the other mission then")
    fine = [*dict.fromkeys(each.to for each in leads if not each.fails)]
    wrong = [*dict.fromkeys(each.to for each in leads if each.to not in fine)]
    if not fine:
        fine, wrong = wrong[:1], wrong[1:]
    unhandled = any(phase.get("do") and not phase.get("on_failure") for phase in inside)
    failing = {*wrong, usual} if unhandled else {*wrong}
    if len(fine) != 1 or len(failing) > 1:
        places = ", ".join(
            dict.fromkeys([*fine, *wrong, *(each or "the safe stop" for each in failing)])
        )
        message = "a call leads to one place when it is done and to one when it has failed, and"
        raise UsageError(f"{message} these phases lead to {places}")
    return _Ways(entered[0], fine[0], next(iter(failing), None))


def _leads(part: Any, key: str = "") -> Iterator[_Lead]:
    """Yield where a part of a phase leads."""
    if isinstance(part, list):
        for each in part:
            yield from _leads(each, key)
    for name, value in part.items() if isinstance(part, dict) else ():
        if isinstance(value, str):
            if name in ("go", "on_failure") and value not in _NO_PLACES:
                yield _Lead(value, name == "on_failure" or key == "within")
        elif name == "choices" and isinstance(value, dict):
            yield from (_Lead(each, False) for each in value.values() if each not in _NO_PLACES)
        elif name != "with":
            yield from _leads(value, name)


def _targets(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield the names that a mission has as places to go to."""
    yield data["start"]
    yield from (each.to for each in _leads({"": [data.get("on_fault"), *data["phases"].values()]}))
    yield from (each.get("resume", "") for each in data["phases"].values())


def _call(ways: _Ways, new: str, used: list[str], margin: str) -> str:
    """Return the phase that calls the new mission."""
    given = ", ".join(f"{each}: ${each}" for each in used)
    step = f"call: {new}" + (f", with: {{{given}}}" if used else "")
    step += f", on_failure: {ways.failed}" if ways.failed else ""
    return f"{margin}{ways.first}: {{do: [{{{step}}}], go: {ways.done}}}\n"


def _head(loaded: LoadedMission, ways: _Ways, new: str) -> Iterator[str]:
    """Yield the head of the new mission, with the states in which it always begins."""
    data, first = loaded.documents[0].data, loaded.documents[0].lines[0]
    if first.startswith("# yaml-language-server:"):
        yield f"{first}\n"
    yield f"format: {data['format']}\nmission: {new}\n"
    yield f"description: The phase {ways.first} of {data['mission']}, and those that follow\n"
    for name in ("robot", "polarity", "allow_unclamp"):
        if name in data:
            yield f"{name}: {json.dumps(data[name], ensure_ascii=False)}\n"
    states = ", ".join(
        f"{region}: {state}" for region, state in _states(loaded, ways.first).items()
    )
    yield f"starts_in: {{{states}}}\n"


def _states(loaded: LoadedMission, phase: str) -> dict[str, str]:
    """Return the states that are confirmed in all situations in which a phase begins.

    None are if not all situations were explored.
    """
    (first, *_), _conditions = explore_mission(loaded)
    if not first.found.complete:
        return {}
    bodies = [
        first.found.nodes[step.target].state.robot
        for step in first.found.steps
        if any(isinstance(each, PhaseChange) and each.phase == phase for each in step.effects)
    ]
    if not bodies or any(body.marks for body in bodies):
        return {}
    known = [states_of(loaded.robot, body) for body in bodies]
    return {
        region: states[0]
        for region, *states in zip(loaded.robot.regions, *known, strict=True)
        if len({*states}) == 1
    }


def _phase_lines(document: Document) -> dict[str, tuple[int, int]]:
    """Return where the lines of each phase begin and end, with the comments above it.

    Raises:
        UsageError: The phases are not written below each other.
    """
    lines, (phases, line, _) = _line_starts(document.text), _node(document, "phases")
    begin, found = lines[line], dict[str, tuple[int, int]]()
    inner = phases.children if isinstance(phases.children, dict) else {}
    for name, (node, line, column) in inner.items():
        start = lines[line - 1]
        if start < begin or document.text[start : start + column - 1].strip(" "):
            raise UsageError("the phases do not stand below each other, each on lines of its own")
        after = bisect_right(lines, max(end_of(document, node), start))
        end = lines[min(after, len(lines) - 1)]
        found[name], begin = (begin, end), end
    return found


def _line_starts(text: str) -> list[int]:
    """Return where the lines of a text begin, as YAML counts them, and where the last one ends."""
    return [0, *accumulate(map(len, text.splitlines(keepends=True)))]


def _parameter(document: Document, name: str, margin: str) -> str:
    node = _node(document, "parameters", name)[0]
    return f"{margin}{name}: {document.text[node.start : end_of(document, node)]}\n"


def _uses(text: str, parameter: str) -> bool:
    return re.search(rf"\${parameter}\b|\{{{parameter}\}}", text) is not None


def _node(document: Document, *path: str) -> tuple[YamlNode, int, int]:
    """Return a value that is there, with the place of its key."""
    found = document.root, 1, 1
    for each in path:
        found = found[0].child(each) or found
    return found
