from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from pirate_sm.detectors.odometry_detector import Odometry
from pirate_sm.detectors.registry import Asked, Places, detecting
from pirate_sm.detectors.socket_detector import OutsideWords
from pirate_sm.errors import UsageError
from pirate_sm.wiring import Order, load


def choose(
    text: str | None,
    usual: str = "sim",
    *,
    piped: bool = True,
    **rest: Any,
):
    loaded = load(Order("mitre_bend"))
    robot, pipe = rest.pop("robot", loaded.robot), loaded.pipe if piped else None
    asked = Asked(loaded.loaded_robot.profile, robot, pipe, **rest)
    return detecting(text, usual, asked)


def test_what_is_usual_needs_no_word() -> None:
    chosen = choose(None, places=Places((0.5,), lambda: (0.1, 0.2)))
    assert (chosen.kind, chosen.notices) == ("sim", ())
    assert choose(None, "odometry").kind == "odometry"
    assert choose(None, "odometry", piped=False).kind == "none"


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


def test_the_place_is_told() -> None:
    chosen = choose("odometry", first_wheel_m=0.7125)
    assert "712.5 mm" in chosen.notices[0]


@pytest.mark.parametrize(
    ("text", "options", "why"),
    [
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


def test_a_token_that_no_line_can_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PIRATE_SM_TOKEN", "a\udcff")
    with pytest.raises(UsageError, match="PIRATE_SM_TOKEN holds bytes that are not UTF-8 text"):
        choose("socket:127.0.0.1:5005")


def test_a_robot_without_an_odometer_cannot_reckon() -> None:
    robot = replace(load(Order("mitre_bend")).robot, odometry=-1)
    with pytest.raises(UsageError, match="odometry_of"):
        choose("odometry", robot=robot)
