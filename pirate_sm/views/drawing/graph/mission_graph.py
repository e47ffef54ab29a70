"""A mission as a graph: its phases with their steps, and the transitions between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pirate_sm.core import library
from pirate_sm.core import models as model
from pirate_sm.core.documents import read_document
from pirate_sm.core.loading import validate
from pirate_sm.views.drawing.graph.graph import Cluster, Edge, EdgeKind, Graph, Node, NodeKind
from pirate_sm.views.drawing.mission_words import amount, short, step_lines, trigger_text

START = "(start)"
ANY_PHASE = "(any phase)"


@dataclass(frozen=True)
class Called:
    """A called mission that is drawn as well.

    Attributes:
        prefix: The engine's prefix for the names of its phases.
    """

    prefix: str
    mission: model.Mission


def mission_graph(mission: model.Mission, called: Sequence[Called] = ()) -> Graph:
    """Return the graph of a mission, each called mission in a cluster of its own.

    Ids are the engine's names of phases; the id of an end has the same prefix.
    """
    parts = (Called("", mission), *called)
    clusters = tuple(
        Cluster(_cluster(part), _title(part), part.mission.description) for part in parts
    )
    nodes = tuple(node for part in parts for node in _nodes(part))
    edges = tuple(edge for part in parts for edge in _edges(part))
    return Graph(mission.mission, clusters, nodes, edges, mission.description)


def called_missions(mission: model.Mission, file: Path, prefix: str = "") -> tuple[Called, ...]:
    """Return all missions that are called, directly or indirectly, in the order of the phases.

    Args:
        mission: A mission that was loaded without errors, so it does not call itself.
        file: Its file.
        prefix: The engine's prefix for the names of its phases.

    Raises:
        LoadError: A called mission cannot be read.
        UsageError: There is no such mission.
    """
    found: dict[str, Called] = {}
    for name, phase in mission.phases.items():
        for step, _ in model.every_step(phase.do):
            if not isinstance(step, model.CallStep):
                continue
            path = library.find_mission(step.call, file.resolve().parent)
            callee = validate(read_document(path), model.Mission)
            inside = f"{prefix}{name}/{callee.mission}."
            if inside not in found:  # a repeated call is drawn once
                found[inside] = Called(inside, callee)
                found |= {each.prefix: each for each in called_missions(callee, path, inside)}
    return tuple(found.values())


def _cluster(part: Called) -> str:
    return part.prefix.removesuffix(".")


def _title(part: Called) -> str:
    return _cluster(part).replace("/", " / ")


def _nodes(part: Called) -> Iterator[Node]:
    mission, prefix, cluster = part.mission, part.prefix, _cluster(part)
    yield Node(f"{prefix}{START}", NodeKind.INITIAL, "start", cluster=cluster)
    for name, phase in mission.phases.items():
        lines, tooltip = step_lines(phase.do), phase.description
        yield Node(f"{prefix}{name}", NodeKind.PHASE, name, lines, tooltip, cluster)
    if mission.on_failure is not None or mission.on_fault:
        ignored = tuple(
            f"{code}{handler.whose}: go on"
            for handler in mission.on_fault
            if handler.go is None
            for code in handler.fault
        )
        tooltip = "From whichever phase is current, unless it says otherwise"
        yield Node(
            f"{prefix}{ANY_PHASE}", NodeKind.ANYWHERE, "any phase", ignored, tooltip, cluster
        )
    for name, end in mission.ends.items():
        kind = NodeKind.FAIL if end.succeed is None else NodeKind.SUCCEED
        message = end.fail if end.succeed is None else end.succeed
        yield Node(f"{prefix}{name}", kind, name, (message or "",), cluster=cluster)


def _edges(part: Called) -> Iterator[Edge]:
    mission, prefix = part.mission, part.prefix
    begins = [f"{region}={state}" for region, state in (mission.starts_in or {}).items()]
    if mission.control is not None:
        begins.append(f"control {mission.control}")
    start = f"{prefix}{mission.start}"
    yield Edge(f"{prefix}{START}", start, EdgeKind.START, ", ".join(begins))
    for name, phase in mission.phases.items():
        for target, kind, label in _ways(phase):
            yield Edge(f"{prefix}{name}", f"{prefix}{target}", kind, label)
    anywhere = f"{prefix}{ANY_PHASE}"
    if mission.on_failure is not None:
        yield Edge(anywhere, f"{prefix}{mission.on_failure}", EdgeKind.FAILURE, "a step fails")
    for handler in mission.on_fault:
        if handler.go is not None:
            label = ", ".join(handler.fault) + handler.whose
            yield Edge(anywhere, f"{prefix}{handler.go}", EdgeKind.FAULT, label)


def _ways(phase: model.Phase) -> Iterator[tuple[str, EdgeKind, str]]:
    """Yield each transition out of the phase: its target, kind and label."""
    if phase.go is not None:
        yield phase.go, EdgeKind.GO, ""
    yield from _wait_ways(phase)
    for step, _ in model.every_step(phase.do):
        if isinstance(step, model.WaitStep):
            yield from _wait_ways(step)
        if isinstance(step, model.AskStep):
            for answer, leads in step.choices.items():
                if leads not in {model.CONTINUE, model.FAIL}:
                    yield leads, EdgeKind.TRIGGER, f"answer: {answer}"
        if step.on_failure not in {None, model.CONTINUE}:
            yield str(step.on_failure), EdgeKind.FAILURE, f"{short(step)} fails"
    if phase.on_failure is not None:
        yield phase.on_failure, EdgeKind.FAILURE, "a step fails"


def _wait_ways(it: model.Phase | model.WaitStep) -> Iterator[tuple[str, EdgeKind, str]]:
    """Yield the transitions of a wait that lead to a phase or end."""
    for trigger in it.wait:
        if trigger.go is not None:
            yield trigger.go, EdgeKind.TRIGGER, trigger_text(trigger)
    if it.within is not None and it.within.go is not None:
        yield it.within.go, EdgeKind.WITHIN, f"not within {amount(it.within.time, 's')}"
