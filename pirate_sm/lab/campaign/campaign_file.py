"""Reads a campaign file, and makes a plan of all its cells; all faults are reported together."""

from __future__ import annotations

import json
import pickle
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import product
from math import prod
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pirate_sm.checking.findings import Finding, finding_of
from pirate_sm.checking.gate import CheckError, all_pass_or_raise, pass_or_raise
from pirate_sm.core import library
from pirate_sm.core.documents import (
    Document,
    FileKind,
    LoadError,
    Problems,
    Severity,
    kind_of_text,
    parse_document,
    read_document,
)
from pirate_sm.core.documents import Path as Keys
from pirate_sm.core.errors import PirateError, UsageError
from pirate_sm.core.fields import LONGEST_NAME
from pirate_sm.core.library import shown
from pirate_sm.core.loading import LoadedMission, check_twin, references, try_validate
from pirate_sm.core.options import OPTIONS
from pirate_sm.lab.campaign.campaign_model import Campaign, Expectation, StoppingRule, TrueEnd
from pirate_sm.lab.campaign.cell_checks import check_end, check_jitter, factors_or_problems
from pirate_sm.lab.campaign.chunk import sampled_factors
from pirate_sm.lab.campaign.intervals import wilson
from pirate_sm.lab.campaign.margins_model import Margins
from pirate_sm.lab.campaign.named_parts import (
    Choices,
    Named,
    NameReader,
    choices_of,
    faultless_choices,
    texts,
)
from pirate_sm.lab.campaign.plan import CampaignPlan, Cell, code_version, key_of
from pirate_sm.lab.campaign.sensitivity import Design
from pirate_sm.lab.campaign.sensitivity_model import DrawnNumbers
from pirate_sm.running.wiring import Order, load, prepare

OPTIONS_GIVEN = "the options"
"""Stands for the file of a campaign that options describe."""

MOST_CELLS = 10_000
"""Most cells of one mission. [decided: each is prepared before the first run]"""


def is_campaign(document: Document) -> bool:
    """Return whether a file is a campaign, not a mission."""
    return isinstance(document.data, dict) and "campaign" in document.data


def read_campaign(
    path: Path,
    seeds: Sequence[int] | None = None,
    *,
    check: bool = True,
    more: Mapping[str, Any] = MappingProxyType({}),
) -> CampaignPlan:
    """Return the plan of a campaign file, or of a mission, with some seeds.

    Args:
        path: The file.
        seeds: Seeds instead of the file's; a mission needs them.
        check: Whether a mission in which the check finds errors is refused.
        more: What the campaign of a mission says besides, as in a file; with `margins` no seeds.

    Raises:
        LoadError: Everything that is wrong with the files.
        CheckError: A mission is refused.
        UsageError: A mission is given without seeds.
    """
    document = read_document(path)
    if is_campaign(document):
        if more:
            raise UsageError(f"{shown(path)} is a campaign: name a mission")
        return _Reading(document, path.parent, seeds).plan(check=check)
    kind = kind_of_text(document.text)
    if kind is not FileKind.MISSION:
        raise UsageError(f"{shown(path)} is neither a campaign nor a mission: {_what(kind)}")
    if seeds is None and "margins" not in more:
        raise UsageError(f"{shown(path)} is a mission: say how often it runs with --seeds N")
    one = {"campaign": campaign_of_one(path), "missions": [{"mission": str(path.resolve())}]}
    text = json.dumps({"format": 1, **one, **more})
    named = OPTIONS_GIVEN if more else shown(path)
    return _Reading(parse_document(text, named), Path(), seeds).plan(check=check)


def check_campaign(path: Path) -> tuple[list[Document], list[Finding]]:
    """Return the files of a campaign and all for which the campaign would be refused.

    Raises:
        LoadError: The campaign file itself cannot be read.
    """
    document = read_document(path)
    reading = _Reading(document, path.parent, None, keyed=False)
    findings: list[Finding] = []
    try:
        reading.plan(check=False)
    except LoadError as error:
        findings += map(finding_of, error.problems)
    else:
        findings += map(finding_of, reading.problems.all)
    documents = [document]
    for same, (_, loaded) in reading.loaded.items():
        documents += loaded.documents
        found: Iterable[Finding]
        try:
            found = [
                each for each in pass_or_raise(loaded, backend="sim") if each.code in _BY_VALUE
            ]
        except CheckError as error:
            found = error.findings
        by = document.place_of(reading.places[same])
        if any(same[1:]):  # it may be right without the choices of the campaign
            for each in found:
                said = f"with these choices {each.place} is wrong: {each.message}"
                excerpt = document.excerpt(by.line, by.file)
                findings.append(replace(each, place=by, message=said, excerpt=excerpt, edit=None))
        elif found := [each for each in found if each.code not in _BY_VALUE]:
            why = by, "this campaign runs it so"
            findings += [replace(each, related=(*each.related, why)) for each in found]
    return documents, findings


_BY_VALUE = frozenset({"condition.beyond"})
"""Codes of warnings that a value which a campaign gives to a parameter can bring about."""


def campaign_of_one(mission: Path) -> str:
    """Return the name of the campaign of one mission: that of its file, as a name may be."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", mission.stem)
    return (plain if plain[:1].isalpha() else f"mission_{plain}")[:LONGEST_NAME]


def _what(kind: FileKind) -> str:
    """Return what a file is that is no mission, or what it lacks."""
    if kind is FileKind.OTHER:
        return "it has neither `campaign` and `missions` nor `mission`, `start` and `phases`"
    return f"it is {'an' if kind[0] in 'aeiou' else 'a'} {kind}"


@dataclass
class _Reading:
    """The reading of one campaign file.

    Attributes:
        document: The file.
        folder: Its folder, to which paths in it refer.
        seeds: Seeds instead of the file's.
        keyed: Whether there are keys for runs: missions are pickled, and keys tell the
            points of a sensitivity apart, which takes SALib.
    """

    document: Document
    folder: Path
    seeds: Sequence[int] | None
    keyed: bool = True
    problems: Problems = field(init=False)
    loaded: dict[tuple[Any, ...], tuple[str, LoadedMission]] = field(default_factory=dict)
    places: dict[tuple[Any, ...], Keys] = field(default_factory=dict)
    blobs: dict[str, bytes] = field(default_factory=dict)
    drawn: DrawnNumbers | None = None
    margins: Margins | None = None
    design: Design | None = None

    def plan(self, *, check: bool) -> CampaignPlan:
        self.problems = Problems(self.document)
        names = NameReader(self.folder, self.problems)
        campaign = try_validate(self.document, Campaign, self.problems)
        if campaign is None:
            for choices in faultless_choices(self.document.data):
                names.read(choices)
            raise LoadError(self.problems.all)
        cells: dict[str, Cell] = {}
        self._take_sensitivity(campaign)
        self._take_margins(campaign)
        for choices in choices_of(campaign):
            twice = self._check(choices)
            named = names.read(choices)
            for cell in self._cells(choices, named) if named is not None and not twice else ():
                if cell.name in cells:
                    message = f"there are two cells '{cell.name}': give a `name` to tell them apart"
                    self.problems.add("campaign.twice", choices.at, message)
                cells[cell.name] = cell
        self.problems.raise_errors()
        if check:
            all_pass_or_raise(loaded for _, loaded in self.loaded.values())
        stop = campaign.stop
        self._check_stop(stop, campaign.confidence, cells.values())
        version = code_version()
        rest = campaign.confidence, stop, self.blobs, self.margins
        return CampaignPlan(campaign.campaign, version, tuple(cells.values()), *rest)

    def _take_sensitivity(self, campaign: Campaign) -> None:
        """Take how runs vary the robot, and report what does not go with that."""
        if (wanted := campaign.sensitivity) is None:
            return
        if campaign.stop != StoppingRule():
            self.problems.add("campaign.sensitivity", ("stop",), "indices need all runs: delete it")
        self.drawn = wanted.numbers
        self.design = Design(wanted.method, wanted.points, wanted.numbers.factors)

    def _take_margins(self, campaign: Campaign) -> None:
        """Take how far cells are to hold, and report what does not go with that."""
        self.margins = campaign.margins
        for key in ("stop", "sensitivity") if campaign.margins is not None else ():
            if getattr(campaign, key) not in (None, StoppingRule()):
                message = "a test ends each value of `margins`: delete it"
                self.problems.add("campaign.margins", (key,), message)
        if self.margins and (problem := self.margins.cannot_end(campaign.confidence)):
            self.problems.add("campaign.margins", ("margins",), problem)

    def _check(self, choices: Choices) -> bool:
        """Report choices that do not go with each other; return whether one is listed twice."""
        if self.margins is not None:
            if self.seeds is not None or choices.of("seeds") is not None:
                message = "`runs` of `margins` say how often it runs at most: leave seeds out"
                self.problems.add("campaign.margins", choices.place("seeds"), message)
        elif self.design is not None:
            if self.seeds is not None or choices.of("seeds") is not None:
                message = "`points` say how often it runs: leave seeds out"
                self.problems.add("campaign.sensitivity", choices.place("seeds"), message)
        elif self.seeds is None and choices.of("seeds") is None:
            message = "nothing says how often it runs: give `seeds`, such as 0..999, or --seeds"
            self.problems.add("campaign.seeds", choices.at, message)
        if choices.of("line") is not None and "bay" not in _backends(choices):
            message = "only the backend bay has a line"
            self.problems.add("campaign.line", choices.place("line"), message)
        twice = False
        for key in ("pipe", "backend", "detector", "defects"):
            listed = choices.of(key) or ()
            for number, each in enumerate(listed):
                if each in listed[:number]:
                    twice, at = True, (*choices.place(key), number)
                    self.problems.add("campaign.twice", at, "this is listed twice: delete one")
        return twice

    def _check_stop(self, stop: StoppingRule, confidence: float, cells: Iterable[Cell]) -> None:
        """Report a half width that no cell can come to with its seeds."""
        if stop.half_width is None or self.seeds is not None:
            return
        most = max((len(cell.seeds) for cell in cells), default=0)
        least = wilson(most, most, confidence).half_width
        if most > 1 and least > stop.half_width:  # one seed tries the campaign
            message = f"with {most} seeds an interval is {least:.2%} to each side at best"
            expected = "a larger half_width, or more seeds"
            at, severity = ("stop", "half_width"), Severity.WARNING
            self.problems.add("campaign.run", at, message, expected=expected, severity=severity)

    def _cells(self, choices: Choices, named: Named) -> Iterator[Cell]:
        """Yield the cells of one mission."""
        seeds = self.seeds if self.seeds is not None else choices.of("seeds")
        seeds = seeds if self.design is None else range(self.design.runs)
        seeds = seeds if self.margins is None else range(self.margins.runs)
        common = choices.order(named.mission, robot=named.robot, twin=named.twin)
        sets = {name: list(texts(each)) for name, each in (choices.of("set") or {}).items()}
        count = prod(map(len, (named.pipes, *sets.values(), named.detectors, named.defects)))
        if count * len(_backends(choices)) > MOST_CELLS:
            message = f"this mission has more than {MOST_CELLS:,} cells: leave out some choices"
            self.problems.add("campaign.run", choices.at, message)
            return
        for pipe, texts_of, backend, detector in product(
            named.pipes, product(*sets.values()), _backends(choices), named.detectors
        ):
            order = replace(
                common,
                pipe=pipe[1],
                settings={name: text for name, (_, text) in zip(sets, texts_of, strict=True)},
                backend=backend,
                detector=detector[1],
                line=choices.of("line") if backend == "bay" else None,
            )
            yield from self._of_order(choices, named, order, pipe[0], detector[0], seeds)

    def _of_order(
        self,
        choices: Choices,
        named: Named,
        order: Order,
        pipe: str | None,
        detector: str | None,
        seeds: Sequence[int] | None,
    ) -> Iterator[Cell]:
        """Yield the cells of an order: one for each set of defects."""
        try:
            key, loaded = self._load(order, choices.at)
        except LoadError as error:
            file = library.find_mission(order.mission)
            references.tell(error, file, references.MISSION, choices.mission, self.problems)
            return
        except UsageError as error:
            self.problems.add("campaign.mission", choices.at, str(error))
            return
        for defects in named.defects:
            one = replace(order, defects=defects)
            if not self._fits(replace(one, seed=(seeds or (0,))[0]), loaded, choices):
                continue
            if seeds is None:
                continue  # reported already
            end = choices.of("end") or TrueEnd()
            check_end(end, loaded, choices, self.problems)
            if self.drawn is not None:
                least, profile = self.drawn.least(loaded.robot.name), loaded.loaded_robot.profile
                check_twin(least, profile, self.problems, ("sensitivity", "numbers"))
                self._check_ends(replace(one, seed=0), loaded)
            check_jitter(one, loaded, choices, self.problems)
            yield Cell(
                choices.entry.name or Path(order.mission).stem,
                choices.column(one, pipe, detector, many_defects=len(named.defects) > 1),
                one,
                seeds,
                end,
                choices.of("expect") or Expectation(),
                key_of(one, loaded, end, self.design if self.keyed and not self._faulty else None),
                key,
                self.design,
                sampled_factors(one),
                factors_or_problems(one, loaded, self.margins, self.problems),
            )

    @property
    def _faulty(self) -> bool:
        return any(each.severity is Severity.ERROR for each in self.problems.all)

    def _check_ends(self, order: Order, loaded: LoadedMission) -> None:
        """Report an end of a range with which no run can begin."""
        if self.design is None or self._faulty:
            return  # a motor that is not there would be reported again
        low = {each.name: each.low for each in self.design.numbers}
        for each in self.design.numbers:
            for end in (each.low, each.high):
                numbers = self.design.written({**low, each.name: end})
                try:
                    prepare(replace(order, numbers=numbers), loaded)
                except (LoadError, UsageError) as error:
                    at = ("sensitivity", "numbers", *each.name.split("."))
                    message = f"with {numbers[each.name]} no run can begin: {error}"
                    self.problems.add("campaign.sensitivity", at, message)

    def _fits(self, order: Order, loaded: LoadedMission, choices: Choices) -> bool:
        """Report if an order cannot be run; return whether it can."""
        try:
            prepare(order, loaded)
        except LoadError as error:
            self.problems.take(error)
        except UsageError as error:
            self.problems.add("campaign.run", _blamed(order, loaded, choices), str(error))
        else:
            return True
        return False

    def _load(self, order: Order, at: Keys) -> tuple[str, LoadedMission]:
        """Return the order's mission and its key; each is loaded once."""
        same = (order.mission, order.pipe, order.robot, *order.settings.items())
        if same not in self.loaded:
            loaded = load(order)
            blob = pickle.dumps(loaded) if self.keyed else repr(same).encode()
            key = sha256(blob).hexdigest()
            self.blobs[key] = blob
            self.loaded[same], self.places[same] = (key, loaded), at
        return self.loaded[same]


def _backends(choices: Choices) -> Sequence[str]:
    return choices.of("backend") or ("sim",)


def _blamed(order: Order, loaded: LoadedMission, choices: Choices) -> Keys:
    """Return the place of the choice without which an order could be run, else of its mission."""
    usual = defaultdict[str, dict[str, Any]](dict)
    for name, each in reversed([*OPTIONS.items()]):  # the backend last
        if each.in_campaigns:
            usual[each.word][name] = each.default
    for key, values in usual.items():
        if choices.of(key) is not None:
            try:
                prepare(replace(order, **values), loaded)
            except PirateError:
                continue
            return choices.place(key)
    return choices.at
