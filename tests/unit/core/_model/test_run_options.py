"""The options of a run are declared once; what is written twice is compared here."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import get_args, get_type_hints

import pytest
from typer.main import get_command

import pirate_sm
from pirate_sm.cli.completion import candidates
from pirate_sm.cli.entry import _single
from pirate_sm.cli.options.common import values_of
from pirate_sm.core.errors import UsageError
from pirate_sm.core.options import JITTER, OPTIONS, GivenOptions, Options, written
from pirate_sm.core.units import LENGTH

NOT_IN_PYTHON = {"backend", "seed", "check", "calibration", "guard_for_s", "panel"}
"""The first three are arguments of their own; the others are for a person at the robot."""

GIVEN = GivenOptions(
    "m",
    backend="bay",
    settings={"way": "0.1 m"},
    states={"Front": "Held"},
    seed=3,
    defects=("late", "stiff:friction=0.5Nm"),
    fidelity="fast",
    view=True,
    guard_for_s=0.5,
    start_at_m=0.7,
    calibration=False,
    check=False,
    start_jitter_m=0.02,
    friction_jitter=0.2,
)


def test_python_has_the_keywords_that_are_declared() -> None:
    keywords = {"settings" if name == "set" else name for name in get_type_hints(Options)}

    assert keywords == set(OPTIONS) - NOT_IN_PYTHON


def test_keyword_arguments_have_the_types_of_the_options_they_set() -> None:
    holds, takes = get_type_hints(GivenOptions), get_type_hints(Options)
    plain = [name for name in takes if holds.get(name) in (float, bool, int | None, float | None)]

    assert len(plain) > 5
    assert {name: takes[name] for name in plain} == {name: holds[name] for name in plain}
    assert all(set(get_args(takes[name])) >= {str, type(None)} for name in ("robot", "twin"))


@pytest.mark.parametrize("option", [each for each in OPTIONS.values() if each.completes])
def test_a_shell_completes_what_an_option_says(option) -> None:
    assert callable(getattr(candidates, option.completes))


def test_the_words_that_repeat_a_run_are_read_as_its_options() -> None:
    command = get_command(_single("run"))

    with command.make_context("run", GIVEN.command()) as context:
        assert GivenOptions("m", **values_of(context.params)) == GIVEN


def test_numbers_are_written_with_their_unit() -> None:
    words = replace(GIVEN, diameter_jitter_m=0.0015).command()

    assert words[-6:] == [
        *("--jitter", "start=20mm"),
        *("--jitter", "friction=20%"),
        *("--jitter", "diameter=1.5mm"),
    ]
    assert [each.unit for each in JITTER] == [LENGTH, JITTER[1].unit, LENGTH]


def test_a_command_line_says_only_what_it_would_not_take_anyway() -> None:
    assert GivenOptions("m", check=True).command() == ["m"]
    assert GivenOptions("m").command() == ["m", "--no-check"]  # from Python


def test_a_number_without_an_end_is_written_as_it_is() -> None:
    assert written(math.inf, LENGTH) == "inf mm"


@pytest.mark.parametrize("name", [each.name for each in JITTER])
def test_backends_that_simulate_no_robot_refuse_how_far_it_may_differ(name: str) -> None:
    with pytest.raises(UsageError, match="the backend trace has no simulated robot"):
        pirate_sm.run("drive_on", "trace", **{name: 0.01})
