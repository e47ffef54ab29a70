"""What a command uses is reported without what the program that starts it uses."""

from __future__ import annotations

import sys

import pytest

from benchmarks.used import used_by


def test_memory_of_the_program_that_starts_it_does_not_count() -> None:
    ballast = b"x" * (200 << 20)

    used = used_by(sys.executable, "-c", "")

    assert 0 < used.memory_bytes < len(ballast) / 2


def test_a_command_that_fails_is_an_error() -> None:
    with pytest.raises(RuntimeError, match="exit code 3"):
        used_by(sys.executable, "-c", "raise SystemExit(3)")
