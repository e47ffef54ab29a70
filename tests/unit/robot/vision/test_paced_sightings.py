"""Videos and synthetic cameras run in mission time, whatever this computer does."""

from __future__ import annotations

from math import inf
from pathlib import Path

import numpy as np
import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.camera import FileSource, ImagesSource
from pirate_sm.robot.vision.opencv import cv2
from pirate_sm.robot.vision.sightings import SyntheticSightings, open_sightings

from .small_setup import SIZE, camera, drawn, scene


def captured(found) -> list[float]:
    return [round(seen.sighting.captured_s, 6) for seen in found]


def test_a_recorded_picture_arrives_when_its_time_and_latency_have_passed(tmp_path: Path) -> None:
    _, pictures = drawn()
    for number in range(3):
        cv2.imwrite(str(tmp_path / f"{number}.png"), pictures.picture(scene(), number))
    known = camera().model_copy(
        update={"source": ImagesSource(images="*.png", size=SIZE, rate=10.0), "latency_s": 0.25}
    )
    sightings = open_sightings(known, tmp_path)

    assert sightings.due_s == pytest.approx(0.25)
    assert sightings.look(0.2) == []
    assert captured(sightings.look(0.25)) == [0.0]
    assert sightings.due_s == pytest.approx(0.35)
    assert captured(sightings.look(1.0)) == [0.1, 0.2]
    assert (sightings.due_s, sightings.fault) == (inf, "the video is over")
    assert sightings.look(2.0) == []
    sightings.close()


def test_a_picture_of_another_size_ends_the_sightings_with_the_reason(tmp_path: Path) -> None:
    _, pictures = drawn()
    cv2.imwrite(str(tmp_path / "0.png"), pictures.picture(scene(), 0))
    cv2.imwrite(str(tmp_path / "1.png"), np.zeros((48, 64, 3), np.uint8))
    known = camera().model_copy(
        update={"source": ImagesSource(images="*.png", size=SIZE, rate=10.0), "latency_s": 0.0}
    )
    sightings = open_sightings(known, tmp_path)

    assert captured(sightings.look(1.0)) == [0.0]
    assert "'1.png' has 64 × 48 pixels" in sightings.fault
    assert sightings.due_s == inf


def synthetic(
    latency_s: float = 0.1, rate: float = 10.0, seed: int = 0, **looks
) -> SyntheticSightings:
    known = camera(**looks)
    known = known.model_copy(
        update={
            "source": known.source.model_copy(update={"rate": rate}),
            "latency_s": latency_s,
        }
    )
    sightings = open_sightings(known, Path(), scene, seed)
    assert isinstance(sightings, SyntheticSightings)
    return sightings


def run(sightings: SyntheticSightings, until_s: float) -> list[tuple[float, float]]:
    """When each sighting came, and of when it is."""
    came, now_s = [], 0.0
    while now_s <= until_s + 1e-9:
        came += [(round(now_s, 6), at) for at in captured(sightings.look(now_s))]
        assert sightings.due_s > now_s
        now_s = sightings.due_s
    return came


def test_a_synthetic_picture_shows_the_robot_as_it_was_and_arrives_late() -> None:
    assert run(synthetic(latency_s=0.15), 0.45) == [
        (0.15, 0.0), (0.25, 0.1), (0.35, 0.2), (0.45, 0.3),
    ]  # fmt: skip


def test_the_robot_is_where_it_was_when_the_picture_was_taken() -> None:
    places = iter([0.0, 0.02, 0.04, 0.06])
    known = camera()
    known = known.model_copy(
        update={"source": known.source.model_copy(update={"rate": 10.0}), "latency_s": 0.05}
    )
    moving = open_sightings(known, Path(), lambda: scene(x=next(places)))
    assert moving.look(0.0) == []
    (first,) = moving.look(0.05)
    assert moving.look(0.1) == []
    (second,) = moving.look(0.15)

    x = [seen.sighting.marks[0].place_m[0] for seen in (first, second)]
    # The second is smeared over the 10 ms of the shutter: 2 mm, of which it shows the middle.
    assert x == pytest.approx([-0.045, -0.026], abs=1.5e-3)


def test_the_same_seed_gives_the_same_sightings_and_another_one_others() -> None:
    def digests(seed: int) -> list[int]:
        sightings = synthetic(latency_s=0.0, seed=seed)
        return [sightings.look(t)[0].sighting.digest for t in (0.0, 0.1)]

    assert digests(1) == digests(1)
    assert digests(1) != digests(2)


def test_lost_pictures_never_arrive() -> None:
    sightings = synthetic(latency_s=0.0, camera={"lost": 0.5})
    found = [len(sightings.look(number / 10)) for number in range(20)]

    assert 4 < sum(found) < 16


def test_a_synthetic_camera_needs_a_simulated_robot() -> None:
    with pytest.raises(UsageError, match="it sees a simulated robot only"):
        open_sightings(camera(), Path())


def test_a_small_jpeg_of_the_picture_is_for_recordings() -> None:
    (seen,) = synthetic(latency_s=0.0).look(0.0)
    small = cv2.imdecode(np.frombuffer(seen.jpeg(320), np.uint8), cv2.IMREAD_COLOR)

    assert small.shape == (240, 320, 3)
    assert len(seen.jpeg(320)) < 16_000


@pytest.mark.parametrize(("name", "codec"), [("seen.avi", "MJPG"), ("seen.mp4", "mp4v")])
def test_a_compressed_video_shows_what_the_camera_saw(
    tmp_path: Path, name: str, codec: str
) -> None:
    eye, pictures = drawn()
    video = cv2.VideoWriter(str(tmp_path / name), cv2.VideoWriter_fourcc(*codec), 10.0, SIZE)
    frames = [pictures.picture(scene(x=0.02 * number), number) for number in range(4)]
    for frame in frames:
        video.write(frame)
    video.release()
    known = camera().model_copy(update={"source": FileSource(file=name, size=SIZE, rate=10.0)})

    found = open_sightings(known, tmp_path).look(1.0)

    assert captured(found) == [0.0, 0.1, 0.2, 0.3]
    for seen, frame in zip(found, frames, strict=True):
        live = eye.see(frame, 0.0).marks
        assert [mark.on for mark in seen.sighting.marks] == [mark.on for mark in live]
        for ours, theirs in zip(seen.sighting.marks, live, strict=True):
            assert ours.place_m == pytest.approx(theirs.place_m, abs=1e-3)
