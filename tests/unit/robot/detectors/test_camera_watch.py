"""When the pictures of a camera are not believed, and what is said of it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pirate_sm.core.events import SeenMark, Sighting
from pirate_sm.robot.detectors.vision_detector import CameraWatch

GOOD = Sighting(0.0, (SeenMark("head", (0.0, 0.0), 0.0),), 0.5, 100.0, 0)
"""The robot and the tags of the setup are seen; each picture differs from the last one."""


def watched(
    *changes: tuple[float, dict[str, object] | None], why: str = "", driven: bool = True
) -> list[str]:
    """Return the faults of a camera that is good until 10 s, then so changed; None: no picture."""
    watch, found = CameraWatch(2.0), []
    for digest, (now_s, changed) in enumerate(((8.0, {}), (10.0, {}), *changes)):
        if changed is not None:
            watch.take(replace(GOOD, **{"digest": digest} | changed), now_s)
        for fault in watch.look(now_s, why, driven=driven):
            found.append(f"{now_s:g} {fault.code}{''.join(fault.message.partition(':')[1:])}")
    return found


FROZEN, DARK = {"digest": 1}, {"gray_spread": 7.9}
MOVED, BLIND = {"rms_px": 3.06}, {"marks": ()}
ROBOT_GONE = [(10.0 + 0.4 * turn, BLIND) for turn in range(1, 7)]
SPREAD = "vision.dark: dark and bright differ by 8 of 255"


@pytest.mark.parametrize(
    ("changes", "faults"),
    [
        ([(10.4, {}), (10.8, {}), (11.2, {}), (11.6, {})], []),
        ([(10.49, None)], []),
        ([(10.5, None), (10.6, None), (10.7, {}), (11.2, None)], [
            "10.5 vision.silent", "11.2 vision.silent",
        ]),
        ([(10.4, FROZEN), (10.8, FROZEN), (10.99, FROZEN)], []),
        ([(10.4, FROZEN), (10.8, FROZEN), (11.0, FROZEN)], ["11 vision.frozen"]),
        ([(10.4, {"gray_spread": 8.0})], []),
        ([(10.4, DARK), (10.8, DARK), (10.9, {}), (11.0, DARK)], [
            f"10.4 {SPREAD}", f"11 {SPREAD}",
        ]),
        ([(10.4, DARK), (10.9, None)], [f"10.4 {SPREAD}", "10.9 vision.silent"]),
        ([(10.4, MOVED), (10.8, MOVED), (10.99, MOVED)], []),
        ([(10.4, MOVED), (10.8, MOVED), (11.0, MOVED)], [
            "11 vision.moved: the setup's tags are 3.1 px off; survey it again",
        ]),
        ([(10.4, MOVED), (10.8, {"rms_px": None}), (11.2, MOVED)], []),
        ([(10.4, MOVED), (10.8, {"rms_px": 3.0}), (11.2, MOVED)], []),
        (ROBOT_GONE[:4], []),
        (ROBOT_GONE, ["12 vision.blind"]),
    ],
)  # fmt: skip
def test_a_fault_begins_after_its_time_and_is_reported_once(changes, faults) -> None:
    assert watched(*changes) == faults


def test_a_camera_that_says_why_it_is_silent_is_quoted() -> None:
    assert watched((10.5, None), why="unplugged") == ["10.5 vision.silent: unplugged"]
    assert watched((10.4, DARK), why="unplugged") == [f"10.4 {SPREAD}"]


def test_a_robot_that_stands_may_be_out_of_sight() -> None:
    assert watched(*ROBOT_GONE, driven=False) == []


@pytest.mark.parametrize(
    ("rms_px", "blind_after_s", "code"), [(9.0, 5.0, "vision.moved"), (0.5, 1.0, "vision.blind")]
)
def test_a_camera_that_has_never_shown_its_setup_or_the_robot_is_wrong_from_the_beginning_on(
    rms_px: float, blind_after_s: float, code: str
) -> None:
    watch, found = CameraWatch(blind_after_s), []
    for digest, now_s in enumerate((0.4, 0.8, 0.99, 1.0)):
        watch.take(Sighting(now_s, (), rms_px, 100.0, digest), now_s)
        found.append([fault.code for fault in watch.look(now_s, "", driven=True)])

    assert found == [[], [], [], [code]]


def test_a_camera_that_has_never_given_a_picture_is_silent_after_its_time() -> None:
    watch = CameraWatch(5.0)

    assert watch.look(0.49, "", driven=False) == []
    assert [fault.code for fault in watch.look(0.5, "", driven=False)] == ["vision.silent"]
