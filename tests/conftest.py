"""Settings that hold for every test."""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

# The same examples on every machine and no wall clock; HYPOTHESIS_PROFILE=explore draws new ones.
settings.register_profile("repeatable", derandomize=True, database=None, deadline=None)
settings.register_profile("explore", max_examples=2_000, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

# On a busy machine the threads of linear algebra wait for each other a hundred times longer than
# the small matrices here take. It counts only if it is set before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Runs leave no recordings behind, those of child processes neither.
os.environ["PIRATE_SM_RUNS"] = ""


@pytest.hookimpl(optionalhook=True)  # without xdist nobody asks
def pytest_xdist_auto_num_workers() -> int:
    """Return one worker more than there are cores: some tests wait for processes and ports."""
    return (os.cpu_count() or 1) + 1
