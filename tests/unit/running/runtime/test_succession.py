"""One run after the other on a backend that stays open."""

from __future__ import annotations

from pathlib import Path

from pirate_sm.core.engine import Engine
from pirate_sm.core.loading import load_mission
from pirate_sm.robot.backends.trace import TraceBackend
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import TriggerScript

ROOT = Path(__file__).parents[4]


def test_the_next_run_has_the_robot_as_it_was_left_and_the_time_goes_on() -> None:
    loaded = load_mission(ROOT / "sequences/enter_2d.yaml")
    engine, backend = Engine(loaded.robot, loaded.program, nominal=True), TraceBackend()
    first = MissionRun(engine, backend, companions=[TriggerScript(loaded.program)], keep_open=True)
    result = first.execute()
    assert result.ended.outcome == "succeeded"
    assert first.open

    second = MissionRun(engine, backend, companions=[TriggerScript(loaded.program)], after=first)
    assert second.now_s == result.now_s
    again = second.execute()

    # Clamped already, so that its first command is refused and it ends holding.
    assert again.ended.outcome == "failed"
    assert again.now_s >= result.now_s
    assert not second.open
    assert first.state is not None
    assert second.state is not None
    assert engine.safe_values(second.state) == engine.safe_values(first.state)


def test_a_run_that_breaks_closes_the_backend_all_the_same() -> None:
    loaded = load_mission(ROOT / "sequences/enter_2d.yaml")
    engine, backend = Engine(loaded.robot, loaded.program, nominal=True), TraceBackend()

    def advance(until_s: float) -> tuple[float, tuple[()]]:
        raise OSError("gone")

    backend.advance = advance  # type: ignore[method-assign]
    run = MissionRun(engine, backend, keep_open=True)

    assert run.execute().exit_code == 3
    assert not run.open
