"""Check a mission in its pipe: space, the direction of its bends, its grip on a slope.

Only the course of the mission without failures is checked (`usual_course`). The loader has already
checked that the robot's parts reach the walls (`pipe.reach`).
"""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.pipe.bend_sides import bends_to_the_inner_wall
from pirate_sm.checking.pipe.clamp_hold import clamps_bear_the_weight
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.checking.pipe.room import holds_behind_the_bend, starts_clear_of_bends
from pirate_sm.checking.pipe.usual_course import course_of
from pirate_sm.loading.mission import LoadedMission

RULES = (
    starts_clear_of_bends,
    bends_to_the_inner_wall,
    holds_behind_the_bend,
    clamps_bear_the_weight,
)
"""All rules about missions in pipes; each yields the findings of a `PipeView`."""


def pipe_findings(loaded: LoadedMission) -> Iterator[Finding]:
    """Yield the findings about a mission in its pipe; none without a pipe."""
    if loaded.pipe is None:
        return
    profile = loaded.loaded_robot.profile
    course = course_of(loaded.robot, loaded.program, profile)
    if course is None:
        return
    view = PipeView(loaded, loaded.pipe, course, Fit(profile, loaded.robot, loaded.pipe))
    for rule in RULES:
        yield from rule(view)
