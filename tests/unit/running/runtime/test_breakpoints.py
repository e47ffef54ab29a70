"""Breakpoints in words: phases, ends and lines, and what is said of those that cannot be met."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import load_mission
from pirate_sm.core.program import Enter
from pirate_sm.running.runtime.breakpoints import breakables, breakpoints

ROOT = Path(__file__).parents[4]
BEND = load_mission(ROOT / "sequences" / "mitre_bend.yaml")
OWN = BEND.documents[0].name


def line_of(text: str, document: int = 0) -> int:
    """The line of a file of the mission that begins so."""
    lines = [each.strip() for each in BEND.documents[document].lines]
    return 1 + next(at for at, each in enumerate(lines) if each.startswith(text))


def test_a_phase_is_where_it_begins():
    (place,) = breakpoints(BEND, ["close"])

    phases = {it.place: it.phase for it in BEND.program.instructions if isinstance(it, Enter)}
    assert phases[place] == "close"


@pytest.mark.parametrize("name", ["prepare/prepare_bend.bend", "passed", "close"])
def test_ends_and_phases_of_called_missions_have_names_too(name):
    if name == "passed":
        name = next(iter(BEND.mission.ends))
    assert len(breakpoints(BEND, [name])) == 1


def test_the_line_of_a_phase_and_its_name_are_one():
    assert breakpoints(BEND, [str(line_of("close:"))]) == breakpoints(BEND, ["close"])


def test_a_line_of_a_called_mission_is_named_with_its_file():
    called = next(each for each in BEND.documents if each.name.endswith("pass_bend.yaml"))
    at = breakables(BEND)[-1]
    assert at.place.file == called.name

    short, whole = (f"{name}:{at.line}" for name in ("pass_bend.yaml", called.name))

    assert breakpoints(BEND, [short]) == breakpoints(BEND, [whole]) == (str(at.place),)


def test_the_same_place_counts_once_and_spaces_do_not():
    assert len(breakpoints(BEND, ["close", " close ", str(line_of("close:"))])) == 1


def test_each_line_has_one_place_which_is_its_first():
    found = breakables(BEND)
    lines = [(each.place.file, each.place.line) for each in found]

    assert len(set(lines)) == len(lines)
    assert all(
        str(each.place) in breakpoints(BEND, [f"{each.place.file}:{each.line}"]) for each in found
    )


def test_all_that_cannot_be_met_is_named_with_what_was_probably_meant():
    comment = line_of("mission:")

    with pytest.raises(UsageError) as refused:
        breakpoints(
            BEND, ["clos", str(comment), "99999", "pas_bend.yaml:3", "0", "3:x"], "--break "
        )

    lines = str(refused.value).splitlines()
    assert [each.split(": ")[0] for each in lines] == [
        *("--break clos", f"--break {comment}", "--break 99999"),
        *("--break pas_bend.yaml:3", "--break 0", "--break 3:x"),
    ]
    assert "did you mean 'close'?" in lines[0]
    assert (
        f"nothing begins in line {comment} of {OWN}; the nearest line that has one is" in lines[1]
    )
    assert "pass_bend.yaml" in lines[3]


@pytest.mark.parametrize(
    "text", ["", ":", "-3", "²", "close:close", "٣", "1e3", "\x1b[1m", "9" * 5000]
)
def test_odd_texts_are_refused_in_a_sentence(text):
    with pytest.raises(UsageError):
        breakpoints(BEND, [text])
