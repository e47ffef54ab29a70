"""`pirate explain`: prints what the code of a finding means."""

from __future__ import annotations

from pirate_sm.checking import catalogue
from pirate_sm.checking.reports.text import explained, listed
from pirate_sm.cli.options.checks import ExplainOptions
from pirate_sm.cli.output.encoding import writable
from pirate_sm.errors import UsageError
from pirate_sm.model.fault_codes import BUILT_IN_FAULTS
from pirate_sm.spelling import meant


def explain_code(options: ExplainOptions) -> int:
    """Print the catalogue's text on the code, or the titles of all; return the exit code.

    Raises:
        UsageError: There is no such code.
    """
    code = options.code
    if code is None:
        print(writable(listed()))
        return 0
    known = {**catalogue.entries(), **BUILT_IN_FAULTS}
    if code not in known:
        hint = meant(code, known, "`pirate explain` lists them all")
        raise UsageError(f"there is no code '{code[:100]}': {hint}")
    print(writable(explained(code)))
    return 0
