"""Checks what a campaign says of a cell by its pipe and its robot."""

from __future__ import annotations

from pirate_sm.checking.pipe.robot_in_pipe import Fit
from pirate_sm.core.documents import LoadError, Problems, Severity
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.spelling import unknown
from pirate_sm.lab.campaign.campaign_model import TrueEnd
from pirate_sm.lab.campaign.margin_factors import check_bound, factors_around
from pirate_sm.lab.campaign.margins_model import MarginFactor, Margins
from pirate_sm.lab.campaign.named_parts import Choices
from pirate_sm.running.wiring import Order


def check_end(end: TrueEnd, loaded: LoadedMission, choices: Choices, problems: Problems) -> None:
    """Report an end that no robot can come to in this pipe."""
    pipe, place = loaded.pipe, choices.place("end")
    profile = loaded.loaded_robot.profile
    worded = any(each.forward for each in profile.detector.words.values())
    if end.at_word and not (pipe is not None and worded and pipe.route().crossings_m):
        message = "at_word: nothing says a word here, which is about a bend of the pipe"
        problems.add("campaign.run", (*place, "at_word"), message)
    if pipe is None or end.beyond is end.before is None:
        return
    length_m, fit = pipe.route().length_m, Fit(profile, loaded.robot, pipe)
    robot_m = min(fit.clamped_m(each.diameter_m) for each in pipe.route().pieces)
    before_m = length_m if end.before is None else end.before
    key, beyond_m = ("before", 0.0) if end.beyond is None else ("beyond", end.beyond)
    if beyond_m >= length_m:
        message = f"beyond: {beyond_m:g} m is not in the pipe, which is {length_m:g} m long"
        problems.add("campaign.run", place, message)
    elif before_m - beyond_m < robot_m:
        between = f"the clamped robot, {robot_m:.3g} m long, is not between {beyond_m:g} m"
        message = f"{between} and {before_m:g} m: no run can end there"
        problems.add("campaign.run", (*place, key), message)


def check_jitter(order: Order, loaded: LoadedMission, choices: Choices, problems: Problems) -> None:
    """Report that a start can be drawn outside of the pipe."""
    fit = loaded.pipe and Fit(loaded.loaded_robot.profile, loaded.robot, loaded.pipe)
    if fit and order.start_jitter_m:
        start_m = fit.pipe.start_of(fit.stretched_m)
        least_m = min(start_m - fit.stretched_m, fit.route.length_m - start_m)
        if order.start_jitter_m > least_m:
            message = f"the robot would start outside of the pipe from {least_m:.3g} m on"
            at, severity = (*choices.place("jitter"), "start"), Severity.WARNING
            problems.add("campaign.run", at, message, severity=severity)


def factors_or_problems(
    order: Order, loaded: LoadedMission, wanted: Margins | None, problems: Problems
) -> tuple[MarginFactor, ...]:
    """Return the factors that are changed round a cell; report those that do not fit."""
    if wanted is None:
        return ()
    try:
        found = {each.name: each for each in factors_around(order, loaded, wanted)}
        asked = [*wanted.expects, *(name for pair in wanted.pairs for name in pair)]
        if wrong := unknown("there is no factor", asked, found):
            raise UsageError(wrong)
        for name, bounds in wanted.expects.items():
            for bound in bounds:
                check_bound(found[name], bound)
    except (LoadError, UsageError) as error:
        problems.add("campaign.margins", ("margins",), str(error))
        return ()
    return tuple(found.values())
