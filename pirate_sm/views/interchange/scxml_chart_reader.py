"""Reads a chart from SCXML, reports what our charts cannot express, and writes it as a chart file.

The elements become the data of a chart file, each value with its place in the SCXML. So the checks
of chart files find the other faults, at their line and column.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import yaml

from pirate_sm.core.documents import Document, Place, Problem, Problems, YamlNode
from pirate_sm.core.loading import ChartOutline, outline_chart
from pirate_sm.core.spelling import nearest, one_of
from pirate_sm.core.visible import visible
from pirate_sm.views.interchange.scxml import (
    OURS,
    SCXML,
    Attribute,
    ConditionError,
    XmlElement,
    guard_of,
    lines_of,
    read_elements,
)

_DATAMODELS: Final = ("null", "ecmascript", "python")
_ATTRIBUTES: Final = {
    "scxml": ("name", "initial", "version", "datamodel", "binding"),
    "parallel": ("id",),
    "state": ("id", "initial"),
    "initial": (),
    "transition": ("event", "target", "cond", "type"),
}
"""The supported elements with their attributes."""

_INSIDE: Final = {
    "scxml": ("parallel",),
    "parallel": ("state",),
    "state": ("initial", "state", "transition"),
    "initial": ("transition",),
    "transition": (),
}
"""The elements that each of them may contain."""

_REFUSED: Final = frozenset(
    {"history", "final", "donedata", "onentry", "onexit", "datamodel", "data", "invoke", "finalize",
     "script", "send", "cancel", "raise", "log", "assign", "if", "elseif", "else", "foreach",
     "param", "content"}
)  # fmt: skip
"""Elements of SCXML that are not supported here."""

_MOST_HINTS: Final = 50
"""Faults before which similar ids are looked for: so many are shown, and the search takes time."""


def read_chart(text: str, name: str, called: str) -> tuple[Document, ChartOutline]:
    """Return the chart in a text of SCXML as the document of a chart file, and its declarations.

    Args:
        text: The SCXML.
        name: What to call it in messages.
        called: Name of the chart if the SCXML has none.

    Raises:
        LoadError: It is not SCXML, or a chart of ours cannot be like it; holds all faults.
    """
    root = read_elements(text, name)
    reader = _Reader(name, lines_of(text))
    node = reader.chart(root, called)
    document = Document(name, text, node, reader.lines)
    problems = Problems(document)
    for problem in reader.problems:
        problems.put(problem)
    # Without its parallel state there is nothing to be checked.
    outline = outline_chart(document, problems) if node.value.get("states") else None
    problems.raise_errors()
    if outline is None:
        raise AssertionError("an outline is missing only beside a problem")
    return document, outline


class _Reader:
    """Makes the data of a chart file from elements, and collects what cannot be part of it."""

    def __init__(self, name: str, lines: tuple[str, ...]) -> None:
        self.lines = lines
        self.problems: list[Problem] = []
        self._name = name
        self._elements: dict[str, XmlElement] = {}
        """Regions and states by id."""
        self._names: dict[str, str] = {}
        """The name in the chart of the state with each id."""
        self._taken: set[str] = set()
        self._refused: set[str] = set()
        """The ids of elements that are refused, so that references to them are not reported too."""

    def chart(self, root: XmlElement, called: str) -> YamlNode:
        """Return the data of the chart; without `states` where there are none to be checked."""
        if root.name != "scxml" or root.namespace not in {SCXML, ""}:
            message = f'<{root.name}> is not SCXML: <scxml xmlns="{SCXML}"> is expected'
            self._fault("scxml.element", root, message)
            return _mapping(root, {})
        self._sift(root)
        version, datamodel = root.attributes.get("version"), root.attributes.get("datamodel")
        if version is not None and version.value != "1.0":
            message = f"version '{version.value}' of SCXML is not known"
            self._fault("scxml.attribute", version, message, "1.0")
        if datamodel is not None and datamodel.value not in _DATAMODELS:
            message = f"guards in the datamodel '{datamodel.value}' cannot be read"
            self._fault("scxml.attribute", datamodel, message, one_of(_DATAMODELS))
        named = root.attributes.get("name")
        content = {"name": _leaf(named.value if named is not None else called, named or root)}
        if description := root.others.get((OURS, "description")):
            content["description"] = _leaf(description, root)
        tops = [each for each in root.children if each.name == "parallel"]
        if len(tops) == 1 and tops[0].children:
            self._begins_with(root, tops)
            content |= self._top(tops[0])
        else:
            message = "a chart has one <parallel> in <scxml>, and in it a <state> for each region"
            self._fault("scxml.shape", tops[-1] if tops else root, message)
        return _mapping(root, content)

    def _top(self, top: XmlElement) -> dict[str, YamlNode]:
        regions = {}
        for region in top.children:
            name = self._noted(region)
            if not name:
                continue
            if any(each.name == "state" for each in region.children):
                regions[name] = region
            else:
                self._fault("scxml.shape", region, f"the region '{name}' has no <state> in it")
        for name, region in regions.items():
            self._collect(name, region)
        if not regions:
            return {}
        inside = {name: self._region(name, region) for name, region in regions.items()}
        body = {"parallel": _leaf(True, top), "states": _mapping(top, inside)}
        whole = _mapping(top, {self._id(top) or "chart": _mapping(top, body)})
        return {"states": whole}

    def _collect(self, region: str, around: XmlElement) -> None:
        """Give the states inside a region or state their names in the chart."""
        for state in around.children:
            if state.name != "state":
                continue
            if id_ := self._noted(state):
                name = id_ if id_.startswith(f"{region}.") else f"{region}.{id_}"
                if name in self._taken:
                    message = f"another state is named '{name}' in the chart, too"
                    self._fault("scxml.id", state, message)
                self._taken.add(name)
                self._names[id_] = name
            self._collect(region, state)

    def _noted(self, element: XmlElement) -> str:
        """Return the id of a region or state; nothing after reporting that it has none."""
        id_ = self._id(element)
        before = self._elements.setdefault(id_, element) if id_ else None
        if before is element:
            return id_
        given = f"the id '{id_}' stands twice; first in line {before.line}" if before else ""
        self._fault("scxml.id", element, given or f"<{element.name}> needs an id")
        return ""

    def _region(self, name: str, region: XmlElement) -> YamlNode:
        for move in region.children:
            if move.name == "transition":
                message = f"a transition of the whole region '{name}' is not supported"
                expected = "transitions of the states inside it"
                self._fault("scxml.transition", move, message, expected)
        return _mapping(region, {"states": self._inside(region)})

    def _inside(self, around: XmlElement) -> YamlNode:
        """Return the states inside a region or a state."""
        states = [each for each in around.children if each.name == "state"]
        first = self._begins_with(around, states)
        found = {}
        for state in states:
            name = self._names.get(self._id(state), "")
            if self._elements.get(self._id(state)) is state and name not in found:
                found[name] = self._state(state, state is first)
        return _mapping(around, found)

    def _state(self, state: XmlElement, first: bool) -> YamlNode:
        content = {"initial": _leaf(True, state)} if first else {}
        moves = [each for each in state.children if each.name == "transition"]
        if found := [move for each in moves if (move := self._move(each)) is not None]:
            content["transitions"] = _list(state, found)
        if any(each.name == "state" for each in state.children):
            content["states"] = self._inside(state)
        else:
            self._begins_with(state, [])
        return _mapping(state, content)

    def _begins_with(self, around: XmlElement, inside: Sequence[XmlElement]) -> XmlElement | None:
        """Return the child that an element begins with: the one that it names, else the first."""
        given: list[Attribute] = []
        if "initial" in around.attributes:
            given.append(around.attributes["initial"])
        for element in (each for each in around.children if each.name == "initial"):
            move = element.children[0] if len(element.children) == 1 else None
            target = move.attributes.get("target") if move is not None else None
            if move is None or target is None or len(move.attributes) > 1:
                message = "<initial> has one <transition>, which has a target and nothing else"
                self._fault("scxml.initial", element, message)
            else:
                given.append(target)
        for attribute in given:
            for each in inside:
                if attribute.value.strip() == self._id(each):
                    return each
            if attribute.value.strip() not in self._refused:
                known = [self._id(each) for each in inside]
                message = f"'{attribute.value}' is not a state directly inside <{around.name}>"
                self._fault("scxml.initial", attribute, message, one_of(known) if known else "")
        return inside[0] if inside else None

    def _move(self, move: XmlElement) -> YamlNode | None:
        """Return a transition, or None if it is refused."""
        given = move.attributes
        needed = [given[key] for key in ("event", "target") if key in given]
        if len(needed) < 2 or not all(each.value.strip() for each in needed):
            message = "a transition without an event or without a target is not supported"
            self._fault("scxml.transition", move, message)
            return None
        kind, condition, (event, target) = given.get("type"), given.get("cond"), needed
        if kind is not None and kind.value != "external":
            message = f"a transition of type '{kind.value}' is not supported"
            self._fault("scxml.transition", kind, message, "external")
        content = {"event": _leaf(" ".join(event.value.split()), event)}
        targets = target.value.split()
        if len(targets) > 1:
            self._fault("scxml.transition", target, "a transition has one target")
        if condition is not None and (guard := self._guard(condition)):
            content["cond"] = _leaf(guard, condition)
        names = [self._named(each, target) for each in targets]
        if len(targets) > 1 or targets[0] not in self._names:
            return None
        content["target"] = _leaf(names[0], target)
        return _mapping(move, content)

    def _guard(self, condition: Attribute) -> str:
        """Return the guard of a condition; nothing after reporting its faults."""
        before = len(self.problems)
        try:
            guard = guard_of(condition.value, lambda id_: self._named(id_, condition))
        except ConditionError as error:
            expected = "In('…') with &&, ||, ! and parentheses"
            self._fault("scxml.guard", condition, str(error), expected)
            return ""
        return guard if len(self.problems) == before else ""

    def _sift(self, element: XmlElement) -> None:
        """Report what is not supported in an element, and leave it out."""
        known = _ATTRIBUTES[element.name]
        for name, attribute in element.attributes.items():
            if name not in known:
                message = f"<{element.name}> has no attribute '{name}'"
                hint = nearest(name, known) or ""
                self._fault("scxml.attribute", attribute, message, one_of(known), hint)
        kept = []
        for child in element.children:
            if child.namespace not in {SCXML, ""}:
                continue  # SCXML allows elements of others, which have no meaning here
            if child.name in _INSIDE[element.name]:
                self._sift(child)
                kept.append(child)
                continue
            self._refused |= set(_ids(child))
            allowed = [f"<{name}>" for name in _INSIDE[element.name]]
            if child.name in _REFUSED or child.name in _INSIDE:
                message = f"<{child.name}> in <{element.name}> is not supported in a chart"
            else:
                message = f"SCXML has no element <{child.name}>"
            expected = one_of(allowed) if allowed else "nothing inside it"
            self._fault("scxml.element", child, message, expected)
        element.children = kept

    def _id(self, element: XmlElement) -> str:
        found = element.attributes.get("id")
        return found.value if found is not None else ""

    def _named(self, id_: str, at: XmlElement | Attribute) -> str:
        """Return the name in the chart of the state with an id, or report that there is none."""
        if id_ not in self._names and id_ not in self._refused:
            hints = self._names if len(self.problems) < _MOST_HINTS else ()
            hint = nearest(id_, hints) or ""
            self._fault("scxml.id", at, f"there is no state '{id_}'", suggestion=hint)
        return self._names.get(id_, id_)

    def _fault(
        self,
        code: str,
        at: XmlElement | Attribute,
        message: str,
        expected: str = "",
        suggestion: str = "",
    ) -> None:
        excerpt = self.lines[at.line - 1]
        place = Place(self._name, at.line, at.column)
        self.problems.append(Problem(code, place, message, expected, suggestion, excerpt))


def _ids(element: XmlElement) -> Iterator[str]:
    """Yield the ids of an element and of all inside it."""
    if "id" in element.attributes:
        yield element.attributes["id"].value
    for child in element.children:
        yield from _ids(child)


def _leaf(value: object, at: XmlElement | Attribute) -> YamlNode:
    return YamlNode(at.line, at.column, 0, 0, value)


def _list(at: XmlElement, items: list[YamlNode]) -> YamlNode:
    return YamlNode(at.line, at.column, 0, 0, [each.value for each in items], items)


def _mapping(at: XmlElement, content: Mapping[str, YamlNode]) -> YamlNode:
    """Return a mapping whose keys have the places where their values begin."""
    children = {key: (node, node.line, node.column) for key, node in content.items()}
    return YamlNode(
        at.line, at.column, 0, 0, {key: it.value for key, it in content.items()}, children
    )


def chart_text(data: dict[str, Any], source: str) -> str:
    """Return the data of a chart as the text of its file.

    Args:
        data: The data, as a chart file has them.
        source: Where they are from, for people.
    """
    text = yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=100)
    return f"# Made from {visible(source)} by `pirate import`.\n{text}"
