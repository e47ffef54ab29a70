"""Each alphabet is closed by types: who adds a member is led by mypy to each place that needs it.

One scratch copy of the package gets one more member of each alphabet. The type checker must then
name every file that takes all of its members.
"""

from __future__ import annotations

import re
import shutil
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import pytest
from mypy import api

ROOT = Path(__file__).parents[1]


class Alphabet(NamedTuple):
    """A union of types.

    Attributes:
        file: The file that it stands in.
        last: A member as written there, that another one can follow; its last as a rule.
        added: Name and base class of the member that is added.
        places: Every file that must be changed for one more member.
    """

    file: str
    last: str
    added: str
    places: tuple[str, ...]


ALPHABETS = {
    "event": Alphabet(
        "core/_model/events.py", "(\n    Tick", "NewEvent(NamedTuple)", ("core/_engine/engine.py",)
    ),
    "request of a person": Alphabet(
        "core/_model/events.py",
        "    | Skip\n    | Abort",
        "NewRequest(NamedTuple)",
        ("core/_engine/inputs.py", "views/report/timeline.py"),
    ),
    "effect": Alphabet(
        "core/effects.py",
        "    | Ended",
        "NewEffect(NamedTuple)",
        ("core/effects.py",),
    ),
    "instruction": Alphabet(
        "core/_engine/mission/program.py",
        "Say | Raise | Finish",
        "NewInstruction(NamedTuple)",
        (
            "checking/mission_behaviour.py",
            "core/_engine/mission/interpreter.py",
            "core/_engine/mission/program.py",
            "core/branches.py",
            "running/runtime/breakpoints.py",
            "views/console/stepping.py",
        ),
    ),
    "step": Alphabet(
        "core/_model/mission.py",
        '| Annotated[WaitStep, Tag("wait")]',
        "NewStep(_AnyStep)",
        (
            "views/drawing/mission_words.py",
            "core/_loading/mission/program_writer.py",
            "core/_model/mission.py",
        ),
    ),
    "trigger": Alphabet(
        "core/_model/triggers.py",
        '| Annotated[OperatorTrigger, Tag("operator")]',
        "NewTrigger(Frozen)",
        (
            "checking/mission/mission_parameters.py",
            "views/drawing/graph/mission_graph.py",
            "views/drawing/mission_words.py",
            "views/interchange/scxml.py",
            "core/_loading/mission/program_writer.py",
            "core/_loading/mission/scope.py",
        ),
    ),
    "criterion": Alphabet(
        "core/_model/robot/done_criteria.py",
        "| Aligned | Below",
        "NewCriterion(DoneWhen)",
        ("core/_loading/robot/criteria.py",),
    ),
    "demand of a criterion": Alphabet(
        "core/_engine/robot/criteria.py",
        "| WheelTurning | AngleSet",
        "NewDemand(NamedTuple)",
        ("core/_engine/robot/criteria.py",),
    ),
    "way to see a state": Alphabet(
        "core/_model/robot/seen_states.py",
        "| Implied | Unknown",
        "NewSeenState(Frozen)",
        ("core/_loading/robot/criteria.py",),
    ),
    "setpoint": Alphabet(
        "core/_model/robot/actuation.py",
        '| Literal["keep"]',
        "NewSetpoint(NamedTuple)",
        ("core/_loading/robot/actuation.py", "core/_model/robot/actuation.py"),
    ),
    "loop": Alphabet(
        "core/_engine/robot/loops.py",
        "| RunningVelocityLoop",
        "NewLoop",
        (
            "core/_engine/robot/loops.py",
            "core/_engine/robot/setpoint_arrays.py",
        ),
    ),
    "origin of a fault": Alphabet(
        "core/_model/faults.py",
        'Literal["sensors", "link", "camera", "surroundings", "program"]',
        "NewOrigin(Enum)",
        ("checking/reports/text.py",),
    ),
}


def missed(scratch: Path) -> dict[str, set[str]]:
    """Return the files in which the type checker misses each new member."""
    package = scratch / "pirate_sm"
    shutil.copytree(ROOT / "pirate_sm", package, ignore=shutil.ignore_patterns("__pycache__"))
    for each in ALPHABETS.values():
        file = package / each.file
        text = file.read_text(encoding="utf-8")
        assert text.count(each.last) == 1
        before, after = text.split(each.last)
        before, line, union = before.rpartition("\n\n")
        file.write_text(
            f'{before}\nclass {each.added}:\n    """One more."""\n{line}{union}'
            f"{each.last} | {each.added.partition('(')[0]}{after}",
            encoding="utf-8",
        )
    # What other packages declare is known already where the types have been checked before.
    cache, before = scratch / "cache", ROOT / ".mypy_cache"
    if before.is_dir():
        shutil.copytree(before, cache)
    out, wrong, _ = api.run(
        [f"--config-file={ROOT / 'pyproject.toml'}", f"--cache-dir={cache}", str(package)]
    )
    assert not wrong
    found: dict[str, set[str]] = defaultdict(set)
    for line in out.splitlines():
        place, error, message = line.partition(": error: ")
        for member in re.findall(r"\bNew\w+", message if error else ""):
            file = Path(place.partition(":")[0])
            found[member].add(file.relative_to(package).as_posix())
    return found


@pytest.mark.thorough
def test_the_type_checker_names_every_place_that_a_new_member_needs(tmp_path: Path) -> None:
    found = missed(tmp_path)

    places = {name: sorted(found[each.added.partition("(")[0]]) for name, each in ALPHABETS.items()}
    assert places == {name: sorted(each.places) for name, each in ALPHABETS.items()}
