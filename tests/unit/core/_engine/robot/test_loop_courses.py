"""Whatever happens in whatever order, the promises of `world.py` hold with loops of states too."""

from __future__ import annotations

from driving import Driver
from hypothesis import HealthCheck, given, settings
from world import COURSES, Action, Course, replay

DRIVING = 6
"""After obeying for so long the newt is seen to hold and drives."""


@settings(
    max_examples=settings.default.max_examples,
    suppress_health_check=[HealthCheck.function_scoped_fixture],  # it only writes files
)
@given(course=COURSES)
def test_a_mission_with_loops_survives_any_course_of_events(
    loaded: Driver, course: list[Action]
) -> None:
    run = Course(loaded.robot, loaded.engine.program, nominal=False)

    run.run([("obey", 0.5, 0)] * DRIVING + course)

    assert replay(run) == run.effects
