"""Reads a campaign file, and makes a plan of all its cells; all faults are reported at once."""

from __future__ import annotations

import json
import os
import pickle
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import product
from pathlib import Path
from typing import Any, cast

from pydantic_core import to_jsonable_python

from pirate_sm.campaign.code_version import code_version
from pirate_sm.campaign.plan import Cell, Plan
from pirate_sm.checking.findings import Finding, finding_of
from pirate_sm.checking.gate import CheckError, pass_or_raise
from pirate_sm.errors import UsageError
from pirate_sm.loading import library, references
from pirate_sm.loading.file_names import shown
from pirate_sm.loading.mission import LoadedMission
from pirate_sm.loading.problems import LoadError, Problems
from pirate_sm.loading.problems import Path as Keys
from pirate_sm.loading.yaml.document import Document, parse_document, read_document
from pirate_sm.loading.yaml.validation import validate
from pirate_sm.model.campaign import (
    Campaign,
    CampaignMission,
    DefectSet,
    Expectation,
    TrueEnd,
    Value,
    ValueRange,
    Values,
)
from pirate_sm.model.fidelity import USUAL
from pirate_sm.model.variations import LineFaults, StartJitter
from pirate_sm.units import format_quantity
from pirate_sm.wiring import Order, load, prepare

NONE, EACH = "none", "each"

_DIGITS = 12
"""Significant digits of the values of a range."""


def is_campaign(document: Document) -> bool:
    """Return whether a file is a campaign, not a mission."""
    return isinstance(document.data, dict) and "campaign" in document.data


def read_campaign(path: Path, seeds: Sequence[int] | None = None, *, check: bool = True) -> Plan:
    """Return the plan of a campaign file, or of a mission, with some seeds.

    Args:
        path: The file.
        seeds: Seeds in place of the file's; a mission needs them.
        check: Whether a mission in which the check finds errors is refused.

    Raises:
        LoadError: Everything that is wrong with the files.
        CheckError: A mission is refused.
        UsageError: A mission is given without seeds.
    """
    document = read_document(path, shown(path))
    if is_campaign(document):
        return _Reading(document, path.parent, seeds).plan(check=check)
    if seeds is None:
        raise UsageError(f"{shown(path)} is a mission: say how often it runs with --seeds N")
    text = json.dumps({"campaign": "runs", "missions": [{"mission": str(path.resolve())}]})
    return _Reading(parse_document(text, shown(path)), Path(), seeds).plan(check=check)


def check_campaign(path: Path) -> tuple[list[Document], list[Finding]]:
    """Return the files of a campaign and all for which the campaign would be refused.

    Raises:
        LoadError: The campaign file itself cannot be read.
    """
    document = read_document(path, shown(path))
    reading = _Reading(document, path.parent, None)
    findings: list[Finding] = []
    try:
        reading.plan(check=False)
    except LoadError as error:
        findings += map(finding_of, error.problems)
    documents = [document]
    for same, (_, loaded) in reading.loaded.items():
        documents += loaded.documents
        try:
            pass_or_raise(loaded)
        except CheckError as error:
            by = document.place_of(reading.places[same]), "this campaign runs it so"
            findings += [replace(each, related=(*each.related, by)) for each in error.findings]
    return documents, findings


@dataclass
class _Reading:
    """The reading of one campaign file.

    Attributes:
        document: The file.
        folder: Its folder, to which paths in it refer.
        seeds: Seeds in place of the file's.
    """

    document: Document
    folder: Path
    seeds: Sequence[int] | None
    problems: Problems = field(init=False)
    loaded: dict[tuple[Any, ...], tuple[str, LoadedMission]] = field(default_factory=dict)
    places: dict[tuple[Any, ...], Keys] = field(default_factory=dict)
    blobs: dict[str, bytes] = field(default_factory=dict)

    def plan(self, *, check: bool) -> Plan:
        self.problems = Problems(self.document)
        campaign = validate(self.document, Campaign)
        cells: dict[str, Cell] = {}
        for number, entry in enumerate(campaign.missions):
            at: Keys = ("missions", number)
            for cell in self._cells(campaign, _Choices(campaign, entry, at)):
                if cell.name in cells:
                    message = f"there are two cells '{cell.name}': give a `name` to tell them apart"
                    self.problems.add("campaign.twice", at, message)
                cells[cell.name] = cell
        self.problems.raise_errors()
        if check:
            for _, loaded in self.loaded.values():
                pass_or_raise(loaded)
        stop = campaign.stop
        version = code_version()
        return Plan(
            campaign.campaign, version, tuple(cells.values()), campaign.confidence, stop, self.blobs
        )

    def _cells(self, campaign: Campaign, choices: _Choices) -> Iterator[Cell]:
        """Yield the cells of one mission."""
        seeds = self.seeds if self.seeds is not None else choices.of("seeds")
        if seeds is None:
            message = "nothing says how often it runs: give `seeds`, such as 0..999, or --seeds"
            self.problems.add("campaign.seeds", choices.at, message)
            return
        line = cast("LineFaults | None", choices.of("line"))
        backends = choices.of("backend") or ("sim",)
        if line is not None and "bay" not in backends:
            message = "only the backend bay has a line"
            self.problems.add("campaign.line", choices.place("line"), message)
        axes = (
            choices.of("pipe") or (None,),
            list(_settings(choices.of("set") or {})),
            backends,
            choices.of("detector") or (None,),
        )
        for pipe, settings, backend, detector in product(*axes):
            order = self._order(choices, pipe)
            if order is None:
                continue
            try:
                order = replace(order, detector=self._camera(detector))
            except UsageError as error:
                self._refer(error, "campaign.run", choices.place("detector"))
                continue
            order = replace(order, settings=settings, backend=backend)
            order = replace(order, line=line if backend == "bay" else None)
            yield from self._of_order(choices, order, pipe, detector, seeds)

    def _order(self, choices: _Choices, pipe: str | None) -> Order | None:
        """Return the order with files and numbers; None after reporting that a file is missing."""
        try:
            mission = self._file(choices.entry.mission, library.find_mission, library.missions())
        except UsageError as error:
            self._refer(error, "campaign.mission", choices.mission)
            return None
        try:
            found = pipe and self._file(pipe, library.find_pipe, library.pipes())
        except UsageError as error:
            self._refer(error, "campaign.pipe", choices.place("pipe"))
            return None
        robot, twin = choices.of("robot"), choices.of("twin")
        try:
            twin = twin and self._beside(twin)
        except UsageError as error:
            self._refer(error, "campaign.run", choices.place("twin"))
            return None
        jitter = cast("StartJitter", choices.of("jitter") or StartJitter())
        return Order(
            mission,
            pipe=found or None,
            robot=robot and self._beside(robot, followed=False),
            twin=twin,
            start_jitter_m=jitter.start,
            friction_jitter=jitter.friction,
            diameter_jitter_m=jitter.diameter,
            fidelity=choices.of("fidelity") or USUAL,
        )

    def _file(self, name: str, find: Any, ours: Sequence[Path]) -> str:
        """Return the name of a shipped file, or the path of another as seen from here."""
        found = references.followed(find(name, self.folder), self.folder)
        return name if found in ours and not library.is_path(name) else _from_here(found)

    def _beside(self, name: str, *, followed: bool = True) -> str:
        """Return a name, or the path of a file beside the campaign's as seen from here."""
        path = self.folder / name
        if not path.exists():
            return name
        return _from_here(references.followed(path, self.folder) if followed else path)

    def _refer(self, error: UsageError, code: str, at: Keys) -> None:
        """Report a reference that leads nowhere, or out of the project."""
        self.problems.add(references.code_of(error, code), at, str(error))

    def _camera(self, detector: str | None) -> str | None:
        """Return the name of a detector, with its camera's file as seen from here."""
        kind, colon, argument = (detector or "").partition(":")
        return f"{kind}:{self._beside(argument)}" if colon and kind == "vision" else detector

    def _of_order(
        self,
        choices: _Choices,
        order: Order,
        pipe: str | None,
        detector: str | None,
        seeds: Sequence[int],
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
        sets = list(self._defects(choices, loaded))
        for defects in sets:
            one = replace(order, defects=defects)
            if not self._fits(one, loaded, choices, seeds[0]):
                continue
            end = choices.of("end") or TrueEnd()
            yield Cell(
                choices.entry.name or Path(order.mission).stem,
                choices.column(one, pipe, detector, many_defects=len(sets) > 1),
                one,
                seeds,
                end,
                choices.of("expect") or Expectation(),
                _digest(one, loaded, end),
                key,
            )

    def _fits(self, order: Order, loaded: LoadedMission, choices: _Choices, seed: int) -> bool:
        """Report if an order cannot be run; return whether it can."""
        try:
            prepare(replace(order, seed=seed), loaded)
        except LoadError as error:
            for problem in error.problems:
                self.problems.put(problem)
        except UsageError as error:
            self.problems.add("campaign.run", choices.at, error.for_terminal)
        else:
            return True
        return False

    def _load(self, order: Order, at: Keys) -> tuple[str, LoadedMission]:
        """Return the order's mission and its key; each is loaded once."""
        same = (order.mission, order.pipe, order.robot, *order.settings.items())
        if same not in self.loaded:
            loaded = load(order)
            blob = pickle.dumps(loaded)
            key = sha256(blob).hexdigest()
            self.blobs[key] = blob
            self.loaded[same], self.places[same] = (key, loaded), at
        return self.loaded[same]

    def _defects(self, choices: _Choices, loaded: LoadedMission) -> Iterator[tuple[str, ...]]:
        """Yield each set of defects, of those that the robot can have."""
        known = loaded.loaded_robot.profile.simulation.defects
        wanted: tuple[DefectSet, ...] = choices.of("defects") or ((),)
        for number, listed in enumerate(wanted):
            if listed == (EACH,):
                yield from ((name,) for name in known)
                continue
            names = () if listed == (NONE,) else listed
            for name in names:
                if name not in known:
                    path = (*choices.place("defects"), number)
                    self.problems.add_unknown("campaign.defect", path, "defect", name, known)
            if all(name in known for name in names):
                yield names


@dataclass(frozen=True)
class _Choices:
    """What holds for a mission: its own choices, else the campaign's."""

    campaign: Campaign
    entry: CampaignMission
    at: Keys

    def of(self, key: str) -> Any:
        own = getattr(self.entry, key)
        return own if own is not None else getattr(self.campaign, key)

    @property
    def mission(self) -> Keys:
        """Return the keys of the mission's name in the file."""
        return (*self.at, "mission")

    def place(self, key: str) -> Keys:
        """Return the keys of a choice in the file."""
        return (*self.at, key) if getattr(self.entry, key) is not None else (key,)

    def column(
        self, order: Order, pipe: str | None, detector: str | None, *, many_defects: bool
    ) -> str:
        """Return in words what tells a cell from the others of its mission."""
        named = self.entry.name is not None
        parts = [str(pipe)] if pipe and (self._varies("pipe") or not named) else []
        parts += [f"{n} {v}" for n, v in order.settings.items() if self._varies("set", n)]
        parts += [order.backend] if self._varies("backend") else []
        parts += [str(detector)] if self._varies("detector") else []
        if many_defects or (order.defects and not named):
            parts.append(" + ".join(order.defects) or "no defect")
        return ", ".join(parts)

    def _varies(self, key: str, name: str | None = None) -> bool:
        values = self.of(key)
        if name is not None:
            values = list(_texts(values[name]))
        return values is not None and len(values) > 1


def _settings(values: dict[str, Values]) -> Iterator[dict[str, str]]:
    """Yield every combination of the values of parameters, as text."""
    names = list(values)
    for texts in product(*(list(_texts(values[name])) for name in names)):
        yield dict(zip(names, texts, strict=True))


def _texts(values: Values) -> Iterator[str]:
    """Yield the values of a parameter as text."""
    if isinstance(values, ValueRange):
        first, by = values.first.value, values.by.value
        count = int((values.last.value - first) / by + 1e-9) + 1
        for number in range(count):
            rounded = float(f"{first + number * by:.{_DIGITS}g}")
            yield format_quantity(rounded, values.first.dimension)
    elif isinstance(values, tuple):
        yield from map(_text, values)
    else:
        yield _text(values)


def _text(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _from_here(path: Path) -> str:
    """Return the path, relative to the working directory where it is below that."""
    relative = os.path.relpath(path)
    return relative if not relative.startswith("..") else str(path.resolve())


def _digest(order: Order, loaded: LoadedMission, end: TrueEnd) -> str:
    """Return a digest of all that the result of a run depends on but its seed.

    Files count by their content, not by their names, which may differ elsewhere.
    """
    rest = replace(order, mission="", pipe=None, robot=None, twin=None, seed=0)
    kind, _, camera = (order.detector or "").partition(":")
    named = [order.twin or "", camera if kind == "vision" else ""]
    parts = [
        code_version(),
        json.dumps(to_jsonable_python(rest), sort_keys=True),
        end.model_dump_json(),
        *(document.text for document in loaded.documents),
        *(Path(each).read_text("utf-8") for each in named if each and Path(each).is_file()),
    ]
    digest = sha256()
    for part in parts:
        digest.update(part.encode() + b"\0")
    return digest.hexdigest()[:16]
