"""What a failed command has awaited, in words."""

from math import inf, nan, radians

import pytest

from pirate_sm.core._model.unmet import Unmet, advice, unmet_words

BENT = Unmet("theta_2", "rad", radians(20), radians(28), False, radians(12), 0.02, radians(3))
SILENT = BENT._replace(value=nan, age_s=1.2, change=nan, unknown="silent", board="board 3 (front)")


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {},
            "theta_2 should be between 20 and 28 deg,"
            " shows 12 deg (20 ms old) and has changed by 3 deg",
        ),
        ({"change": 0.0}, "shows 12 deg (20 ms old) and has not changed"),
        ({"change": nan}, "shows 12 deg (20 ms old) and was unknown before"),
        ({"age_s": nan}, "shows 12 deg and has changed by 3 deg"),
        ({"least": -inf}, "theta_2 should be at most 28 deg"),
        ({"most": inf}, "theta_2 should be at least 20 deg"),
        ({"least": -radians(28)}, "theta_2 should be within 28 deg of zero"),
        ({"most": inf, "magnitude": True}, "at least 20 deg in either direction"),
        ({"unit": "", "least": 0.5, "most": inf}, "should be at least 0.5,"),
    ],
)
def test_it_says_what_was_awaited_and_what_is_shown(changes, expected):
    assert expected in unmet_words([BENT._replace(**changes)])


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, "has had no value for 1.2 s"),
        ({"age_s": inf}, "has never had a value"),
        ({"unknown": "implausible"}, "has no value that can be true"),
        ({"unknown": "missing"}, "has no value"),
    ],
)
def test_an_unknown_value_is_said_with_its_cause(changes, expected):
    assert unmet_words([SILENT._replace(**changes)]).endswith(expected)


def test_the_advice_follows_from_what_is_seen():
    resting = BENT._replace(change=radians(0.1))
    away = BENT._replace(change=radians(-3))

    assert advice([BENT, SILENT], "Bend") == (
        "check the sensor of theta_2 and the cable of board 3 (front), then repeat Bend"
    )
    assert advice([resting], "Bend").startswith("see why theta_2 did not come nearer")
    assert advice([away], "Bend").startswith("see why theta_2 did not come nearer")
    assert advice([BENT], "Bend") == (
        "see what stops theta_2, or give Bend more time, then repeat it"
    )
    assert advice([], "Bend") == ""


def test_a_joint_that_still_moves_is_not_blocked():
    moving = Unmet("rate_2", "rad/s", -0.07, 0.07, False, -0.6, 0.02, -0.6)
    slow = Unmet("wheel_3_speed", "rad/s", 0.5, inf, False, 0.0, 0.02, 0.0)

    assert advice([BENT._replace(change=0.0), moving], "Bend") == (
        "it still moves (rate_2): give Bend more time, or see what moves it"
    )
    assert advice([slow], "Bend").startswith("see why wheel_3_speed did not come nearer")
