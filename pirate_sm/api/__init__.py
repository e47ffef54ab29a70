"""The public Python API, for notebooks, scripts and tests; ``pirate_sm`` itself hands it out.

Everything here does what the command line does, with the package's own exceptions.
"""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.api.arguments import Mission, check, load
from pirate_sm.api.result import Columns, Page, Run, read
from pirate_sm.api.running import batch, run, sweep
from pirate_sm.api.stepping import Session, advance_all, session
from pirate_sm.checking.findings import Finding
from pirate_sm.checking.gate import CheckError
from pirate_sm.core.documents import LoadError
from pirate_sm.core.errors import BackendError, PirateError, RecordingError, UsageError
from pirate_sm.core.expressions import ExpressionError
from pirate_sm.core.loading import LoadedMission
