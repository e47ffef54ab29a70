"""Check a mission in its pipe: space, its bends and tees, how parts turn, its grip on a slope.

Only the course of the mission without failures is checked (`usual_course`). The loader has already
checked that the robot's parts reach the walls (`pipe.reach`).
"""

from __future__ import annotations

from collections.abc import Iterator

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.pipe.bend_planes import bends_in_the_plane
from pirate_sm.checking.pipe.bend_sides import bends_to_the_inner_wall
from pirate_sm.checking.pipe.clamp_hold import clamps_bear_the_weight
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.checking.pipe.room import holds_behind_the_bend, starts_clear_of_bends
from pirate_sm.checking.pipe.tee_mouths import keeps_off_the_mouths
from pirate_sm.checking.pipe.turning import turns_what_is_slack
from pirate_sm.checking.pipe.usual_course import course_of
from pirate_sm.loading.mission import LoadedMission

RULES = (
    starts_clear_of_bends,
    bends_to_the_inner_wall,
    bends_in_the_plane,
    keeps_off_the_mouths,
    holds_behind_the_bend,
    turns_what_is_slack,
    clamps_bear_the_weight,
)
"""All rules about missions in pipes; each yields the findings of a `PipeView`."""


def pipe_findings(loaded: LoadedMission) -> Iterator[Finding]:
    """Yield the findings about a mission in its pipe; none without a pipe."""
    if loaded.pipe is None:
        return
    profile = loaded.loaded_robot.profile
    fit = Fit(profile, loaded.robot, loaded.pipe)
    bends = sum(1 for joint in fit.route.joints if joint.turn_rad)
    course = course_of(loaded.robot, loaded.program, profile, bends)
    if course is None:
        return
    view = PipeView(loaded, loaded.pipe, course, fit)
    for rule in RULES:
        yield from rule(view)
