"""Test contracts: what every backend and every detector must do.

To test your own, derive a class, and pytest finds the tests in it:

    from pirate_sm.testing import BackendContract, Candidate

    class TestRig(BackendContract):
        @pytest.fixture
        def candidate(self) -> Candidate:
            return Candidate(make_rig, still=…, moving=…, mission=load("mission.yaml"))

Only this package needs pytest.
"""

from __future__ import annotations

import pytest

pytest.register_assert_rewrite("pirate_sm.testing.contracts")

from pirate_sm.testing.contracts import (  # noqa: E402 - rewritten first
    BackendContract,
    Candidate,
    DetectorContract,
    Subject,
)

__all__ = ["BackendContract", "Candidate", "DetectorContract", "Subject"]
