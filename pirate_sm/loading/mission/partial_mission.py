"""Read a mission without its faulty phases."""

from __future__ import annotations

from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from pirate_sm.loading.yaml.document import Document
from pirate_sm.model.mission import Mission, Phase
from pirate_sm.model.quantities import FROM_FILE

_PHASE: Final = TypeAdapter(Phase)


def without_faulty_phases(document: Document) -> Mission | None:
    """Return the mission with its faulty phases emptied; None if there are other faults.

    This allows checking the names in all other phases. An emptied phase leads to itself.
    """
    data = document.data
    phases = data.get("phases") if isinstance(data, dict) else None
    if not isinstance(phases, dict):
        return None
    kept = {name: body if _is_phase(body) else {"go": name} for name, body in phases.items()}
    try:
        return Mission.model_validate({**data, "phases": kept}, **_LIKE_A_FILE)
    except ValidationError:
        return None


def _is_phase(body: Any) -> bool:
    try:
        _PHASE.validate_python(body, **_LIKE_A_FILE)
    except ValidationError:
        return False
    return True


_LIKE_A_FILE: Final[dict[str, Any]] = {
    "context": dict(FROM_FILE),
    "by_alias": True,
    "by_name": False,
}
