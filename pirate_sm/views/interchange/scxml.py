"""Charts and missions as SCXML 1.0, for editors, code generators and interpreters of statecharts.

What SCXML cannot express is kept in attributes and elements of a namespace of our own, as missions
write it; other programs ignore it.

expat reads XML, since it alone knows the places. What makes XML dangerous needs a DOCTYPE, so that
is refused: entities that expand, and entities from other files. Nothing outside the text is read.

A guard is written in the part of ECMAScript that python-statemachine reads too: ``In('…')``,
``&&``, ``||``, and ``== false`` instead of ``!``. What is read may use ``!`` as well, and the
``and``, ``or`` and ``not`` of Python.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final
from xml.etree import ElementTree as Xml
from xml.parsers import expat

from pirate_sm.core import models as model
from pirate_sm.core.documents import LoadError, Place, Problem
from pirate_sm.core.loading import TIME_LIMIT, ChartOutline, StateNode, trigger_names
from pirate_sm.core.models import ConditionTrigger, OperatorTrigger, TimeTrigger, Trigger
from pirate_sm.views.drawing.mission_words import amount, short, step_lines

# --- elements that are read ---------------------------------------------------------------------


DEEPEST_NESTING: Final = 32
MOST_ELEMENTS: Final = 20_000

_BETWEEN: Final = " "  # occurs in no namespace and in no name
_TAG: Final = re.compile(rb"<[^\s/>]+")
_ATTRIBUTE: Final = re.compile(rb"""\s+([^\s=<>"']+)\s*=\s*(?:"[^"]*"|'[^']*')""")
_LINE_END: Final = re.compile("\r\n|\r|\n")


SCXML: Final = "http://www.w3.org/2005/07/scxml"
"""The namespace of SCXML 1.0 (W3C Recommendation, 1 September 2015)."""

OURS: Final = "urn:pirate-sm"
"""The namespace of what SCXML has no word for; other programs ignore it."""


@dataclass(frozen=True, slots=True)
class Attribute:
    """An attribute with the line and column of its name."""

    value: str
    line: int
    column: int


@dataclass(slots=True)
class XmlElement:
    """An element of an XML document with the line and column of its tag.

    Attributes:
        name: Its name without the prefix.
        namespace: Its namespace; empty without one.
        attributes: The attributes without a namespace, by name.
        others: The values of attributes in a namespace, by namespace and name.
    """

    name: str
    namespace: str
    line: int
    column: int
    attributes: dict[str, Attribute] = field(default_factory=dict)
    others: dict[tuple[str, str], str] = field(default_factory=dict)
    children: list[XmlElement] = field(default_factory=list)


def lines_of(text: str) -> tuple[str, ...]:
    """Return the lines of an XML text; other line separators of Unicode are characters there."""
    return tuple(_LINE_END.split(text))


def read_elements(text: str, name: str) -> XmlElement:
    """Return the root element of an XML text.

    Args:
        text: The text; what it declares as its encoding does not matter.
        name: What to call it in messages.

    Raises:
        LoadError: It is not well-formed, has a DOCTYPE, or is too deep or too large.
    """
    builder = _Builder(text.encode())
    try:
        return builder.build()
    except expat.ExpatError as error:
        line, column = error.lineno, error.offset + 1
        message = f"this is not XML: {expat.ErrorString(error.code)}"
    except _RefusedError as error:
        line, column, message = error.line, error.column, error.message
    lines = lines_of(text)
    excerpt = lines[line - 1] if line <= len(lines) else ""
    problem = Problem("xml", Place(name, line, column), message, excerpt=excerpt)
    raise LoadError([problem]) from None


class _RefusedError(Exception):
    """Raised to stop reading."""

    def __init__(self, message: str, line: int, column: int) -> None:
        super().__init__(message)
        self.message, self.line, self.column = message, line, column


class _Builder:
    """Builds the elements with its own stack while expat reads."""

    def __init__(self, content: bytes) -> None:
        self._content = content
        self._stack: list[XmlElement] = []
        self._root: XmlElement | None = None
        self._count = 0
        # The text is UTF-8 now, whatever it was before.
        self._parser = expat.ParserCreate("utf-8", _BETWEEN)
        self._parser.ordered_attributes = True
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end

    def build(self) -> XmlElement:
        self._parser.Parse(self._content, True)
        if self._root is None:
            raise AssertionError("expat refuses a text without an element")
        return self._root

    def _doctype(self, *_: object) -> None:
        # expat has read on to its end.
        begin = self._content.rfind(b"<!DOCTYPE", 0, self._parser.CurrentByteIndex + 1)
        lines = _LINE_END.split(self._content[: max(begin, 0)].decode())
        message = "a DOCTYPE is not allowed: its entities could expand or name other files"
        raise _RefusedError(message, len(lines), len(lines[-1]) + 1)

    def _start(self, name: str, attributes: list[str]) -> None:
        self._count += 1
        if self._count > MOST_ELEMENTS:
            self._refuse(f"more than {MOST_ELEMENTS} elements")
        if len(self._stack) >= DEEPEST_NESTING:
            self._refuse(f"elements are nested more than {DEEPEST_NESTING} deep")
        namespace, _, local = name.rpartition(_BETWEEN)
        line, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1
        element = XmlElement(local, namespace, line, column)
        places = self._places(line, column)
        for key, value in zip(attributes[::2], attributes[1::2], strict=True):
            outside, _, own = key.rpartition(_BETWEEN)
            if outside:
                element.others[outside, own] = value
            else:
                element.attributes[own] = Attribute(value, *places.get(own, (line, column)))
        if self._stack:
            self._stack[-1].children.append(element)
        else:
            self._root = element
        self._stack.append(element)

    def _end(self, _: str) -> None:
        self._stack.pop()

    def _places(self, line: int, column: int) -> dict[str, tuple[int, int]]:
        """Return line and column of each attribute of the tag that begins here."""
        places: dict[str, tuple[int, int]] = {}
        position = self._parser.CurrentByteIndex
        found = _TAG.match(self._content, position)
        while found := _ATTRIBUTE.match(self._content, found.end() if found else position):
            parts = _LINE_END.split(self._content[position : found.start(1)].decode())
            line += len(parts) - 1
            column = len(parts[-1]) + (column if len(parts) == 1 else 1)
            places[found[1].decode()] = line, column
            position = found.start(1)
        return places

    def _refuse(self, message: str) -> None:
        line, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber + 1
        raise _RefusedError(message, line, column)


# --- guards -------------------------------------------------------------------------------------


DEEPEST_GUARD: Final = 50
"""Deepest nesting of a condition that is read [decided]."""

_TOKEN: Final = re.compile(r"""'[^'\\]*'|"[^"\\]*"|\w+|&&|\|\||[!=]==?|\S""")
_SAME = {"&&": "and", "||": "or", "===": "==", "!==": "!="}
_SAME |= {"true": "True", "false": "False"}


def condition_of(guard: ast.expr) -> str:
    """Return a guard of a chart as a condition of SCXML."""
    match guard:
        case ast.BoolOp(op=operator, values=parts):
            sign = " && " if isinstance(operator, ast.And) else " || "
            return sign.join(map(_part, parts))
        case ast.UnaryOp(operand=operand):
            return f"{_part(operand)} == false"
        case ast.Call(args=[ast.Constant(value=str(state))]):
            return f"In('{state}')"
        case _:
            raise AssertionError(f"the chart was checked: {ast.unparse(guard)}")


def _part(guard: ast.expr) -> str:
    text = condition_of(guard)
    return text if isinstance(guard, ast.Call) else f"({text})"


class ConditionError(Exception):
    """Raised for a condition that cannot be a guard."""


def guard_of(condition: str, state_of: Callable[[str], str]) -> str:
    """Return a condition of SCXML as a guard of a chart.

    Args:
        condition: The condition.
        state_of: Returns the name in the chart of the state with an id.

    Raises:
        ConditionError: It uses something else than states with and, or, not.
    """
    return ast.unparse(_Parser(condition, state_of).whole())


class _Parser:
    """Reads a condition by recursive descent; Python's ``not`` binds less than ``==``, ``!`` more.

    Args:
        condition: The condition.
        state_of: Returns the name in the chart of the state with an id.
    """

    def __init__(self, condition: str, state_of: Callable[[str], str]) -> None:
        self._tokens = [_SAME.get(each, each) for each in _TOKEN.findall(condition)]
        self._tokens.reverse()  # the next one is the last
        self._state_of = state_of
        self._depth = 0

    def whole(self) -> ast.expr:
        found = self._any()
        if self._tokens:
            raise ConditionError(f"'{self._tokens[-1]}' was not expected here")
        return found

    def _any(self) -> ast.expr:
        self._depth += 1
        if self._depth > DEEPEST_GUARD:
            raise ConditionError(f"this is nested more than {DEEPEST_GUARD} deep")
        found = self._joined("or", ast.Or(), lambda: self._joined("and", ast.And(), self._negated))
        self._depth -= 1
        return found

    def _joined(self, word: str, operator: ast.boolop, part: Callable[[], ast.expr]) -> ast.expr:
        parts = [part()]
        while self._takes(word):
            parts.append(part())
        return ast.BoolOp(operator, parts) if len(parts) > 1 else parts[0]

    def _negated(self) -> ast.expr:
        negations = 0
        while self._takes("not"):
            negations += 1
        found = self._compared()
        return ast.UnaryOp(ast.Not(), found) if negations % 2 else found

    def _compared(self) -> ast.expr:
        negative = False
        while self._takes("!"):
            negative = not negative
        found = self._single()
        while self._tokens and self._tokens[-1] in {"==", "!="}:
            unequal = self._tokens.pop() == "!="
            if self._takes("True"):
                negative ^= unequal
            elif self._takes("False"):
                negative ^= not unequal
            else:
                raise ConditionError("only true and false can be compared with here")
        return ast.UnaryOp(ast.Not(), found) if negative else found

    def _single(self) -> ast.expr:
        if self._takes("("):
            found = self._any()
            self._needs(")")
            return found
        if not self._takes("In"):
            what = f"'{self._tokens[-1]}'" if self._tokens else "the end"
            raise ConditionError(f"In('…') was expected instead of {what}")
        self._needs("(")
        name = self._tokens.pop() if self._tokens else ""
        if name[:1] not in {"'", '"'} or len(name) < 2:
            raise ConditionError("In needs the id of a state in quotes: In('…')")
        self._needs(")")
        state = ast.Constant(self._state_of(name[1:-1]))
        return ast.Call(ast.Name("In", ast.Load()), [state], [])

    def _takes(self, token: str) -> bool:
        found = bool(self._tokens) and self._tokens[-1] == token
        if found:
            self._tokens.pop()
        return found

    def _needs(self, token: str) -> None:
        if not self._takes(token):
            what = f"'{self._tokens[-1]}'" if self._tokens else "the end"
            raise ConditionError(f"'{token}' was expected instead of {what}")


# --- writing ------------------------------------------------------------------------------------


PHASE, END, ANY_PHASE = "phase.", "end.", "any_phase"
"""Beginnings of the ids of phases and ends, and the id of the state around all phases.

A plain name such as ``enter`` would hide what python-statemachine's own states have.
"""

DONE, FAILED, FAULT, TRIGGER, ANSWER = "done", "failed", "fault", "trigger", "answer"
"""The first words of the events of a mission."""

_ID: Final = re.compile(r"[A-Za-z_][\w.-]*", re.ASCII)


def chart_scxml(outline: ChartOutline, name: str, description: str = "") -> str:
    """Return a chart as SCXML: a region for each state machine, guards as conditions."""
    root = _root(name, description, datamodel="ecmascript")
    # The name of the parallel state is free in a chart, and an id is given once.
    usable = _ID.fullmatch(outline.top) and outline.top not in outline.regions
    top = outline.top if usable else "all.regions"
    root.set("initial", top)
    parallel = Xml.SubElement(root, "parallel", id=top)
    for region, nodes in zip(outline.regions, outline.nodes, strict=True):
        _states(Xml.SubElement(parallel, "state", id=region), nodes)
    return _text(root)


def _states(around: Xml.Element, nodes: tuple[StateNode, ...]) -> None:
    """Add the states inside a region or a compound state."""
    around.set("initial", next(node.name for node in nodes if node.initial))
    for node in nodes:
        state = Xml.SubElement(around, "state", id=node.name)
        for move in node.moves:
            events = " ".join(move.events)
            element = Xml.SubElement(state, "transition", event=events, target=move.target)
            if move.guard:
                element.set("cond", condition_of(ast.parse(move.guard, mode="eval").body))
        if node.inner:
            _states(state, node.inner)


def mission_scxml(mission: model.Mission) -> str:
    """Return a mission as SCXML: phases as states, ends as final states.

    Steps and conditions are text in our namespace. The events are what the engine reports:
    ``done``, ``trigger.NAME``, ``within``, ``answer.TEXT``, ``failed``, ``fault.CODE``; those of a
    step end in its number.
    """
    root = _root(mission.mission, mission.description, initial=ANY_PHASE)
    states = mission.starts_in or {}
    _describe(
        root,
        robot=mission.robot,
        pipe=mission.pipe if isinstance(mission.pipe, str) else "",
        starts_in=", ".join(f"{region}={state}" for region, state in states.items()),
        control=mission.control or "",
        time_limit=amount(mission.time_limit, "s") if mission.time_limit is not None else "",
    )
    ids = {name: f"{PHASE}{name}" for name in mission.phases}
    ids |= {name: f"{END}{name}" for name in mission.ends}
    around = Xml.SubElement(root, "state", id=ANY_PHASE, initial=ids[mission.start])
    for handler in mission.on_fault:
        event = " ".join(f"{FAULT}.{code}" for code in handler.fault)
        leads = ids[handler.go] if handler.go is not None else ""
        _transition(around, event, leads, {"of": ", ".join(handler.of)} if handler.of else None)
    if mission.on_failure is not None:
        _transition(around, FAILED, ids[mission.on_failure])
    for name, phase in mission.phases.items():
        state = Xml.SubElement(around, "state", id=ids[name])
        _describe(state, description=phase.description)
        for line in step_lines(phase.do):
            Xml.SubElement(state, "sm:step").text = line
        for event, target, about in _ways(phase):
            _transition(state, event, ids[target], about)
    for name, end in mission.ends.items():
        final = Xml.SubElement(root, "final", id=ids[name])
        _describe(final, succeed=end.succeed or "", fail=end.fail or "")
    return _text(root)


def _ways(phase: model.Phase) -> Iterator[tuple[str, str, Mapping[str, str]]]:
    """Yield each transition out of a phase, those of its steps first: event, target, details."""
    for number, (step, _) in enumerate(model.every_step(phase.do), start=1):
        after = f".{number}"
        if isinstance(step, model.WaitStep):
            yield from _wait_ways(step, after)
        if isinstance(step, model.AskStep):
            for answer, leads in step.choices.items():
                if leads not in {model.CONTINUE, model.FAIL}:
                    word = re.sub(r"\W+", "_", answer)
                    yield f"{ANSWER}.{word}{after}", leads, {"answer": answer}
        if step.on_failure not in {None, model.CONTINUE}:
            yield f"{FAILED}{after}", str(step.on_failure), {"step": short(step)}
    yield from _wait_ways(phase)
    if phase.go is not None:
        yield DONE, phase.go, {}
    if phase.on_failure is not None:
        yield FAILED, phase.on_failure, {}


def _wait_ways(
    it: model.Phase | model.WaitStep, after: str = ""
) -> Iterator[tuple[str, str, Mapping[str, str]]]:
    for trigger, name in zip(it.wait, trigger_names(it.wait), strict=True):
        if trigger.go is not None:
            yield f"{TRIGGER}.{name}{after}", trigger.go, _trigger(trigger)
    if it.within is not None and it.within.go is not None:
        yield f"{TIME_LIMIT}{after}", it.within.go, {"time": amount(it.within.time, "s")}


def _trigger(trigger: Trigger) -> dict[str, str]:
    match trigger:
        case ConditionTrigger(when=when, held=held):
            return {"when": when} | ({"held": amount(held, "s")} if held else {})
        case TimeTrigger(after=after):
            return {"after": amount(after, "s")}
        case OperatorTrigger(operator=word):
            return {"operator": word}


def _transition(
    state: Xml.Element, event: str, target: str, about: Mapping[str, str] | None = None
) -> None:
    """Add a transition; without a target it only says that the event is ignored."""
    element = Xml.SubElement(state, "transition", event=event)
    if target:
        element.set("target", target)
    _describe(element, **(about or {}))


def _root(name: str, description: str, **attributes: str) -> Xml.Element:
    root = Xml.Element("scxml", {"xmlns": SCXML, "xmlns:sm": OURS, "version": "1.0"})
    root.set("name", re.sub(r"[^\w.-]", "_", name))
    root.attrib |= attributes
    _describe(root, description=description)
    return root


def _describe(element: Xml.Element, **values: str) -> None:
    """Set attributes of our namespace, without those that are empty."""
    for name, value in values.items():
        if value:
            element.set(f"sm:{name}", value)


def _text(root: Xml.Element) -> str:
    Xml.indent(root)
    return f'<?xml version="1.0"?>\n{Xml.tostring(root, encoding="unicode")}\n'
