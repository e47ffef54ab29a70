"""Runs a mission to its end."""

from __future__ import annotations

from contextlib import ExitStack
from os import PathLike
from typing import Unpack

from pirate_sm.api.arguments import Mission, prepared
from pirate_sm.api.result import Run
from pirate_sm.api.run_log import noted
from pirate_sm.core.companion import entered
from pirate_sm.core.errors import BackendError
from pirate_sm.core.options import Options
from pirate_sm.running.runtime.ending import BUG, INTERRUPTED
from pirate_sm.running.runtime.loop import MissionRun
from pirate_sm.running.runtime.scripted_events import FirstChoice
from pirate_sm.running.wiring.adoption import adopt_alone


def run(
    mission: Mission,
    backend: str = "sim",
    *,
    seed: int = 0,
    record: str | PathLike[str] | None = None,
    check: bool = True,
    yes: bool = False,
    adopt: bool = False,
    **options: Unpack[Options],
) -> Run:
    """Run a mission to its end, as fast as the backend goes; nobody is asked anything.

    Questions of the mission get their first answer. Whatever happens, the robot is brought to its
    safe state: also on Ctrl-C, which is raised afterwards.

    Args:
        mission: A shipped mission's name, the path of a file, or what :func:`load` has returned.
        backend: Name of a backend: ``sim``, ``physics``, ``trace``, ``serial``, or another's.
        seed: Of everything random; equal seeds give equal runs.
        record: A file for a recording, which must not exist yet.
        check: Whether a mission in which the check finds errors is refused.
        yes: Whether you agree that a real robot moves.
        adopt: Whether a robot that stands elsewhere than declared is taken as its sensors show it.
        options: :class:`~pirate_sm.core.options.Options`, such as ``pipe``, ``defects``.

    Raises:
        LoadError: Everything that is wrong with the files; ``problems`` has each with its place.
        CheckError: The mission is refused; ``findings`` has why, each with its place.
        UsageError: An argument does not fit, or an extra is not installed.
        RecordingError: The recording cannot be begun.
        BackendError: The backend cannot be opened.
    """
    ready = prepared(mission, backend, seed, check=check, yes=yes, **options)
    with ExitStack() as stack:
        ready, resuming = adopt_alone(ready, stack) if adopt else (ready, None)
        notes = stack.enter_context(noted(ready, record, lambda: mission_run.state))
        stack.enter_context(entered(ready.companions))
        nobody = [] if ready.attended else [FirstChoice("nobody is asked")]
        companions = (*ready.companions, *nobody)
        mission_run = MissionRun(
            ready.engine, ready.backend, companions=companions, tap=notes, resuming=resuming
        )
        result = mission_run.execute()
    if result.error is not None:
        if result.exit_code == BUG:
            raise result.error
        if mission_run.state is None:
            raise BackendError(result.ended.message) from result.error
    if result.exit_code == INTERRUPTED:
        raise KeyboardInterrupt(result.ended.message)
    return notes.run(ready.parting())
