"""Sessions let frames pass that concern nobody, one alone or many at once.

What an operator's commands come to is the same as when every frame goes through the engine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from random import Random

import pytest
from representative import thorough_but

from agreement.robots import NEWT
from benchmarks.gliding import Stepping, Taken
from pirate_sm import Session, advance_all, load
from pirate_sm.api.arguments import prepared

MISSIONS = {
    "mitre_bend": {"start_jitter_m": 0.02, "friction_jitter": 0.2},
    "take_elbow": {"start_jitter_m": 0.02, "diameter_jitter_m": 0.002},
    "climb": {"defects": ("wheels_3_4_dead", "gamma_2_sticks")},
    "level": {},
    str(NEWT / "patrol.yaml"): {"friction_jitter": 0.2},
}
DRIVES_BY_DISTANCE = {"climb"}
"""It reads the distance, so that every frame goes through the engine while it drives."""
STEPS = 12

pytestmark = pytest.mark.timeout(300)  # the first run compiles


def session(mission: str, seed: int, *, glides: bool) -> tuple[Session, Taken]:
    ready = prepared(mission, "sim", seed, check=False, yes=False, **MISSIONS[mission])  # type: ignore[arg-type]
    taken = Taken(ready.backend)
    return Session(ready if glides else replace(ready, backend=Stepping(ready.backend))), taken


def command(some: Session, lot: Random, names: Sequence[str]) -> None:
    """Mostly one of the commands is given that can be."""
    able = [name for name in names if some.ended is None and not some.why_not(name)]
    if able and lot.random() < 0.9:
        some.submit(lot.choice(able))


def seen(some: Session) -> str:
    """Everything that a session shows."""
    return f"{some.now_s!r} {some.status!r} {some.ended!r} {some.state!r} {some.signals!r}"


def names_of(mission: str) -> Sequence[str]:
    return [*load(mission).robot.table.commands]


def course(mission: str, seed: int, *, glides: bool) -> tuple[list[str], int]:
    """What a session shows between random commands, at its end too, and how many frames glided."""
    lot, lines = Random(seed), []
    some, taken = session(mission, seed, glides=glides)
    with some:
        for _ in range(STEPS):
            command(some, lot, names_of(mission))
            some.advance(within_s=8.0)
            lines.append(seen(some))
            some.advance(some.now_s + lot.choice((0.01, 0.5)))
            lines.append(seen(some))
    run = some.run
    tables = {name: run.table(name) for name in run.tables}
    return [*lines, seen(some), repr(tables)], taken.frames


@pytest.mark.parametrize("mission", thorough_but(["mitre_bend"], MISSIONS))
@pytest.mark.parametrize("seed", [
    1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 12))
])  # fmt: skip
def test_commands_of_an_operator(mission: str, seed: int) -> None:
    glided, taken = course(mission, seed, glides=True)
    stepped, none = course(mission, seed, glides=False)

    assert glided == stepped
    assert none == 0
    assert taken > 0 or mission in DRIVES_BY_DISTANCE


@pytest.mark.thorough
@pytest.mark.parametrize("threads", [1, 2, 5])
def test_many_sessions_at_once(threads: int) -> None:
    seeds = range(4)
    alone = [course("take_elbow", seed, glides=True)[0] for seed in seeds]

    names, lots = names_of("take_elbow"), [Random(seed) for seed in seeds]
    some = [session("take_elbow", seed, glides=True)[0] for seed in seeds]
    lines: list[list[str]] = [[] for _ in seeds]
    for each in some:
        each.__enter__()
    for _ in range(STEPS):
        for each, lot in zip(some, lots, strict=True):
            command(each, lot, names)
        advance_all(some, within_s=8.0, threads=threads)
        for each, own in zip(some, lines, strict=True):
            own.append(seen(each))
        for each, lot, own in zip(some, lots, lines, strict=True):
            each.advance(each.now_s + lot.choice((0.01, 0.5)))
            own.append(seen(each))
    for each in some:
        each.__exit__(None, None, None)

    assert lines == [own[: 2 * STEPS] for own in alone]


def test_what_has_come_is_told_for_each_session() -> None:
    near, far = (session("take_elbow", seed, glides=True)[0] for seed in (1, 2))
    with near, far:
        near.submit("DriveForward")
        assert advance_all([near, far], "speed > 10 mm/s", within_s=5.0) == [True, False]
        assert advance_all([near, far], 6.0) == [True, True]
        assert (near.now_s, far.now_s) == (6.0, 6.0)
