"""Charts and missions as SCXML 1.0, for editors, code generators and interpreters of statecharts.

What SCXML has no word for stands in attributes and elements of a namespace of our own, as missions
write it; other programs ignore it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping
from typing import Final
from xml.etree import ElementTree as Xml

from pirate_sm.core import mission as model
from pirate_sm.core.loading import TIME_LIMIT, ChartOutline, StateNode, trigger_names
from pirate_sm.core.mission import ConditionTrigger, OperatorTrigger, TimeTrigger, Trigger
from pirate_sm.views.drawing.graph.step_text import amount, short, step_lines
from pirate_sm.views.interchange.scxml_guards import condition_of
from pirate_sm.views.interchange.xml_elements import OURS, SCXML

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
    """Add a transition; without a target it only says that the event is passed over."""
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
