"""`pirate run`: prepares a mission and has it run, or one that was cut off."""

from __future__ import annotations

import sys
from math import inf

from pirate_sm.cli.errors import say
from pirate_sm.cli.options.running import RunOptions
from pirate_sm.cli.options.values import read_speed
from pirate_sm.cli.output.terminal import agree, is_terminal
from pirate_sm.cli.shown_run import Manner, run_prepared
from pirate_sm.core.errors import UsageError
from pirate_sm.running.runtime.ending import CaughtSignals, StopRequests
from pirate_sm.running.wiring import prepare

ON_A_TERMINAL = 4.0
"""Mission seconds per second if a person probably watches."""


def run_mission(options: RunOptions) -> int:
    """Run the mission of the options; return the exit code.

    Raises:
        LoadError: The files have errors; nothing has moved.
        UsageError: An argument does not fit; nothing has moved.
    """
    if options.json and options.quiet:
        raise UsageError("--json and --quiet exclude each other")
    if options.json and options.plain:
        raise UsageError("--json and --plain exclude each other")
    on_terminal = is_terminal(sys.stdout) and not (options.json or options.quiet)
    factor = read_speed(options.speed, ON_A_TERMINAL if is_terminal(sys.stdout) else inf)
    if options.resume is not None:
        # Most runs never need it, and it takes time to import.
        from pirate_sm.cli.commands.resume import resume_run

        return resume_run(options, Manner(on_terminal, False, factor))
    if options.mission is None:
        raise UsageError("name a MISSION, or a recording with --resume")
    _refuse_without_resume(options)
    prepared = prepare(options.order(), say=say)
    if prepared.confirmation and not options.yes:
        what = prepared.confirmation
        agree(f"{what}. Is it free to?", nobody=f"{what}: agree to it with --yes")
    requests = StopRequests()
    manner, begun = Manner(on_terminal, False, factor), None
    with CaughtSignals(requests, ends_process=True):
        if prepared.backend.real_time:
            # Simulated robots are where they are declared to be, and it takes time to import.
            from pirate_sm.cli.taking_over import take_over

            prepared, begun = take_over(prepared, options, requests)
        return run_prepared(prepared, options, manner, requests, begun)


def _refuse_without_resume(options: RunOptions) -> None:
    """Refuse options that only --resume has.

    Raises:
        UsageError: One is given.
    """
    given = {"--look": options.look, "--at": options.at, "--accept": options.accept}
    if wrong := [name for name, value in given.items() if value]:
        raise UsageError(f"{', '.join(wrong)}: only together with --resume")
