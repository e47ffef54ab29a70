"""Every backend of this package keeps the contract that other packages' backends are held to."""

from __future__ import annotations

import pytest
from representative import thorough_but
from resumes import Resumes

from pirate_sm.core.engine import Engine
from pirate_sm.core.loading import load_mission
from pirate_sm.running.runtime.breakpoints import breakables
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import TriggerScript
from pirate_sm.testing import BackendContract, Candidate

from .candidates import CANDIDATES, CLAMPING, NEWT, LateBackend


class TestBackends(BackendContract):
    @pytest.fixture(
        params=thorough_but(CANDIDATES.keys() - {"physics, round", "serial, obedient"}, CANDIDATES)
    )
    def candidate(self, request: pytest.FixtureRequest) -> Candidate:
        return CANDIDATES[request.param]


@pytest.mark.parametrize("delay_s", [0.0, 0.05, 1.9, 10.0])
def test_a_slow_answer_delays_a_mission_and_does_not_break_it(delay_s: float) -> None:
    loaded = load_mission(NEWT / "take_hold.yaml")
    backend = LateBackend(delay_s, lose_every=1_000)
    engine = Engine(loaded.robot, loaded.program, nominal=True)

    result = MissionRun(engine, backend, companions=[TriggerScript(loaded.program)]).execute()

    assert result.ended.outcome == "succeeded"
    # Two commands; the fate of the safe array is awaited for 2 s at most.
    assert result.now_s == pytest.approx(2 * (2.0 + delay_s) + min(delay_s, 2.0))


def test_a_wire_that_loses_every_echo_ends_as_a_fault_of_the_link() -> None:
    loaded = load_mission(NEWT / "take_hold.yaml")
    engine = Engine(loaded.robot, loaded.program, nominal=True)

    result = MissionRun(engine, LateBackend(lose_every=1)).execute()

    assert (result.ended.outcome, result.exit_code) == ("fault", 3)
    assert "link.no_echo" in result.ended.message


@pytest.mark.parametrize(
    "name", thorough_but(CANDIDATES.keys() - {"physics, round", "serial, obedient"}, CANDIDATES)
)
def test_a_breakpoint_before_each_line_stops_the_wheels_and_holds_the_clamps(name: str) -> None:
    candidate = CANDIDATES[name]
    loaded, backend = candidate.mission, candidate.make(0)
    engine = Engine(loaded.robot, loaded.program, nominal=backend.completion == "nominal")
    places = tuple(str(each.place) for each in breakables(loaded))
    people = Resumes()

    result = MissionRun(
        engine,
        backend,
        companions=[TriggerScript(loaded.program), people],
        breakpoints=places,
    ).execute()

    assert (result.ended.outcome, result.exit_code) == ("succeeded", 0), result.ended.message
    assert len(people.arrays) == len(places) == 4
    wheels, holding = loaded.robot.safe_zero, CLAMPING.index(-0.5)
    assert all(array[slot] == 0 for array in people.arrays for slot in wheels)
    nose = [array[holding] for array in people.arrays]
    assert nose[:2] == [0, 0]
    assert all(nose[2:]), "what holds keeps holding"
