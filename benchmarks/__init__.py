"""Measurements behind the numbers in the docs; none of them is part of the tests."""

from __future__ import annotations

import os

# What is measured leaves no recordings behind, unless it is the recording that is measured.
os.environ.setdefault("PIRATE_SM_RUNS", "")
