"""`pirate check`: reports what is wrong with robots, missions and pipes."""

from __future__ import annotations

from dataclasses import astuple

from pirate_sm.checking.kept_results import kept
from pirate_sm.cli import kept_reports
from pirate_sm.cli.options.checks import CheckOptions


def run_check(options: CheckOptions) -> int:
    """Print the report; return the exit code, which says whether anything was found.

    Raises:
        UsageError: A path does not exist, an option does not fit, or the simulator is needed and
            not installed.
    """
    columns, coloured = kept_reports.look()

    def afresh() -> tuple[int, str | None]:
        from pirate_sm.cli.commands.fresh_check import fresh_check

        return fresh_check(options, columns, coloured=coloured)

    if options.fix or options.diff or options.rehearse or options.counterexamples is not None:
        code, text = afresh()  # it does more than print
    else:
        inputs = kept_reports.line or astuple(options), columns, coloured
        code, text = kept(kept_reports.WHAT, inputs, afresh, kept_reports.read)
    kept_reports.show(text)
    return code
