"""Which tests a mutant is tried by."""

from __future__ import annotations

from benchmarks.mutants.__main__ import mirrored


def test_what_runs_in_another_process_is_tried_by_the_file_that_mirrors_it() -> None:
    guardian = "backends/serial/guardian"

    assert mirrored(f"pirate_sm/{guardian}/process.py") == [
        f"tests/unit/{guardian}/test_process.py"
    ]
    assert mirrored("pirate_sm/engine/engine.py") == []
