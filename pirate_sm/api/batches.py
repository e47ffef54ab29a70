"""Simulated robots at the start of a mission, to be driven by setpoints without an engine."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Unpack

from pirate_sm.api.arguments import Mission, loaded_once, prepared, whole
from pirate_sm.core.errors import UsageError
from pirate_sm.core.options import Options

if TYPE_CHECKING:
    from pirate_sm.simulation.batch import Batch


def batch(
    mission: Mission,
    seeds: Iterable[int] = range(32),
    *,
    backend: str = "sim",
    threads: int | None = None,
    check: bool = False,
    **options: Unpack[Options],
) -> Batch:
    """Return simulated robots where a mission begins, one for each seed.

    Args:
        mission: A shipped mission's name, the path of a file, or what :func:`load` has returned.
        seeds: The seeds.
        backend: ``sim`` or ``physics``.
        threads: How many threads share the work; one for each processor by default.
        check: Whether a mission in which the check finds errors is refused.
        options: :class:`~pirate_sm.core.options.Options`, such as ``pipe``, ``defects``.

    Raises:
        LoadError: Everything that is wrong with the files; ``problems`` has each with its place.
        CheckError: The mission is refused; ``findings`` has why, each with its place.
        UsageError: An argument does not fit, there are no seeds, or the backend simulates no robot.
    """
    from pirate_sm.simulation.backend import SimulatorBackend
    from pirate_sm.simulation.batch import Batch

    count = None if threads is None else whole(threads, "threads", 1)
    loaded, rest = loaded_once(mission, **options)
    robots, link = [], None
    for seed in seeds:
        ready = prepared(loaded, backend, seed, check=check, yes=False, **rest)
        if not isinstance(ready.backend, SimulatorBackend):
            raise UsageError(f"the backend {backend} simulates no robot; take 'sim' or 'physics'")
        robots.append(ready.backend.robot)
        link = ready.loaded.loaded_robot.profile.link
        check = False  # the files are the same for every seed
    if link is None:
        raise UsageError("seeds: a batch has one robot at least")
    return Batch(robots, link, count)
