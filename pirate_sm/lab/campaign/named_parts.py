"""Find what the names in a campaign stand for, and report every unknown one.

A mission of a campaign has its own choices, else the campaign's.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from pydantic import ValidationError

from pirate_sm.core import library
from pirate_sm.core.documents import LoadError, Problems, Severity
from pirate_sm.core.documents import Path as Keys
from pirate_sm.core.errors import UsageError
from pirate_sm.core.fields import FROM_FILE
from pirate_sm.core.loading import (
    TOLERABLE,
    LoadedMission,
    load_mission,
    load_pipe,
    read_value,
    references,
    simulated_profile,
    twin_named,
)
from pirate_sm.core.models import Profile
from pirate_sm.core.on_disk import is_there, resolved
from pirate_sm.core.options import OPTIONS
from pirate_sm.core.robot import ChartTable
from pirate_sm.core.units import QuantityError, format_quantity
from pirate_sm.lab.campaign.campaign_model import (
    Campaign,
    CampaignMission,
    DefectSet,
    RunChoices,
    Value,
    ValueRange,
    Values,
)
from pirate_sm.robot.camera_file import opened_by
from pirate_sm.robot.detectors.registry import DETECTORS
from pirate_sm.running.wiring import Order
from pirate_sm.simulation.defects import named

# --- choices -------------------------------------------------------------------------------------


R = TypeVar("R", bound=RunChoices)

_DIGITS = 12
"""Significant digits of the values of a range."""


@dataclass(frozen=True)
class Choices:
    """What holds for a mission: its own choices, else the campaign's.

    Attributes:
        common: The campaign's choices.
        entry: The mission with its own.
        at: Keys of the mission in the file.
    """

    common: RunChoices
    entry: CampaignMission
    at: Keys

    def of(self, key: str) -> Any:
        """Return a choice; None if it is left open."""
        own = getattr(self.entry, key)
        return own if own is not None else getattr(self.common, key)

    def order(self, mission: str, **names: Any) -> Order:
        """Return the order of the mission with all choices of one value."""
        one: dict[str, Any] = {}
        for name, each in OPTIONS.items():
            value = self.of(each.word) if each.in_campaigns == "one" else None
            if value is not None:
                one[name] = getattr(value, each.key) if each.key else value
        return Order(mission, **one | names)

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
        """Return in words what distinguishes a cell from the others of its mission."""
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
            values = list(texts(values[name]))
        return values is not None and len(values) > 1


def choices_of(campaign: Campaign) -> Iterator[Choices]:
    """Yield the choices of each mission of a campaign."""
    for number, entry in enumerate(campaign.missions):
        yield Choices(campaign, entry, ("missions", number))


def faultless_choices(data: Any) -> Iterator[Choices]:
    """Yield the choices of each mission of a faulty campaign, without those that have faults.

    This allows checking the names in all others.
    """
    listed = data.get("missions") if isinstance(data, dict) else None
    for number, entry in enumerate(listed if isinstance(listed, list) else ()):
        own = {"mission": entry} if isinstance(entry, str) else entry
        if isinstance(own, dict) and isinstance(own.get("mission"), str):
            kept = _without_faults(CampaignMission, own)
            yield Choices(_without_faults(RunChoices, data), kept, ("missions", number))


def _without_faults(model: type[R], data: dict[str, Any]) -> R:
    """Return the model of a mapping, without the keys in which there are faults."""
    like_a_file: dict[str, Any] = {"context": dict(FROM_FILE), "by_alias": True, "by_name": False}
    try:
        return model.model_validate(data, **like_a_file)
    except ValidationError as error:
        faulty = {each["loc"][0] for each in error.errors()}
    kept = {key: value for key, value in data.items() if key not in faulty}
    return model.model_validate(kept, **like_a_file)


def texts(values: Values) -> Iterator[tuple[Keys, str]]:
    """Yield each value of a parameter as text, with the keys that lead to it."""
    if isinstance(values, ValueRange):
        first, by = values.first.value, values.by.value
        for number in range(values.count):
            rounded = float(f"{first + number * by:.{_DIGITS}g}")
            place: Keys = ("to",) if number else ("from",)
            yield place, format_quantity(rounded, values.first.dimension)
    elif isinstance(values, tuple):
        for number, value in enumerate(values):
            yield (number,), _text(value)
    else:
        yield (), _text(values)


def _text(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


# --- names ---------------------------------------------------------------------------------------


NONE, EACH = "none", "each"


class Named(NamedTuple):
    """What the names of a mission's choices mean.

    Attributes:
        mission: The mission, as :class:`~pirate_sm.running.wiring.Order` names it; so are the
            others.
        robot: The robot, instead of the mission's.
        twin: The file with numbers of the simulated robot, and which robot of its sample.
        pipes: The pipes as they are written and as orders name them.
        detectors: The detectors, likewise.
        defects: The sets of defects.
    """

    mission: str
    robot: str | None
    twin: str | None
    pipes: Sequence[tuple[str | None, str | None]]
    detectors: Sequence[tuple[str | None, str | None]]
    defects: Sequence[tuple[str, ...]]


@dataclass
class NameReader:
    """Reads the names of missions in a campaign.

    Attributes:
        folder: The campaign's folder, to which paths refer.
        problems: Takes the faults.
    """

    folder: Path
    problems: Problems
    _read: dict[tuple[str | None, ...], LoadedMission | None] = field(default_factory=dict)

    def read(self, choices: Choices) -> Named | None:
        """Return what the names of a mission's choices mean; None after reporting all faults."""
        before = len(self.problems.errors)
        mission = self._found(
            choices.entry.mission,
            library.find_mission,
            library.missions(),
            "campaign.mission",
            choices.mission,
        )
        robot = self._robot(choices)
        pipes = [(name, self._pipe(name, at)) for name, at in _listed(choices, "pipe")]
        detectors = [(name, self._detector(name, at)) for name, at in _listed(choices, "detector")]
        twin = choices.of("twin") and self._twin(choices.of("twin"), choices.place("twin"))
        if mission is None or (robot is None and choices.of("robot") is not None):
            return None
        pipe = next((found for _, found in pipes if found is not None), None)
        loaded = self._mission(mission, robot, pipe, choices.mission)
        if loaded is None:
            return None
        profile = loaded.loaded_robot.profile
        self._check_settings(choices, loaded)
        defects = list(self._defects(choices, loaded))
        self._check_states(choices, loaded.robot.table)
        if twin is not None:
            self._check_twin(twin, profile)
        if len(self.problems.errors) > before:
            return None
        return Named(
            mission, robot, twin, pipes or [(None, None)], detectors or [(None, None)], defects
        )

    def _found(
        self,
        name: str,
        find: Callable[[str, Path], Path],
        ours: Sequence[Path],
        code: str,
        at: Keys,
    ) -> str | None:
        """Return the name of a shipped file, or the path of another as seen from here."""
        try:
            found = references.followed(find(name, self.folder), self.folder)
        except UsageError as error:
            self._refer(error, code, at)
            return None
        return name if found in ours and not library.is_path(name) else from_here(found)

    def _robot(self, choices: Choices) -> str | None:
        name = choices.of("robot")
        if name is None:
            return None
        robot = self._beside(name, followed=False)
        try:
            library.find_robot(robot)
        except UsageError as error:
            self._refer(error, "campaign.mission", choices.place("robot"))
            return None
        return robot

    def _pipe(self, name: str, at: Keys) -> str | None:
        found = self._found(name, library.find_pipe, library.pipes(), "campaign.pipe", at)
        if found is None:
            return None
        file = library.find_pipe(found)
        try:
            load_pipe(file)
        except LoadError as error:
            references.tell(error, file, references.PIPE, at, self.problems)
            return None
        return found

    def _detector(self, name: str, at: Keys) -> str | None:
        """Return the name of a detector, with its camera's file as seen from here."""
        kind, _, argument = name.partition(":")
        try:
            DETECTORS.find(kind)
            seen = f"{kind}:{self._beside(argument)}" if kind == "vision" and argument else name
            if opened := opened_by(seen, Path.cwd()):
                raise UsageError(f"a campaign only simulates: '{name}' opens {opened}")
            return seen
        except LoadError as error:
            self.problems.take(error)
            return None
        except UsageError as error:
            self._refer(error, "campaign.run", at)
            return None

    def _twin(self, name: str, at: Keys) -> str | None:
        file, _ = twin_named(name, 0)
        try:
            found = self._beside(file)
            if not is_there(Path(found)):
                raise UsageError(f"there is no file '{file}' with numbers of a simulated robot")
        except UsageError as error:
            self._refer(error, "campaign.run", at)
            return None
        return found + name[len(file) :]

    def _check_twin(self, name: str, profile: Profile) -> None:
        try:
            simulated_profile(profile, name)
        except LoadError as error:
            self.problems.take(error)

    def _beside(self, name: str, *, followed: bool = True) -> str:
        """Return a name, or the path of a file next to the campaign's as seen from here."""
        path = self.folder / name
        try:
            if not is_there(path):
                return name
        except (OSError, ValueError):  # no file can have this name
            return name
        return from_here(references.followed(path, self.folder) if followed else path)

    def _refer(self, error: UsageError, code: str, at: Keys) -> None:
        """Report a reference that leads nowhere, or out of the project."""
        self.problems.add(references.code_of(error, code), at, str(error))

    def _mission(
        self, mission: str, robot: str | None, pipe: str | None, at: Keys
    ) -> LoadedMission | None:
        """Return the mission without the campaign's values; None after reporting its faults."""
        same = mission, robot, pipe
        if same not in self._read:
            self._read[same] = None
            file = library.find_mission(mission)
            try:
                loaded = load_mission(file, robot=robot, pipe=pipe, tolerated=TOLERABLE)
                if any(each.severity is Severity.ERROR for each in loaded.problems):
                    raise LoadError(loaded.problems)
                self._read[same] = loaded
            except LoadError as error:
                references.tell(error, file, references.MISSION, at, self.problems)
            except UsageError as error:
                self.problems.add("campaign.mission", at, str(error))
        return self._read[same]

    def _check_settings(self, choices: Choices, loaded: LoadedMission) -> None:
        """Report parameters that the mission does not have, or that cannot take their values."""
        settings = choices.of("set") or {}
        mission = loaded.mission
        for name, values in settings.items():
            at = (*choices.place("set"), name)
            definition = mission.parameters.get(name)
            if definition is None:
                message = f"the mission {mission.mission} has no parameter '{name}'"
                self.problems.add_unknown(
                    "campaign.mission",
                    at,
                    "parameter",
                    name,
                    mission.parameters,
                    message=message,
                    none="no parameters",
                    key=True,
                )
                continue
            faulty = set()
            for place, text in texts(values):
                try:
                    read_value(definition, text)
                except QuantityError as error:
                    if place in faulty:
                        continue  # the next value of a range
                    faulty.add(place)
                    message = f"parameter '{name}': {error.message}"
                    self.problems.add(
                        "campaign.mission", (*at, *place), message, suggestion=error.suggestion
                    )
        for name, definition in mission.parameters.items():
            if definition.default is None and name not in settings:
                message = f"parameter '{name}' of {mission.mission} has no default"
                expected = f"`set: {{{name}: …}}`"
                self.problems.add("campaign.mission", choices.mission, message, expected=expected)

    def _check_states(self, choices: Choices, table: ChartTable) -> None:
        """Report states of the end that the robot does not have."""
        at = (*choices.place("end"), "states")
        for number, states in enumerate(choices.of("end").states if choices.of("end") else ()):
            if len(states) != len(table.regions):
                expected = f"one state of each of {', '.join(table.regions)}"
                verb = "is" if len(states) == 1 else "are"
                message = f"{len(states)} of the robot's {len(table.regions)} states {verb} given"
                self.problems.add("campaign.state", (*at, number), message, expected=expected)
                continue
            for place, (region, state) in enumerate(zip(table.regions, states, strict=True)):
                known = table.states[table.regions.index(region)]
                if state not in known:
                    message = f"{region} has no state '{state}'"
                    path = (*at, number, place)
                    self.problems.add_unknown(
                        "campaign.state", path, "state", state, known, message=message
                    )

    def _defects(self, choices: Choices, loaded: LoadedMission) -> Iterator[tuple[str, ...]]:
        """Yield each set of defects, of those that the robot can have."""
        profile, limit_s = loaded.loaded_robot.profile, loaded.program.time_limit_s
        known = profile.simulation.defects
        wanted: tuple[DefectSet, ...] = choices.of("defects") or ((),)
        for number, listed in enumerate(wanted):
            written = () if listed == (NONE,) else listed
            for place, text in enumerate(written):
                at = (*choices.place("defects"), number, place)
                if text in written[:place] and text.partition(":")[0] != EACH:
                    self.problems.add("campaign.defect", at, f"'{text}' is here twice")
                for one in _each(text, known):
                    if not check_defect(one, profile, "campaign.defect", at, self.problems):
                        break
                    (defect, _), *_ = named([one], profile, seed=0)
                    if ".." not in one and defect.after > limit_s:
                        message = (
                            f"it begins after {defect.after:g} s, and {loaded.mission.mission}"
                        )
                        message += f" has ended by {limit_s:g} s"
                        warning = Severity.WARNING
                        self.problems.add("campaign.defect", at, message, severity=warning)
            sets: dict[frozenset[str], tuple[str, ...]] = {}
            for together in product(*(_each(text, known) for text in written)):
                if len(set(together)) == len(together):
                    sets.setdefault(frozenset(together), together)
            yield from sets.values()


def _each(text: str, known: Iterable[str]) -> list[str]:
    """Return what a defect of a campaign stands for: every known one, or itself."""
    name, colon, numbers = text.partition(":")
    return [f"{one}{colon}{numbers}" for one in known] if name == EACH else [text]


def check_defect(text: str, profile: Profile, code: str, at: Keys, problems: Problems) -> bool:
    """Report a defect that the robot does not have, or whose numbers do not fit; return if none."""
    name, known = text.partition(":")[0], profile.simulation.defects
    if name not in known:
        problems.add_unknown(code, at, "defect", name, known)
        return False
    try:
        named([text], profile, seed=0)
    except UsageError as error:
        problems.add(code, at, str(error))
        return False
    return True


def _listed(choices: Choices, key: str) -> Iterator[tuple[str, Keys]]:
    """Yield the names of a choice, each with its keys in the file."""
    for number, name in enumerate(choices.of(key) or ()):
        yield name, (*choices.place(key), number)


def from_here(path: Path) -> str:
    """Return the path, relative to the working directory where it is below that."""
    relative = os.path.relpath(path)
    return relative if not relative.startswith("..") else str(resolved(path))
