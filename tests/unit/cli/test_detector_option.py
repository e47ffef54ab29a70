from __future__ import annotations

import pytest

from pirate_sm.cli.people import SharedKeys


class Keyboard:
    keys = ""

    def pressed(self) -> str:
        keys, self.keys = self.keys, ""
        return keys


def test_a_keyboard_is_shared_between_words_and_answers() -> None:
    keyboard = Keyboard()
    shared = SharedKeys(keyboard, "abc")
    keyboard.keys = "1a\nB2"
    assert shared.answers.pressed() == "1\n2"
    keyboard.keys = "c"
    assert shared.words.pressed() == "aBc"
    assert shared.answers.pressed() == ""


def test_a_mission_runs_on_odometry_and_says_so(pirate_run) -> None:
    result = pirate_run("mitre_bend", "--detector", "odometry", "--start-at", "700mm")
    assert result.exit_code == 0, result.output
    assert "odometry, counted from the first wheel at 700 mm" in result.output


@pytest.mark.parametrize(
    ("options", "why"),
    [
        (("--detector", "radar"), "there is no detector 'radar'"),
        (("--detector", "operator"), "needs a terminal"),
        (("--detector", "socket:10.0.0.1:5005"), "could steer the robot"),
        (("--start-at", "700mm"), "--detector odometry"),
        (("--detector", "odometry", "--start-at", "70"), "expected a length"),
        (("--detector", "odometry", "--backend", "trace"), "has no robot that moves"),
    ],
)
def test_a_detector_that_cannot_be_had_moves_nothing(pirate_run, options, why) -> None:
    result = pirate_run("mitre_bend", *options)
    assert result.exit_code == 2
    assert why in result.output


def test_a_socket_that_cannot_be_had_moves_nothing(pirate_run, tmp_path) -> None:
    result = pirate_run("mitre_bend", "--detector", f"socket:{tmp_path}/none/words")
    assert result.exit_code == 2
    assert "No such file" in result.output
