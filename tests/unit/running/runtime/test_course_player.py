"""An event sequence, played to a mission in a trace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from pirate_sm.core import effects as fx
from pirate_sm.robot.backends.trace_script import Happening
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.wiring import Order, prepare

NEWT = Path(__file__).resolve().parents[3] / "robots" / "newt"

MISSION = f"""\
format: 1
mission: m
robot: {NEWT}
on_fault: [{{fault: sensor.silent, go: silent}}]
start: p
phases:
  p:
    do: [HoldNose]
    wait:
      - {{when: way > 50 mm, go: far}}
      - {{when: way > -50 mm, held: 2 s, go: held}}
      - {{operator: no, go: refused}}
    within: {{time: 5 s, go: late}}
  silent: {{go: heard}}
ends:
  far: {{succeed: Far}}
  held: {{succeed: Held}}
  refused: {{fail: Refused}}
  late: {{fail: Late}}
  heard: {{fail: "{{cause}}"}}
"""
DONE = [{"happens": "start"}, {"happens": "accepted"}, {"happens": "time"}]

Play = Callable[..., tuple[list[fx.Effect], float]]


class Seen:
    def __init__(self) -> None:
        self.effects: list[fx.Effect] = []
        self.now_s = 0.0

    def see(self, effects: Sequence[fx.Effect], now_s: float) -> None:
        self.effects += effects
        self.now_s = now_s


@pytest.fixture
def play(tmp_path: Path) -> Play:
    """What comes of a course, and when the run was over."""

    def run(*entries: dict[str, Any], head: str = "") -> tuple[list[fx.Effect], float]:
        file = tmp_path / "m.yaml"
        file.write_text(MISSION.replace("start: p\n", f"{head}start: p\n"), encoding="utf-8")
        course = tuple(Happening(**each) for each in entries)
        prepared = prepare(Order(str(file), "trace", course=course))
        seen = Seen()
        MissionRun(
            prepared.engine, prepared.backend, observers=[seen], companions=prepared.companions
        ).execute()
        return seen.effects, seen.now_s

    return run


def end(effects: list[fx.Effect]) -> str:
    (ended,) = (each for each in effects if isinstance(each, fx.Ended))
    return ended.end or ended.message


@pytest.mark.parametrize(
    ("entries", "expected"),
    [
        ([{"happens": "sensors", "signals": {"way": "60 mm"}}], "far"),
        (
            [
                {"happens": "sensors", "signals": {"way": "0 mm"}},
                {"happens": "time", "signals": {"way": "0 mm"}},
            ],
            "held",
        ),
        ([{"happens": "time"}], "late"),
        ([{"happens": "answer", "answer": "no"}], "refused"),
        ([{"happens": "fault", "fault": "sensor.silent"}, {"happens": "accepted"}], "heard"),
    ],
)
def test_what_the_course_says_happens(
    play: Play, entries: list[dict[str, Any]], expected: str
) -> None:
    effects, _ = play(*DONE, *entries)

    assert end(effects) == expected


def test_a_command_is_rejected_or_not_done_where_the_course_says_so(play: Play) -> None:
    rejected, _ = play({"happens": "start"}, {"happens": "rejected"})
    failed, _ = play({"happens": "start"}, {"happens": "accepted"}, {"happens": "not_done"})

    assert "setpoints rejected" in end(rejected)
    assert "not done in time" in end(failed)


def test_sensors_show_something_with_the_event_and_not_before(play: Play) -> None:
    """At the deadline of the held condition it is the way that decides, not the way until then."""
    effects, now_s = play(
        *DONE[:2],
        {"happens": "time", "signals": {"way": "0 mm"}},
        {"happens": "time", "signals": {"way": "60 mm"}},
    )

    assert end(effects) == "far"
    assert now_s == pytest.approx(4.0)  # nominal 2 s, then the 2 s of the other condition


def test_an_answer_comes_together_with_what_sensors_show(play: Play) -> None:
    effects, _ = play(*DONE, {"happens": "answer", "answer": "no", "signals": {"way": "-1 m"}})

    assert end(effects) == "refused"


def test_once_the_course_is_over_all_goes_well(play: Play) -> None:
    effects, now_s = play(*DONE)

    assert end(effects) == "far"  # the first trigger
    assert now_s < 10


def test_the_start_can_show_something(play: Play) -> None:
    effects, _ = play({"happens": "start", "signals": {"way": "60 mm"}}, *DONE[1:])

    assert end(effects) == "far"


def test_a_time_limit_leaves_room_for_the_course(play: Play) -> None:
    effects, _ = play(*DONE, {"happens": "time"}, head="time_limit: 1 s\n")

    assert end(effects) == "late"
