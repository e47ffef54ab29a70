"""`pirate margins`: finds how far a mission holds."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from typing import Any

from pirate_sm.cli.commands.campaign import (
    AS_EXPECTED,
    BELOW,
    conduct,
    file_of,
    open_results,
    refuse_unusable,
)
from pirate_sm.cli.errors import StoppedError, say
from pirate_sm.cli.options.estimates import MarginsOptions
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import UsageError
from pirate_sm.core.fields import LONGEST_NAME
from pirate_sm.core.units import DIMENSIONLESS, QuantityError, read_quantity
from pirate_sm.core.visible import visible
from pirate_sm.lab.campaign.campaign_file import OPTIONS_GIVEN, read_campaign
from pirate_sm.lab.campaign.chunk import RunRow
from pirate_sm.lab.campaign.crew import connected
from pirate_sm.lab.campaign.falsified import keep
from pirate_sm.lab.campaign.falsify import Evaluation, Point, falsify, sides_of
from pirate_sm.lab.campaign.plan import CampaignPlan

_EXPECTED = re.compile(r"\s*([\w.:]+)\s*([<>]=\s*\S.*)")


def find_margins(options: MarginsOptions) -> int:
    """Find how far a mission holds, print it and return the exit code.

    Raises:
        LoadError: Everything that is wrong with the files.
        CheckError: The mission is refused.
        UsageError: An argument does not fit, no scheduler answers, or results cannot be kept.
        BackendError: The workers are lost; results so far are kept.
    """
    refuse_unusable(options)
    plan = _plan(options)
    return _falsify(plan, options) if options.falsify else conduct(plan, options, "none")


def _plan(options: MarginsOptions) -> CampaignPlan:
    """Return the plan that the options ask for."""
    for option, text in (("--share", options.share), ("--confidence", options.confidence)):
        if _share(option, text) == 1.0:
            raise UsageError(f"{option} {text}: no number of runs shows that of all runs")
    more = campaign_of(options)
    try:
        return read_campaign(file_of(options.mission), check=options.check, more=more)
    except LoadError as error:
        if any(each.place.file != OPTIONS_GIVEN for each in error.problems):
            raise
        raise UsageError("\n".join(each.message for each in error.problems)) from None


def _falsify(plan: CampaignPlan, options: MarginsOptions) -> int:
    """Search for the smallest change with which it fails, and print it; return the exit code."""
    within = _share("--within", options.within)
    if options.format == "junit":
        raise UsageError("--falsify prints text or JSON")
    (cell,) = plan.cells
    cell = replace(cell, seeds=(options.seed,))
    plan = replace(plan, name=f"{plan.name}_falsified"[:LONGEST_NAME], cells=(cell,), margins=None)
    try:
        with (
            open_results(plan, options) as store,
            connected(plan, options.scheduler, options.workers) as crew,
            progress(f"falsify {cell.name}") as line,
        ):
            evaluation = Evaluation(cell, store, crew, options.seed)

            def evaluate(points: Sequence[Point]) -> Sequence[RunRow]:
                rows = evaluation(points)
                line(min(evaluation.asked / options.budget, 1.0), f" ({evaluation.asked} runs)")
                return rows

            sides = sides_of(cell.around, within)
            found = falsify(sides, evaluate, options.budget, options.seed)
            kept = [keep(each, cell, store, crew) for each in found.least.values()]
    except StoppedError as stopped:
        say(str(stopped))
        return stopped.exit_code
    if options.format == "json":
        print(json.dumps({**asdict(found), "least": [asdict(each) for each in kept]}, indent=1))
        return BELOW if kept else AS_EXPECTED
    print(f"{found.runs} runs of {cell.name}, {found.wrong} of them did not pass")
    for line_ in (line_ for each in kept for line_ in each.lines()):
        print(visible(line_))
    if not kept:
        print(f"nothing was found with which it fails, within {within:.0%} of each range")
    return BELOW if kept else AS_EXPECTED


def _share(option: str, text: str) -> float:
    try:
        share = read_quantity(text, DIMENSIONLESS)
    except QuantityError as error:
        raise UsageError(f"{option} {text}: {error}") from None
    if not 0.0 < share <= 1.0:
        raise UsageError(f"{option} {text}: expected more than 0 and at most 100 %")
    return share


def campaign_of(options: MarginsOptions) -> dict[str, Any]:
    """Return what the options say, as a campaign file would.

    Raises:
        UsageError: An option has another form.
    """
    margins: dict[str, Any] = {
        "share": options.share,
        "runs": options.runs,
        "levels": options.levels,
        "halvings": options.halvings,
    }
    if options.factors:
        margins["factors"] = _factors(options.factors)
    if options.pairs:
        margins["pairs"] = [_pair(each) for each in options.pairs]
    if options.expects:
        margins["expects"] = _expected(options.expects)
    pipe = {} if options.pipe is None else {"pipe": options.pipe}
    return {"confidence": options.confidence, "margins": margins, **pipe}


def _factors(texts: Iterable[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    for text in texts:
        name, _, ends = map(str.strip, text.partition("="))
        if name in found:
            raise UsageError(f"--factor gives '{name}' twice")
        found[name] = ends or "usual"
    return found


def _pair(text: str) -> list[str]:
    names = [each.strip() for each in text.split(",")]
    if len(names) != 2:
        raise UsageError(f"--pair {text}: expected two names, such as friction,diameter")
    return names


def _expected(texts: Iterable[str]) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    for text in texts:
        match = _EXPECTED.fullmatch(text)
        if match is None:
            raise UsageError(f"--expect {text}: expected a bound such as 'friction>=0.35'")
        found.setdefault(match[1], []).append(match[2])
    return found
