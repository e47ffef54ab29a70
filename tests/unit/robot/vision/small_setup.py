"""A small camera over a robot of three modules, for quick pictures."""

from __future__ import annotations

from typing import Any

from pirate_sm.robot.camera import Camera
from pirate_sm.robot.vision.seeing import Eye, eye_of
from pirate_sm.robot.vision.synthetic import ShownLink, ShownScene, SyntheticPictures

SIZE = (640, 480)
LENS = {
    "model": "fisheye",
    "f": (300.0, 301.0),
    "centre": (322.0, 238.0),
    "k": (-0.01, 0.002, 0, 0),
}
POSE = {"at": (0.02, 0.03, 0.3), "turn": (3.1, 0.15, 0.1)}
SETUP = {
    "tags": "aruco_4x4_50",
    "size": 0.03,
    "at": {
        "10": (-0.2, 0.15, 0.0),
        "11": (0.2, 0.15, 0.04),
        "12": (0.2, -0.13, 0.0),
        "13": (-0.2, -0.13, 0.04),
        "14": (0.0, 0.17, 0.04),
    },
    "pose": POSE,
}
TAGS = {"tags": "aruco_4x4_50", "size": 0.024, "height": 0.05, "on": {"0": "head", "1": "tail"}}
GREEN = {
    "marker": {
        "hsv": ((45, 90, 40), (80, 255, 255)),
        "size": 0.025,
        "height": 0.05,
        "on": "head",
    }
}


def camera(robot: dict[str, Any] | None = None, **looks: Any) -> Camera:
    return Camera.model_validate(
        {
            "format": 1,
            "camera": "small",
            "source": {"synthetic": looks, "size": SIZE, "rate": 30.0},
            "lens": LENS,
            "setup": SETUP,
            "robot": robot or TAGS,
        }
    )


def scene(x: float = 0.05, y: float = 0.02) -> ShownScene:
    """A robot that heads to x, and bends in its middle."""
    return ShownScene(
        links=(
            ShownLink("head", (x, y), (x - 0.09, y)),
            ShownLink("tail", (x - 0.09, y), (x - 0.15, y + 0.06)),
        ),
        walls=(((-0.3, 0.1), (0.3, 0.1)), ((-0.3, -0.05), (0.3, -0.05))),
        wheel_radius_m=0.024,
        half_thickness_m=0.012,
    )


def drawn(robot: dict[str, Any] | None = None, **looks: Any) -> tuple[Eye, SyntheticPictures]:
    """The eye of a small camera, and what draws its pictures."""
    seen_by = camera(robot, **looks)
    eye = eye_of(seen_by)
    return eye, SyntheticPictures(seen_by, eye.view, seen_by.source.synthetic)
