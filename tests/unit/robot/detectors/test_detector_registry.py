from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest

from pirate_sm.core._engine.robot.robot_spec import WordCondition
from pirate_sm.core.errors import UsageError
from pirate_sm.core.expressions import compile_condition
from pirate_sm.robot.detectors.odometry_detector import Odometry
from pirate_sm.robot.detectors.registry import (
    Asked,
    Detecting,
    Places,
    _guards,
    counts,
    detecting,
    speaks_of_bends,
)
from pirate_sm.robot.detectors.simple_detectors import SignalWords, TruePlaces
from pirate_sm.robot.detectors.socket_detector import AcceptedLines, Address, OutsideWords
from pirate_sm.running.wiring import Order, load


def choose(
    text: str | None,
    usual: str = "sim",
    *,
    piped: bool = True,
    **rest: Any,
):
    loaded = load(Order("mitre_bend"))
    robot, pipe = rest.pop("robot", loaded.robot), loaded.pipe if piped else None
    profile = rest.pop("profile", loaded.loaded_robot.profile)
    return detecting(text, usual, Asked(profile, robot, pipe, **rest))


def test_what_is_usual_needs_no_word() -> None:
    chosen = choose(None, places=Places((0.5,), lambda: (0.1, 0.2)))
    assert (chosen.kind, chosen.notices) == ("sim", ())
    assert isinstance(chosen.companions[0], TruePlaces)
    assert choose(None, "odometry").kind == "odometry"
    nowhere = Detecting("none", notices=("detector: none, the mission names no pipe",))
    assert choose(None, "odometry", piped=False) == nowhere


@pytest.mark.parametrize(
    ("text", "kind", "companion"),
    [("odometry", "odometry", Odometry), ("socket:127.0.0.1:5005", "socket", OutsideWords)],
)
def test_a_detector_stands_beside_the_mission(text: str, kind: str, companion: type) -> None:
    chosen = choose(text)
    assert chosen.kind == kind
    assert isinstance(chosen.companions[0], companion)
    assert chosen.notices


def test_a_person_is_told_the_keys() -> None:
    assert choose("operator") == (
        "operator",
        (),
        ("detector: the keys [a] close  [b] in  [c] past",),
        None,
        None,
    )


def test_the_place_is_reported() -> None:
    chosen = choose("odometry", first_wheel_m=0.7125)
    assert "712.5 mm" in chosen.notices[0]


@pytest.mark.parametrize(
    ("text", "options", "why"),
    [
        ("signals", {}, "no word of pirate_ii has a condition; give one"),
        ("sim:", {}, "detector sim:: sim takes no argument"),
        ("operator:a", {}, "detector operator:a: operator takes no argument"),
        ("odometri", {}, "did you mean 'odometry'"),
        ("radar", {}, "expected one of odometry, operator, signals, sim, socket"),
        ("odometry:3", {}, "takes no argument"),
        ("sim", {}, "only the backend sim knows"),
        ("odometry", {"piped": False}, "needs to know the pipe"),
        ("operator", {"first_wheel_m": 0.7}, "only the detectors odometry and vision"),
        (None, {"first_wheel_m": 0.7}, "only the detectors odometry and vision"),
    ],
)
def test_a_wish_that_cannot_be_met_is_refused(text, options, why) -> None:
    with pytest.raises(UsageError, match=why):
        choose(text, **options)


def test_who_names_no_pipe_is_told_how_in_either_language() -> None:
    with pytest.raises(UsageError) as raised:
        choose("odometry", piped=False)
    assert raised.value.for_terminal.endswith("to know the pipe: give it with --pipe")
    assert str(raised.value).endswith("to know the pipe: give it with pipe='NAME'")
    with pytest.raises(UsageError) as raised:
        choose("operator", first_wheel_m=0.7)
    assert "count: --start-at goes with --detector" in raised.value.for_terminal
    assert "count: start_at_m goes with detector=" in str(raised.value)


@pytest.mark.parametrize("name", ["sim", "odometry"])
def test_words_without_points_leave_no_detector_to_where_nobody_has_chosen_one(name: str) -> None:
    whole = load(Order("mitre_bend")).loaded_robot.profile
    wordless = whole.detector.model_copy(update={"words": {}})
    options = {
        "profile": whole.model_copy(update={"detector": wordless}),
        "places": Places((), lambda: ()),
    }
    why = "no word of the profile has points, `forward` and `backward`"

    assert choose(None, name, **options) == Detecting("none", (), (f"detector: none, {why}",))
    with pytest.raises(UsageError, match=f"^the detector {name}: {why}$"):
        choose(name, **options)


def test_conditions_on_signals_say_words_and_a_socket_may_let_numbers_in() -> None:
    loaded = load(Order("mitre_bend"))
    when = compile_condition("gamma_1 > 10 deg", loaded.robot.vocabulary)
    robot = replace(loaded.robot, word_conditions=(WordCondition("close", when, 0.0),))
    notices = (
        "detector: conditions on signals say close",
        "detector: nothing says in, past, without a condition",
    )

    alone = choose("signals", robot=robot)
    assert (alone.kind, alone.notices) == ("signals", notices)
    (words,) = alone.companions
    assert isinstance(words, SignalWords)
    assert (words._robot, words._repeater.valid_for_s) == (robot, 1.0)

    numbers = choose("signals:/tmp/numbers", robot=robot)
    asked = "numbers from programs that write to /tmp/numbers"
    assert (numbers.kind, numbers.notices) == ("signals", (*notices, asked))
    door, words = numbers.companions
    assert isinstance(words, SignalWords)
    assert isinstance(door, OutsideWords)
    outside = loaded.loaded_robot.profile.outside
    valid_for_s = {name: signal.valid_for for name, signal in outside.items()}
    assert door._accepted == AcceptedLines((), signals=valid_for_s)

    every = tuple(WordCondition(word, when, 0.0) for word in robot.detector_words)
    said = choose("signals", robot=replace(robot, word_conditions=every)).notices
    assert said == ("detector: conditions on signals say close, in, past",)


@pytest.mark.parametrize(
    ("text", "address", "given", "shown"),
    [
        (
            "socket",
            Address(path="/run/user/pirate_sm.detector"),
            "",
            "/run/user/pirate_sm.detector",
        ),
        ("socket:/tmp/words", Address(path="/tmp/words"), "abc", "/tmp/words"),
        (
            "socket:127.0.0.1:5005",
            Address("127.0.0.1", 5005),
            "abc",
            "127.0.0.1:5005, first a line with the token in PIRATE_SM_TOKEN",
        ),
        ("socket:[::1]:80", Address("::1", 80), "", "[::1]:80, first a line "),
    ],
)
def test_programs_are_shown_where_they_write_and_their_token(
    text: str, address: Address, given: str, shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PIRATE_SM_TOKEN", given)
    monkeypatch.setenv("XDG_RUNTIME_DIR", "/run/user")
    chosen = choose(text)
    (door,) = chosen.companions
    assert isinstance(door, OutsideWords)
    profile = load(Order("mitre_bend")).loaded_robot.profile
    valid_for_s = {name: signal.valid_for for name, signal in profile.outside.items()}
    assert door._accepted == AcceptedLines(("close", "in", "past"), 1.0, valid_for_s)
    assert door.address == address
    token = "" if address.path else door._listener._token
    if not (address.path or given):
        assert len(token) >= 16
        shown += json.dumps({"token": token})
    assert chosen.notices == (f"detector: programs that write to {shown}",)
    assert door._listener._token == (token if not given or address.path else given)


@pytest.mark.parametrize(
    ("text", "bends", "begins"),
    [
        (None, True, False),
        ("sim", True, False),
        ("odometry", True, True),
        ("vision:top", True, True),
        ("operator", False, False),
        ("signals:/tmp/numbers", False, False),
        ("socket:/tmp/words", False, False),
    ],
)
def test_which_detectors_say_where_a_bend_is_and_count_from_a_place(
    text: str | None, bends: bool, begins: bool
) -> None:
    assert speaks_of_bends(text) is bends
    assert text is None or counts(text) is begins


def test_a_detector_of_another_package_without_a_place_or_camera_has_none() -> None:
    made = _guards("the detector 'marks'", Detecting("marks"))

    assert made == Detecting("marks")


def test_a_token_that_no_line_can_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PIRATE_SM_TOKEN", "a\udcff")
    with pytest.raises(UsageError, match="PIRATE_SM_TOKEN holds bytes that are not UTF-8 text"):
        choose("socket:127.0.0.1:5005")


def test_a_robot_without_an_odometer_cannot_reckon() -> None:
    robot = replace(load(Order("mitre_bend")).robot, odometry=-1)
    with pytest.raises(UsageError, match="odometry_of"):
        choose("odometry", robot=robot)
