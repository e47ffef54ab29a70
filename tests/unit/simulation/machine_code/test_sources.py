"""What machine code depends on, and that a change of it is noticed."""

from __future__ import annotations

from pathlib import Path

import pytest

from pirate_sm.simulation.machine_code.built_library import digest, files_behind


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A package whose module `a` imports `b`, a name of the package `c`, and modules of others."""
    folder = tmp_path / "thing"
    (folder / "c").mkdir(parents=True)
    (folder / "__init__.py").write_text("", "utf-8")
    (folder / "a.py").write_text(
        "import math\nfrom thing import b\nfrom thing.c import x\n", "utf-8"
    )
    (folder / "b.py").write_text("import numpy.linalg\nimport thing.a\n", "utf-8")
    (folder / "c" / "__init__.py").write_text("from thing.c.d import x\n", "utf-8")
    (folder / "c" / "d.py").write_text("x = 1\n", "utf-8")
    (folder / "e.py").write_text("", "utf-8")
    return folder


def test_everything_that_is_imported_counts_and_nothing_else(package: Path) -> None:
    assert files_behind(["thing.a", "other.a"], package) == (
        "a.py",
        "b.py",
        "c/__init__.py",
        "c/d.py",
    )


def test_a_module_that_hands_a_name_on_counts_but_not_what_else_it_imports(package: Path) -> None:
    (package / "hands_on.py").write_text("from thing.e import z\nfrom thing.c.d import x as y\n")
    (package / "a.py").write_text("from thing.hands_on import y\n")

    assert files_behind(["thing.a"], package) == ("a.py", "c/d.py", "hands_on.py")


def test_a_package_may_import_its_own_modules(package: Path) -> None:
    (package / "c" / "__init__.py").write_text("from thing.c import d\nfrom . import d as f\n")
    (package / "a.py").write_text("from thing.c import d\n")

    assert files_behind(["thing.a"], package) == ("a.py", "c/__init__.py", "c/d.py")


def test_a_change_in_any_file_changes_the_digest(package: Path) -> None:
    files = files_behind(["thing.a"], package)
    found = {digest(files, package)}
    for name in files:
        with (package / name).open("a") as file:
            file.write("# edited\n")
        found.add(digest(files, package))

    assert len(found) == len(files) + 1
    assert digest(files, package) == digest(files, package) != ""


def test_without_one_of_the_files_there_is_no_digest(package: Path) -> None:
    files = files_behind(["thing.a"], package)
    (package / "b.py").unlink()

    assert digest(files, package) == ""
