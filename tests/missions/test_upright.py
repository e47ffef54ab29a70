"""The bend with an upright leg: it passes, or it ends holding and says why."""

from __future__ import annotations

import shutil

import pytest
from representative import thorough_but

from pirate_sm.core import library
from pirate_sm.core.effects import Fault, StateChange

CROSSING_M = 1.0
UPRIGHT = ["mitre_90_from_below", "mitre_90_from_above", "mitre_90_up", "mitre_90_down"]
JITTER = {"start_jitter_m": 0.02, "friction_jitter": 0.2, "diameter_jitter_m": 0.002}


@pytest.mark.parametrize("pipe", UPRIGHT)
@pytest.mark.parametrize("seed", thorough_but([2], [1, 2, 10]))
def test_the_bend_is_passed_from_and_to_an_upright_leg(run, pipe, seed):
    record = run("take_bend", backend="sim", pipe=pipe, seed=seed, **JITTER)
    assert record.ended.outcome == "succeeded", record.ended.message
    assert min(record.prepared.backend.truth.arcs_m) > CROSSING_M
    assert record.of(Fault) == []


@pytest.mark.parametrize("bore_mm", thorough_but([113], [105, 110, 113, 115, 117]))
def test_a_flat_bend_is_passed_in_any_bore(run, tmp_path, bore_mm):
    pipe = tmp_path / "pipe.yaml"
    text = library.find_pipe("mitre_90").read_text("utf-8")
    assert "diameter: 120 mm" in text
    pipe.write_text(text.replace("diameter: 120 mm", f"diameter: {bore_mm} mm"), "utf-8")
    record = run("take_bend", backend="sim", pipe=str(pipe), seed=9801)
    assert record.ended.outcome == "succeeded", record.ended.message
    assert min(record.prepared.backend.truth.arcs_m) > CROSSING_M


@pytest.fixture
def late(tmp_path):
    """The mission for an upright leg that moves its clamping too late, so that it slides."""
    for name in ("prepare_bend", "pass_bend", "take_bend"):
        shutil.copy(library.find_mission(name), tmp_path)
    shutil.copytree(library.find_pipe("mitre_90").parent, tmp_path / "pipes")
    path = tmp_path / "take_bend.yaml"
    text = path.read_text("utf-8")
    in_time = "(gamma_2 < -2 deg or gamma_2 < 15 deg and diameter_rear > 116 mm)"
    right = f"when: {in_time} and gamma_2 > -30 deg,"
    assert right in text
    path.write_text(text.replace(right, "when: detector == in, held: 200 ms,"), "utf-8")
    return path


def places(backend, *times_s):
    """Where the wheels are by the truth at each of the times."""
    found, now = [], 0.0
    for until in times_s:
        while now < until:
            now, _ = backend.advance(until)
        found.append(backend.truth.arcs_m)
    return found


@pytest.mark.parametrize("seed", thorough_but([3], [3, 6, 10]))
def test_a_part_that_slides_while_it_holds_alone_is_held_and_the_bend_is_passed(run, late, seed):
    record = run(late, backend="sim", pipe="mitre_90_from_below", seed=seed, **JITTER)
    faults = [(fault.code, fault.handling) for fault in record.of(Fault)]
    assert faults == [("clamp.slipping", "again")]
    assert record.ended.outcome == "succeeded", record.ended.message
    assert min(record.prepared.backend.truth.arcs_m) > CROSSING_M


@pytest.mark.parametrize("seed", thorough_but([3], [3, 6, 10]))
def test_a_part_that_slides_while_it_holds_alone_is_a_fault_and_the_robot_ends_held(
    run, late, seed
):
    """The same, where a mission does not try again."""
    answer = "{fault: clamp.slipping, go: again}"
    text = late.read_text("utf-8")
    assert answer in text
    late.write_text(text.replace(answer, "{fault: clamp.slipping, go: regrip}"), "utf-8")
    record = run(late, backend="sim", pipe="mitre_90_from_below", seed=seed, **JITTER)
    faults = [(fault.code, fault.handling) for fault in record.of(Fault)]
    assert faults == [("clamp.slipping", "regrip")]
    assert record.ended.outcome == "failed"
    assert "both parts clamped, after clamp.slipping" in record.ended.message
    # Springs of slow joints settle for 6 s after the last command, at 24 s.
    at_rest, settled, later = places(record.prepared.backend, 40.0, 200.0, 210.0)
    assert later == pytest.approx(settled, abs=1e-3)
    assert later[-1] == pytest.approx(at_rest[-1], abs=1e-3)  # the rear carries it all along


@pytest.mark.parametrize(
    ("seed", "faults"),
    [
        # Once the rear is clamped the front opens to its end stop, for it has no wall there.
        (3, [("clamp.slipping", "again"), ("clamp.lost", "regrip")]),
        pytest.param(
            6, [("clamp.slipping", "again"), ("clamp.lost", "regrip")], marks=pytest.mark.thorough
        ),
        # It slides with a tight spring, which is not seen (decision 25), until the V has opened.
        (2, [("clamp.lost", "regrip")]),
    ],
)
def test_a_part_that_slides_back_out_of_its_leg_is_not_taken_to_hold(
    run, late, assumed_speeds, seed, faults
):
    order = {"seed": seed, "twin": assumed_speeds, **JITTER}
    record = run(late, backend="sim", pipe="mitre_90_from_below", **order)
    assert [(fault.code, fault.handling) for fault in record.of(Fault)] == faults
    assert record.ended.outcome == "failed"
    assert "there is no wall" in record.ended.message
    assert "both parts clamped" not in record.ended.message
    assert "BendingState" in record.of(StateChange)[-1].unconfirmed  # said is not seen
    backend = record.prepared.backend
    at_end = backend.truth.arcs_m
    settled, later = places(backend, 200.0, 210.0)
    assert later == pytest.approx(settled, abs=1e-3)
    assert later[-1] == pytest.approx(at_end[-1], abs=1e-3)  # the rear has carried it all along


def test_the_wheels_of_a_part_that_slides_do_not_show_it(run, late, assumed_speeds):
    """Braked wheels slide on their tyres; `speed` and `odometry` cannot tell of it."""
    order = {"seed": 10, "twin": assumed_speeds, **JITTER}
    record = run(late, backend="sim", pipe="mitre_90_from_below", **order)
    truth = record.prepared.backend.truth
    assert max(truth.arcs_m[:3]) < 1.15  # wheel 1 was at 1.19 m when the rear was relaxed
    assert record.ended.outcome == "failed"


@pytest.mark.parametrize("mission", ["mitre_bend", "mitre_bend_backward", "exp_2c_tilted"])
@pytest.mark.parametrize("seed", thorough_but([3], [3, 4]))
def test_a_part_that_holds_alone_in_a_flat_bend_is_not_said_to_slide(run, mission, seed):
    record = run(mission, backend="sim", seed=seed, **JITTER)
    assert record.ended.outcome == "succeeded", record.ended.message
    assert record.of(Fault) == []
