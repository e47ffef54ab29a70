from __future__ import annotations

import io

import pytest

from pirate_sm.cli.output.event_lines import EventLines, ObservedRun
from pirate_sm.core._engine.robot.evidence import NOTHING
from pirate_sm.core._engine.robot.robot_state import DENIED
from pirate_sm.core.engine import Evidence
from pirate_sm.core.robot import Mark
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, prepare
from pirate_sm.views.showing.effect_lines import left_state


@pytest.fixture(scope="module")
def held():
    engine = prepare(Order("mitre_bend", backend="sim")).engine
    state, _ = engine.start(0.0)
    here = next(index for index, parts in enumerate(engine.robot.held) if len(parts) == 2)
    return engine, state._replace(robot=state.robot._replace(configuration=here, marks=frozenset()))


def test_what_holds_and_what_is_not_confirmed_is_named(held) -> None:
    engine, state = held
    sent = (0.0,) * len(engine.robot.slots)
    mark = Mark("part", min(engine.robot.held[state.robot.configuration]), DENIED)
    proofs = (*state.proofs[:-2], NOTHING, Evidence("sensor", 2.0, 0))
    sensing = state.sensing._replace(checked_s=34.0)
    doubted = state._replace(
        robot=state.robot._replace(marks=frozenset({mark})), proofs=proofs, sensing=sensing
    )

    assert left_state(engine, doubted, sent, None) == (
        "wheels set to zero, NOT confirmed by the robot; front clamped (NOT confirmed by sensors); "
        "rear clamped (shown by sensors 32.0 s ago, NOT seen by them now)"
    )


def test_what_was_shown_after_the_last_frame_was_shown_now(held) -> None:
    engine, state = held
    sent = (0.0,) * len(engine.robot.slots)
    mark = Mark("part", min(engine.robot.held[state.robot.configuration]), DENIED)
    proofs = (*state.proofs[:-2], NOTHING, Evidence("sensor", 2.0, 0))
    sensing = state.sensing._replace(checked_s=1.96)
    robot = state.robot._replace(marks=frozenset({mark}))

    text = left_state(
        engine, state._replace(robot=robot, proofs=proofs, sensing=sensing), sent, None
    )

    assert text.endswith("rear clamped (shown by sensors 0.0 s ago, NOT seen by them now)")


def test_wheels_that_may_turn_and_a_robot_that_was_left_alone_are_named(held) -> None:
    engine, state = held
    turning = (1.0,) * len(engine.robot.slots)
    assert "may TURN" in left_state(engine, state, turning, None)
    assert left_state(engine, state, (), None).startswith("nothing was sent")


def last_line(mission: str, **order) -> str:
    """Return the last line of a run."""
    prepared = prepare(Order(mission, **order))
    out, observed = io.StringIO(), ObservedRun(prepared)
    observed.run = MissionRun(
        prepared.engine,
        prepared.backend,
        observers=[EventLines(out, observed)],
        companions=prepared.companions,
        factor=float("inf"),
    )
    observed.run.execute()
    return out.getvalue().splitlines()[-1]


@pytest.mark.parametrize("backend", ["sim", pytest.param("bay", marks=pytest.mark.thorough)])
def test_a_robot_that_is_silent_at_the_end_confirms_nothing(backend: str) -> None:
    """Its clamps were confirmed while it reported."""
    said = last_line("climb", backend=backend, defects=("bay_silent",))

    assert said.count(" s ago, NOT seen by them now)") == 2
    assert "wheels set to zero, NOT confirmed by the robot" in said


def test_a_clamp_that_sensors_show_at_the_end_is_confirmed() -> None:
    said = last_line("mitre_bend", backend="sim", defects=("gamma_2_sticks",))

    assert said.endswith("wheels set to zero; rear clamped (confirmed by sensors)")
