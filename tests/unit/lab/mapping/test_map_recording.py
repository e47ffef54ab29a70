"""A map of a driven pipe, from signals and words alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from math import degrees, radians
from types import SimpleNamespace

import pytest

from pirate_sm.api import run
from pirate_sm.core import library
from pirate_sm.core._model.pipe_runs import Mitre
from pirate_sm.core.documents import parse_document
from pirate_sm.core.effects import Setpoints, StateChange
from pirate_sm.core.events import DetectorWord, SensorFrame, SubmitResult
from pirate_sm.core.loading import load_robot, validate
from pirate_sm.core.models import Pipe, Profile, Straight
from pirate_sm.lab.mapping.legs import Map
from pirate_sm.lab.mapping.mapper import mapped
from pirate_sm.lab.mapping.pipe_text import pipe_text
from pirate_sm.running.recording.read.pieces import Gap, RecordedStep
from pirate_sm.running.recording.read.places import recorded_places
from pirate_sm.running.recording.read.reader import Recording, read_recording

NEAR_M, NEAR_RAD = 0.020, radians(3)
"""The bar for a map."""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A bend that the robot has passed, with the detector that knows the pipe's file."""
    path = tmp_path_factory.mktemp("map") / "bend.mcap"
    run("mitre_bend", detector="odometry", record=path)
    return read_recording(path)


@pytest.fixture(scope="module")
def profile() -> Profile:
    return load_robot(library.find_robot("pirate_ii")).profile


@pytest.fixture(scope="module")
def found_map(recorded: Recording) -> Map:
    return mapped(recorded)


def pipe_of(made: Map, **options: float) -> Pipe:
    text = pipe_text(made, "found", "bend.mcap", **options)
    return validate(parse_document(text, "found.yaml"), Pipe)


@pytest.mark.thorough
def test_a_driven_bend_is_as_in_its_file(
    recorded: Recording, found_map: Map, profile: Profile
) -> None:
    found = pipe_of(found_map, first_wheel_m=0.7)
    assert found.segments is not None
    first, bend, last = found.segments
    assert isinstance(first, Straight)
    assert first.straight == pytest.approx(1.0, abs=NEAR_M)
    assert isinstance(bend, Mitre)
    assert bend.mitre == pytest.approx(radians(90), abs=NEAR_RAD)
    assert isinstance(last, Straight)
    *_, at = recorded_places(recorded, profile.body)  # where the first wheel came to, in truth
    assert last.straight == pytest.approx(at.wheels[0][1], abs=NEAR_M)
    assert found.diameter == pytest.approx(0.120, abs=0.002)
    assert degrees(found.tilt) == pytest.approx(0, abs=3)


@pytest.mark.thorough
def test_without_a_known_start_it_begins_at_the_last_wheel(found_map: Map) -> None:
    found = pipe_of(found_map)
    assert found.segments is not None
    assert found.start is not None
    first = found.segments[0]
    assert isinstance(first, Straight)
    assert first.straight - found.start.at == pytest.approx(0.3, abs=NEAR_M)
    assert found.start.at == pytest.approx(0.458, abs=0.002)  # the length of the robot


@pytest.mark.thorough
def test_neither_truth_nor_the_driven_pipe_is_read(recorded: Recording, found_map: Map) -> None:
    # The same recording, of which nothing is left but the robot, what its boards reported, what the
    # detector said, and what the robot was commanded to.
    kept = tuple(file for file in recorded.header.files if file.role in ("profile", "chart"))
    header = replace(recorded.header, files=kept, pipe="", mission="", parameters={}, options={})

    def steps() -> Iterator[RecordedStep]:
        for step in recorded.steps():
            heard = isinstance(step.event, SensorFrame | DetectorWord | SubmitResult)
            told = tuple(it for it in step.effects if isinstance(it, StateChange | Setpoints))
            if heard or told:
                yield step._replace(event=step.event if heard else None, effects=told)

    bare = SimpleNamespace(header=header, steps=steps, origin_s=recorded.origin_s, gaps=())
    assert pipe_text(mapped(bare), "found", "x") == pipe_text(found_map, "found", "x")


@pytest.mark.thorough
def test_the_pipe_in_the_recording_makes_no_difference(recorded: Recording, found_map: Map) -> None:
    other = tuple(
        replace(file, text="format: 1\npipe: other\ndiameter: 1 m\nsegments: [{straight: 1 m}]\n")
        if file.role == "pipe"
        else file
        for file in recorded.header.files
    )
    assert other != recorded.header.files
    lying = SimpleNamespace(
        header=replace(recorded.header, files=other),
        steps=recorded.steps,
        origin_s=recorded.origin_s,
        gaps=(),
    )
    assert pipe_text(mapped(lying), "found", "x") == pipe_text(found_map, "found", "x")


@pytest.mark.thorough
def test_a_bend_that_was_not_passed_is_said_to_be_unsure(recorded: Recording) -> None:
    halfway = [step for step in recorded.steps() if step.at_s - recorded.origin_s < 50.0]
    cut = SimpleNamespace(
        header=recorded.header, steps=lambda: iter(halfway), origin_s=recorded.origin_s, gaps=()
    )
    made = mapped(cut)
    assert len(made.bends) == 1
    assert made.notes == ["the last bend was not passed, so its angle and its place are not sure"]
    assert "# Incomplete: the last bend" in pipe_text(made, "found", "x")


def test_a_map_ends_at_a_gap_in_which_the_robot_may_have_moved(recorded: Recording) -> None:
    """A gap of 2 s made a straight 50 mm shorter and a bend 9° sharper, without a word."""
    origin_s = recorded.origin_s
    steps = [step for step in recorded.steps() if not 10.0 < step.at_s - origin_s < 12.0]
    before = [step for step in steps if step.at_s - origin_s <= 10.0]
    gap = Gap(steps[len(before)].number, 10.0, 12.0)
    torn, short = (
        SimpleNamespace(
            header=recorded.header, steps=partial(iter, each), origin_s=origin_s, gaps=gaps
        )
        for each, gaps in ((steps, (gap,)), (before, ()))
    )
    made, until = mapped(torn), mapped(short)

    assert made.legs == until.legs
    assert made.notes == ["nothing is known from 10.0 s to 12.0 s, so it ends there"]
