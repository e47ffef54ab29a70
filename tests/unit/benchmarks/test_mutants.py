"""Which tests a mutant is tried by."""

from __future__ import annotations

from benchmarks.mutants.__main__ import mirrored, nearby, sample


def test_what_runs_in_another_process_is_tried_by_the_file_that_mirrors_it() -> None:
    guardian = "robot/backends/serial/guardian"

    assert mirrored(f"pirate_sm/{guardian}/process.py") == [
        f"tests/unit/{guardian}/test_process.py"
    ]
    assert mirrored("pirate_sm/core/_engine/engine.py") == []


def test_a_file_is_tried_by_the_tests_that_mirror_it_and_then_by_those_next_to_them() -> None:
    folder = "tests/unit/core/_engine/resuming"

    mirror, next_to_it, _ = nearby("pirate_sm/core/_engine/resuming/resumption.py")

    assert (mirror, next_to_it) == ([f"{folder}/test_resumption.py"], [folder])
    assert nearby("pirate_sm/core/_engine/resuming/no_test.py")[0] == [folder]
    assert nearby("pirate_sm/core/_engine/gliding/no_tests/file.py")[0] == [
        "tests/unit/core/_engine/gliding"
    ]


def test_a_file_is_tried_last_by_the_tests_in_the_folders_above() -> None:
    backends = "tests/unit/robot/backends"

    above = nearby("pirate_sm/robot/backends/serial/link/exchange.py")[-1]

    assert f"{backends}/serial/test_backend.py" in above
    assert {each.rpartition("/")[0] for each in above} <= {
        f"{backends}/serial",
        backends,
        "tests/unit/robot",
    }


def test_another_seed_makes_other_mutants_of_the_same_files() -> None:
    packages = {"some": ("pirate_sm/core/_engine/resuming", "pirate_sm/core/_geometry/route.py")}

    one, again, other = (sample(packages, 12, seed, None)["some"] for seed in (1, 1, 2))

    assert len(one) == 12
    assert one == again != other
    assert {each.path.rpartition("/")[0] for each in (*one, *other)} <= {
        "pirate_sm/core/_engine/resuming",
        "pirate_sm/core/_geometry",
    }
