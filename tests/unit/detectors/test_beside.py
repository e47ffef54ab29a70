from __future__ import annotations

import pytest

import pirate_sm
from pirate_sm.errors import UsageError
from pirate_sm.model.effects import Detected, Log
from pirate_sm.runtime.loop import MissionRun
from pirate_sm.wiring import Order, prepare


def test_a_second_detector_is_logged_and_changes_nothing() -> None:
    def words(also: str | None) -> tuple[list[tuple[str, float]], list[str]]:
        ready = prepare(Order("mitre_bend", seed=3, also=also))
        heard: list[tuple[str, float]] = []
        logged: list[str] = []

        class Watching:
            due_s = float("inf")
            listening = False

            def react(self, effects, now_s) -> None:
                heard.extend((e.word, now_s) for e in effects if isinstance(e, Detected))

            def speak(self, now_s):
                return ()

        class Screen:
            def see(self, effects, now_s) -> None:
                logged.extend(e.message for e in effects if isinstance(e, Log))

        run = MissionRun(
            ready.engine, ready.backend, companions=[*ready.companions, Watching()],
            observers=[Screen()],
        )  # fmt: skip
        assert run.execute().ended.outcome == "succeeded"
        return heard, [line for line in logged if line.startswith("also")]

    alone, silent = words(None)
    beside, logged = words("odometry")

    assert [word for word, _ in beside] == [word for word, _ in alone]
    assert silent == []
    # That the bend is passed it says half a second later, when the run has ended.
    words_beside = [f"also odometry: {word}" for word in ("close", "in")]
    assert list(dict.fromkeys(logged)) == words_beside


def test_who_waits_for_a_key_cannot_stand_beside() -> None:
    with pytest.raises(UsageError, match="operator"):
        prepare(Order("mitre_bend", also="operator"))


def test_both_count_from_the_place_that_the_user_names() -> None:
    ready = prepare(
        Order("mitre_bend", detector="odometry", also="odometry", start_at_m=0.7125, seed=1)
    )
    assert [notice for notice in ready.notices if "712.5 mm" in notice] == [
        "detector: odometry, counted from the first wheel at 712.5 mm of the pipe",
        "also detector: odometry, counted from the first wheel at 712.5 mm of the pipe",
    ]


def test_the_log_of_a_run_from_python_shows_it() -> None:
    run = pirate_sm.run("mitre_bend", also="odometry", seed=1)

    assert run.outcome == "succeeded"
