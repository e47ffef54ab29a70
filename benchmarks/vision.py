"""A synthetic camera over the simulated bend: how well the robot is seen, and how quickly.

    python -m benchmarks.vision [see] [finders] [speed] [calibrate] [--frames 200]

see: the robot passes the bend of `mitre_bend` in the simulator. At moments spread over the whole
run, a picture is drawn of it in one of five lights, with noise, blur and JPEG, and searched. The
errors are those of the places of the wheels (of tags: both ends of each link that is seen) or of
the marker. False is what is reported more than 25 mm from its place.

finders: colours of a marker (vivid: limits of saturation that leave less room) and three finders,
each in the same lights. False is here
whatever is found beside the marker, before the best is chosen.

speed: CPU time of one core for a picture of 1080p. calibrate: a lens from 20 drawn chessboards.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import cycle
from math import cos, dist, sin

import numpy as np

from benchmarks.vision_boards import calibrates
from pirate_sm.core import library
from pirate_sm.core.companion import Companion
from pirate_sm.core.events import Sighting
from pirate_sm.core.geometry import Route
from pirate_sm.robot.camera import Camera, Lighting, MarkedRobot, SyntheticSource
from pirate_sm.robot.camera_file import load_camera
from pirate_sm.robot.vision.seeing import Eye, MarkerFinder, eye_of
from pirate_sm.robot.vision.synthetic import ShownScene, SyntheticPictures, scene_in_pipe
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, load, prepare

MISSION = "mitre_bend"
CAMERAS = ("synthetic", "synthetic_marker", "setup_2")
FALSE_M = 0.025
SAMPLE_EVERY_S = 0.05
LIGHTS = {
    "neutral": Lighting(),
    "dim": Lighting(gain=0.3),
    "warm": Lighting(lamp="warm"),
    "cold": Lighting(lamp="cold", uneven=0.5),
    "lamps": Lighting(glare=True, uneven=0.4),
}
COLOURS = {
    "orange": ((5, 90, 40), (15, 255, 255)),
    "orange, vivid": ((5, 140, 90), (15, 255, 255)),
    "green": ((45, 90, 40), (80, 255, 255)),
    "blue": ((100, 90, 40), (125, 255, 255)),
    "blue, vivid": ((100, 130, 40), (125, 255, 255)),
    "magenta": ((140, 90, 40), (170, 255, 255)),
}
FINDERS = ("components", "blob", "hough")
ALL = "all"
LIMITS_MS = {"tags": 25.0, "components": 12.0, "window": 1.0}


class Watch:
    """A companion that notes where the wheels are."""

    listening = False

    def __init__(self, wheels: Callable[[], Sequence[tuple[float, float]]]) -> None:
        self.due_s = 0.0
        self.seen: list[tuple[tuple[float, float], ...]] = []
        self._wheels = wheels

    def react(self, effects: object, now_s: float) -> None:
        """Do nothing."""

    def speak(self, now_s: float) -> tuple[()]:
        """Note where the wheels are now."""
        self.due_s = now_s + SAMPLE_EVERY_S
        self.seen.append(tuple(self._wheels()))
        return ()


def scenes() -> list[ShownScene]:
    """The robot on its way through the bend, every 50 ms."""
    order = Order(MISSION)
    loaded = load(order)
    prepared = prepare(order, loaded)
    assert prepared.wheels is not None
    assert loaded.pipe is not None
    watch = Watch(prepared.wheels)
    companions: tuple[Companion, ...] = (*prepared.companions, watch)
    MissionRun(prepared.engine, prepared.backend, companions=companions).execute()
    body, route = loaded.loaded_robot.profile.body, Route(loaded.pipe.network())
    return [scene_in_pipe(wheels, body, route) for wheels in watch.seen]


@dataclass
class Score:
    """How well one camera saw in one light.

    Attributes:
        errors_m: Errors of places.
        missed: How many tags or markers were not found.
        expected: Out of how many.
        false: How many were reported where they are not.
        see_s: Time of each search.
    """

    errors_m: list[float] = field(default_factory=list)
    missed: int = 0
    expected: int = 0
    false: int = 0
    see_s: list[float] = field(default_factory=list)

    def take(self, sighting: Sighting, scene: ShownScene, expected: set[str]) -> None:
        """Judge a sighting by the truth."""
        links = {link.module: link for link in scene.links}
        self.expected += len(expected)
        self.missed += len(expected - {mark.on for mark in sighting.marks})
        for mark in sighting.marks:
            link = links[mark.on]
            if dist(mark.place_m, link.middle) > FALSE_M:
                self.false += 1
            elif mark.heading_rad is None:
                self.errors_m.append(dist(mark.place_m, link.middle))
            else:
                half_m = dist(link.front, link.rear) / 2
                (x, y), c, s = mark.place_m, cos(mark.heading_rad), sin(mark.heading_rad)
                self.errors_m.append(dist((x + half_m * c, y + half_m * s), link.front))
                self.errors_m.append(dist((x - half_m * c, y - half_m * s), link.rear))

    def line(self, name: str) -> str:
        """A row of the table."""
        if not self.errors_m:
            return f"{name:<30} found 0 of {self.expected}, {self.false} false"
        found = 100 * (self.expected - self.missed) / self.expected
        errors = 1000 * np.array(self.errors_m)
        return (
            f"{name:<30} found {found:5.1f} %  mean {errors.mean():4.1f}  "
            f"p95 {np.percentile(errors, 95):4.1f}  worst {errors.max():5.1f} mm  "
            f"{self.false} false  {1000 * np.median(self.see_s):5.1f} ms"
        )


def looked(camera: Camera, light: Lighting) -> tuple[Eye, SyntheticPictures]:
    """The eye of a camera, and what draws its pictures in a light."""
    eye, source = eye_of(camera), camera.source
    assert isinstance(source, SyntheticSource)
    looks = source.synthetic.model_copy(update={"light": light})
    return eye, SyntheticPictures(camera, eye.view, looks)


def judge(camera: Camera, shown: Sequence[ShownScene], lights: dict[str, Lighting]) -> bool:
    """Print how well a camera sees in each light; whether the bars are kept."""
    eyes = {name: looked(camera, light) for name, light in lights.items()}
    scores = {name: Score() for name in lights}
    for number, (scene, name) in enumerate(zip(shown, cycle(lights), strict=False)):
        eye, pictures = eyes[name]
        frame = pictures.picture(scene, number)
        began = time.thread_time()
        sighting = eye.see(frame, 0.0)
        scores[name].see_s.append(time.thread_time() - began)
        scores[name].take(sighting, scene, expected_of(eye, scene))
    whole = Score()
    for name, score in scores.items():
        print(score.line(f"{camera.camera}, {name}"))
        for each in ("errors_m", "see_s"):
            getattr(whole, each).extend(getattr(score, each))
        whole.missed += score.missed
        whole.expected += score.expected
        whole.false += score.false
    print(whole.line(f"{camera.camera}, all"))
    if not whole.errors_m or whole.false:
        return False
    return bool(np.percentile(whole.errors_m, 95) <= 4e-3)


def expected_of(eye: Eye, scene: ShownScene) -> set[str]:
    """The modules whose tags or markers are in the picture."""
    robot = eye.camera.robot
    wanted = set(robot.on.values()) if hasattr(robot, "on") else {robot.marker.on}
    width, height = eye.camera.source.size
    inside = set()
    for link in scene.links:
        u, v = eye.view.project(np.array([[*link.middle, 0.075]]))[0]
        if link.module in wanted and 0 <= u < width and 0 <= v < height:
            inside.add(link.module)
    return inside


def compare_finders(shown: Sequence[ShownScene]) -> bool:
    """Print how each finder sees a marker of each colour in the five lights."""
    camera, _ = load_camera(library.find_camera("synthetic_marker"))
    assert isinstance(camera.robot, MarkedRobot)
    for colour, hsv in COLOURS.items():
        for finder in FINDERS:
            marker = camera.robot.marker.model_copy(update={"hsv": hsv, "finder": finder})
            robot = camera.robot.model_copy(update={"marker": marker})
            _compare(f"{colour}, {finder}", camera.model_copy(update={"robot": robot}), shown)
    return True


def _compare(name: str, camera: Camera, shown: Sequence[ShownScene]) -> None:
    assert isinstance(camera.robot, MarkedRobot)
    found = {light: [0, 0] for light in LIGHTS}
    errors_m, beside, times_s = [], 0, []
    eyes = {light: looked(camera, looks) for light, looks in LIGHTS.items()}
    for number, (scene, light) in enumerate(zip(shown, cycle(LIGHTS), strict=False)):
        eye, pictures = eyes[light]
        finder = MarkerFinder(camera.robot.marker, eye.view, camera.source.size)
        finder.places(np.zeros((*camera.source.size[::-1], 3), np.uint8))  # maps are made once
        frame = pictures.picture(scene, number)
        began = time.thread_time()
        places = finder.places(frame)
        times_s.append(time.thread_time() - began)
        link = next(each for each in scene.links if each.module == camera.robot.marker.on)
        off_m = [dist(place, link.middle) for place in places]
        right = [each for each in off_m if each <= FALSE_M]
        errors_m += right[:1]
        found[light][0] += bool(right)
        found[light][1] += 1
        beside += len(off_m) - bool(right)
    lights = "  ".join(f"{n} {100 * a / max(b, 1):3.0f} %" for n, (a, b) in found.items())
    error = f"{1000 * float(np.mean(errors_m)):4.1f} mm" if errors_m else "      -"
    print(
        f"{name:<26} {lights}  {error}  {beside / len(shown):5.2f} beside it in a picture"
        f"  {1000 * float(np.median(times_s)):5.1f} ms"
    )


def measure_speed(shown: Sequence[ShownScene]) -> bool:
    """Print the CPU time for a picture of 1080p; whether the limits are kept."""
    times_ms: dict[str, list[float]] = {"draw": [], "tags": [], "components": [], "window": []}
    for name, way in (("synthetic", "tags"), ("synthetic_marker", "components")):
        camera, _ = load_camera(library.find_camera(name))
        eye, pictures = looked(camera, Lighting(glare=True))
        pictures.picture(shown[0], 0)  # the empty setup is drawn once
        for number, scene in enumerate(shown):
            began = time.thread_time()
            frame = pictures.picture(scene, number)
            times_ms["draw"].append(1000 * (time.thread_time() - began))
            began = time.thread_time()
            sighting = eye.see(frame, 0.0)
            times_ms[way].append(1000 * (time.thread_time() - began))
            if way == "components" and sighting.marks:
                began = time.thread_time()
                eye.see(frame, 0.0, sighting.marks[0].place_m)
                times_ms["window"].append(1000 * (time.thread_time() - began))
    good = True
    for name, each in times_ms.items():
        middle = float(np.median(each))
        limit = LIMITS_MS.get(name, np.inf)
        good &= middle <= limit
        said = f", at most {limit:g} wanted" if limit < np.inf else ""
        print(f"{name:<12} {middle:5.2f} ms (p95 {np.percentile(each, 95):5.2f}){said}")
    return good


def see(shown: Sequence[ShownScene]) -> bool:
    """Print how well each camera sees; whether the bars are kept."""
    good = True
    for name in CAMERAS:
        good &= judge(load_camera(library.find_camera(name))[0], shown, LIGHTS)
    return good


def main() -> int:
    """Whether all bars are kept."""
    works = {"see": see, "finders": compare_finders, "speed": measure_speed}
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    names = (*works, "calibrate")
    parser.add_argument("what", nargs="*", choices=(*names, ALL), default=ALL)
    parser.add_argument("--frames", type=int, default=200)
    wishes = parser.parse_args()
    what = names if ALL in wishes.what else wishes.what
    good = True
    if set(what) & works.keys():
        way = scenes()
        shown = [way[round(n)] for n in np.linspace(0, len(way) - 1, wishes.frames)]
        for name in (each for each in works if each in what):
            print(f"{name}:")
            good &= works[name](shown)
    if "calibrate" in what:
        print("calibrate:")
        good &= calibrates()
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
