"""Check a mission in its pipe: space, its bends and tees, how parts turn, its grip on a slope.

Only the course of the mission without failures is checked (`usual_course`). The loader has already
checked that the robot's parts reach the walls (`pipe.reach`).
"""

from __future__ import annotations

from pirate_sm.checking.findings import Finding
from pirate_sm.checking.pipe.bend_rules import (
    bends_in_the_plane,
    bends_to_the_inner_wall,
    keeps_off_the_mouths,
    takes_bends_that_are_there,
    turns_where_it_can,
)
from pirate_sm.checking.pipe.clamp_rules import clamps_bear_the_weight
from pirate_sm.checking.pipe.pipe_view import PipeView
from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.checking.pipe.roll_rules import turns_what_is_slack
from pirate_sm.checking.pipe.space_rules import holds_after_the_bend, starts_clear_of_bends
from pirate_sm.checking.pipe.usual_course import course_of
from pirate_sm.core.loading import LoadedMission

RULES = (
    starts_clear_of_bends,
    bends_to_the_inner_wall,
    bends_in_the_plane,
    keeps_off_the_mouths,
    holds_after_the_bend,
    turns_what_is_slack,
    clamps_bear_the_weight,
    takes_bends_that_are_there,
    turns_where_it_can,
)
"""All rules about missions in pipes; each yields the findings of a `PipeView`."""


def view_in_pipe(loaded: LoadedMission) -> PipeView | None:
    """Return a mission as seen in its pipe; None without a pipe, or if its course is too large."""
    if loaded.pipe is None:
        return None
    profile = loaded.loaded_robot.profile
    fit = Fit(profile, loaded.robot, loaded.pipe)
    bends = sum(1 for joint in fit.route.joints if joint.turn_rad)
    course = course_of(fit.force, loaded.program, bends)
    return PipeView(loaded, loaded.pipe, course, fit) if course is not None else None


def pipe_findings(view: PipeView) -> list[Finding]:
    """Return the findings about a mission in its pipe."""
    return [finding for rule in RULES for finding in rule(view)]
