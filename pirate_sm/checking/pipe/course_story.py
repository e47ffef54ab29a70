"""The story of a finding about the course of a mission: the commands that lead to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.pipe.course_points import CoursePoint
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.roll_joint import Rolls
from pirate_sm.engine.mission.program import Do


def story_of(finding: Finding, view: PipeView, point: CoursePoint) -> Finding:
    """Return a finding with its story: one sentence for each step that leads to a point."""
    steps = {
        each.place: view.fit.robot.commands[each.command].name
        for each in view.loaded.program.instructions
        if isinstance(each, Do)
    }
    return replace(finding, story=tuple(_sentences(view, point, steps)))


def _sentences(view: PipeView, point: CoursePoint, steps: dict[str, str]) -> Iterator[str]:
    yield "the mission begins"
    rolls = view.course.situations[0].rolls
    for each in view.course.way_to(point):
        name = steps.get(each.place, "the control")
        yield f"{name} ({each.place}) is done{_turned(view, rolls, each.rolls)}"
        rolls = each.rolls


def _turned(view: PipeView, before: Rolls | None, after: Rolls | None) -> str:
    """Return which part a command has turned, with its angle; empty if none."""
    if before is None or after is None or before == after:
        return ""
    joint = view.roll_joint
    ahead = before.ahead != after.ahead
    names = [
        name for part, name in enumerate(view.fit.robot.parts) if joint.is_ahead(part) == ahead
    ]
    change = after.ahead - before.ahead if ahead else after.behind - before.behind
    turned = f"{(change + 2) % 4 - 2:+.3g} quarter turn"
    return f"; it rolls '{' and '.join(names)}' by {turned}"
