"""What two runs were not alike in is named with both values."""

from __future__ import annotations

from dataclasses import replace

import pytest
from keeping import header

from pirate_sm.running.recording.compare import unlike


def test_runs_made_alike_have_nothing_to_tell():
    assert unlike(header(), header()) == ()
    assert unlike(header(), replace(header(), options={"seed": 5, "fidelity": "usual"})) == ()
    assert unlike(header(), replace(header(), began="2027-01-01T00:00:00+00:00")) == ()


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"seed": 6}, ("seed", "5", "6")),
        ({"seed": 5, "friction_jitter": 0.2}, ("friction jitter", "none", "0.2")),
        ({"seed": 5, "fidelity": "fast"}, ("fidelity", "usual", "fast")),
        ({"seed": 5, "defects": ["a", "b"]}, ("defects", "none", "a, b")),
        ({"seed": 5, "check": False}, ("check", "none", "no")),
        ({"seed": 5, "friction_jitter": 1 / 3}, ("friction jitter", "none", "0.333333")),
        ({}, ("seed", "5", "none")),
    ],
)
def test_an_option_that_differs_is_named(options, expected):
    (found,) = unlike(header(), replace(header(), options=options))

    assert tuple(found) == expected


def test_long_lists_of_the_same_length_differ_all_the_same():
    one, other = (
        replace(header(), options={"firings": [{"phase": phase}]}) for phase in ("go", "rest")
    )

    assert unlike(one, other) == (("firings", "1 given", "1 given"),)


def test_a_joint_zero_that_differs_is_named():
    one = replace(header(), zeros={"gamma_1": 0.1, "gamma_2": 0.2})

    (found,) = unlike(one, replace(one, zeros={"gamma_1": 0.1, "gamma_2": 0.25}))

    assert tuple(found) == ("zero of gamma_2", "0.2 rad", "0.25 rad")


def test_parameters_files_and_versions_are_named():
    one = header()
    changed = [replace(file, sha256="f" * 64) for file in one.files if file.role == "mission"]
    other = replace(
        one,
        parameters={**one.parameters, "give_up": "5 s"},
        files=(*changed, *(file for file in one.files if file.role != "mission")),
        version="9",
        detector="odometry",
    )

    found = {each.name: each for each in unlike(one, other)}

    assert list(found) == ["detector", "parameter give_up", "text of the mission", "version"]
    assert found["parameter give_up"].second == "5 s"
    assert "ffffffff" in found["text of the mission"].second
