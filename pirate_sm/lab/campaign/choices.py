"""What holds for each mission of a campaign: its own choices, else the campaign's."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import ValidationError

from pirate_sm.core.campaign import Campaign, CampaignMission, RunChoices, Value, ValueRange, Values
from pirate_sm.core.documents import Path as Keys
from pirate_sm.core.options import OPTIONS
from pirate_sm.core.quantities import FROM_FILE
from pirate_sm.core.units import format_quantity
from pirate_sm.running.wiring import Order

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
    """Yield each value of a parameter as text, with the keys under which it stands."""
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
