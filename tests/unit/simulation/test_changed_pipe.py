"""A simulated pipe has the numbers that a run gives it, in the units of its file."""

from __future__ import annotations

from math import radians
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core import library
from pirate_sm.core.errors import UsageError
from pirate_sm.core.loading import LoadedMission, load_mission
from pirate_sm.core.models import Friction, Pipe
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.simulation import simulated_robot
from pirate_sm.simulation.changed_pipe import changed_pipe, numbers_of
from pirate_sm.simulation.surroundings import NO_JITTER, Jitter, Surroundings, surroundings_of


@pytest.fixture(scope="module")
def bend() -> LoadedMission:
    return load_mission(library.find_mission("mitre_bend"))


def changed(loaded: LoadedMission, **numbers: str) -> tuple[Pipe, Jitter]:
    assert loaded.pipe is not None
    given = {f"pipe.{name}": text for name, text in numbers.items()}
    given["noise.angle"] = "1 deg"
    return changed_pipe(loaded.pipe, loaded.loaded_robot.profile, given, {})


def test_a_pipe_without_numbers_is_that_of_its_file(bend: LoadedMission) -> None:
    assert changed(bend) == (bend.pipe, NO_JITTER)


def test_all_numbers_are_those_that_are_given(bend: LoadedMission) -> None:
    pipe, jitter = changed(bend, friction="0.25", diameter="118 mm", tilt="10 deg", roll="-5 deg",
                    start="0.6 m")  # fmt: skip
    numbers = numbers_of(pipe, bend.loaded_robot.profile)

    assert jitter.friction_scale == pytest.approx(0.5)
    assert jitter.wider_m == pytest.approx(-0.002)
    assert numbers["tilt"] == pytest.approx(radians(10))
    assert numbers["roll"] == pytest.approx(radians(-5))
    assert jitter.forward_m == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("frction", "0.3", "a pipe has no number 'frction'"),
        ("friction", "-1", "expected from"),
        ("tilt", "3 mm", "pipe.tilt"),
        ("tilt", "100 deg", "pipe.tilt: expected from"),
        ("diameter", "200 mm", "25% more or less"),
    ],
)
def test_numbers_that_cannot_be_are_refused(
    bend: LoadedMission, name: str, text: str, said: str
) -> None:
    with pytest.raises(UsageError, match=said):
        changed(bend, **{name: text})


def test_friction_that_is_zero_in_the_file_cannot_be_scaled(bend: LoadedMission) -> None:
    assert bend.pipe is not None
    smooth = bend.pipe.model_copy(update={"friction": Friction(static=0.0, kinetic=0.0)})

    with pytest.raises(UsageError, match=r"pipe\.friction: the file has 0, which cannot be scaled"):
        changed_pipe(smooth, bend.loaded_robot.profile, {"pipe.friction": "0.3"}, {})


@pytest.mark.parametrize("backend", ["sim", "bay"])
def test_friction_is_what_is_given_whatever_friction_the_robot_is_given(
    bend: LoadedMission, monkeypatch: pytest.MonkeyPatch, backend: str
) -> None:
    found = list[Surroundings]()

    def noted(*args: Any, **options: Any) -> Surroundings:
        found.append(surroundings_of(*args, **options))
        return found[-1]

    monkeypatch.setattr(simulated_robot, "surroundings_of", noted)
    numbers = {"friction.kinetic": "0.3", "pipe.friction": "0.25"}
    prepare(Order("mitre_bend", backend=backend, numbers=numbers), bend)

    assert [each.friction.kinetic for each in found] == [pytest.approx(0.25)]


def test_a_run_is_simulated_with_them_and_its_mission_does_not_know(bend: LoadedMission) -> None:
    order = Order("mitre_bend", numbers={"pipe.diameter": "118 mm", "pipe.start": "0.6 m"})
    usual, other = prepare(Order("mitre_bend"), bend), prepare(order, bend)
    assert usual.truth is not None
    assert other.truth is not None
    moved_m = usual.truth().arcs_m[0] - other.truth().arcs_m[0]

    assert moved_m == pytest.approx(0.1, abs=0.005)
    assert other.engine.program.diameter_m == usual.engine.program.diameter_m


TWIN = "format: 1\nrobot: pirate_ii\nfriction: {static: 0.9, kinetic: 0.6}\n"


@pytest.mark.parametrize("backend", ["sim", "bay"])
@pytest.mark.parametrize("of_robot", ["twin", "number", ""])
def test_friction_is_as_given_though_the_robot_has_another_than_its_file(
    bend: LoadedMission,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    backend: str,
    of_robot: str,
) -> None:
    found = []

    def spied(*args: Any, **more: Any) -> Any:
        found.append(surroundings_of(*args, **more).friction.kinetic)
        return surroundings_of(*args, **more)

    monkeypatch.setattr(simulated_robot, "surroundings_of", spied)
    (tmp_path / "twin.yaml").write_text(TWIN, "utf-8")
    twin = str(tmp_path / "twin.yaml") if of_robot == "twin" else None
    numbers = {"pipe.friction": "0.3"}
    numbers |= {"friction.kinetic": "0.2"} if of_robot == "number" else {}
    prepare(Order("mitre_bend", backend=backend, numbers=numbers, twin=twin), bend)

    assert found == [pytest.approx(0.3)]
