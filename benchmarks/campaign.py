"""Many runs of missions in the simulator, without a view, as fast as they go, shared by processes.

For benchmarks that judge runs by rules of their own; `pirate campaign` counts by the usual ones.
"""

from __future__ import annotations

from argparse import ArgumentParser, RawTextHelpFormatter
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from multiprocessing import get_context
from os import cpu_count

from pirate_sm.core.loading import LoadedMission
from pirate_sm.lab.campaign.watched_run import Outcome, watched_run
from pirate_sm.running.wiring import Order, load


def options_of_rows(
    about: str | None, rows: Sequence[str], seeds: int | None, counted: str
) -> ArgumentParser:
    """Return the options of a command that runs rows of many seeds.

    Args:
        about: What the command does.
        rows: The names of the rows, of which some can be chosen.
        seeds: How many seeds it runs by default.
        counted: What the number of seeds counts.
    """
    parser = ArgumentParser(description=about, formatter_class=RawTextHelpFormatter)
    parser.add_argument("--row", action="append", choices=rows)
    parser.add_argument("--seeds", type=int, default=seeds, help=counted)
    parser.add_argument("--workers", type=int, help="processes; all processors by default")
    return parser


@cache
def _loaded(mission: str, pipe: str | None, settings: tuple[tuple[str, str], ...]) -> LoadedMission:
    return load(Order(mission, pipe=pipe, settings=dict(settings)))


def run(order: Order) -> Outcome:
    """Run the mission to its end; an internal error is raised."""
    return watched_run(order, _loaded(order.mission, order.pipe, tuple(order.settings.items())))


def run_all(orders: Iterable[Order], *, workers: int | None = None) -> list[Outcome]:
    """Run every mission; return the outcomes in the order of the orders.

    Args:
        orders: What to run.
        workers: How many processes share the work; one for each processor by default. The
            outcomes are the same for any number.
    """
    wanted = list(orders)
    first = run(wanted[0])  # compiles the simulator once, before the others need it
    with ProcessPoolExecutor(workers or cpu_count() or 1, mp_context=get_context("spawn")) as pool:
        return [first, *pool.map(run, wanted[1:], chunksize=max(1, len(wanted) // 64))]
