"""The shells themselves, at a terminal, with what `pirate completion` prints."""

from __future__ import annotations

import shutil
from collections.abc import Iterator

import pytest

from .shell import STARTED, Shell

MISSION = "mission: m\nrobot: pirate_ii\nstart: a\nphases: {}\n"
HOSTILE = r"""$(touch ran) `touch ran` \$(touch ran) \\$(touch ran) "); touch ran; (: %F{red} [x"""


@pytest.fixture(scope="module", params=STARTED)
def shell(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Shell]:
    """Each shell that is installed, in a folder with files of a stranger."""
    name: str = request.param
    if shutil.which(name) is None:
        pytest.skip(f"{name} is not installed")
    folder = tmp_path_factory.mktemp(name)
    (folder / "below").mkdir()
    (folder / "below" / "mine.yaml").write_text(MISSION)
    (folder / "my mission.yaml").write_text(MISSION)
    for stem in ("evil_1", "evil_2"):
        (folder / f"{stem}.yaml").write_text(f"{MISSION}description: '{stem} {HOSTILE}'\n")
    (folder / "odd$(touch ran);`touch ran`'\"x.yaml").write_text(MISSION)
    there = Shell(name, folder)
    yield there
    there.end()
    assert not (folder / "ran").exists(), "a file's text was run"


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("pirate exper", ["pirate", "experiment"]),
        ("pirate run mitre_bend_o", ["pirate", "run", "mitre_bend_other_side"]),
        ("pirate-run mitre_bend_o", ["pirate-run", "mitre_bend_other_side"]),
        ("pirate run mitre_bend --from=prep", ["pirate", "run", "mitre_bend", "--from=prepare"]),
        ("pirate-run mitre_bend --from pre", ["pirate-run", "mitre_bend", "--from", "prepare"]),
        ("pirate run --detector vision:setup_1", ["pirate", "run", "--detector", "vision:setup_1"]),
        ("pirate run --detector vis", ["pirate", "run", "--detector", "vision:"]),
        ("pirate run drive_on --set x", ["pirate", "run", "drive_on", "--set", "x"]),
        ("pirate run mitre_bend --set gi", ["pirate", "run", "mitre_bend", "--set", "give_up="]),
        ("pirate run enter_2d --from ", ["pirate", "run", "enter_2d", "--from"]),
        ("pirate run bel", ["pirate", "run", "below/"]),
        ("pirate run below/", ["pirate", "run", "below/mine.yaml"]),
        ("pirate run ~/below/m", ["pirate", "run", "{home}/below/mine.yaml"]),
        ("pirate run my", ["pirate", "run", "my mission.yaml"]),
        ("pirate run 'my", ["pirate", "run", "my mission.yaml"]),
        ("pirate run od", ["pirate", "run", "odd$(touch ran);`touch ran`'\"x.yaml"]),
        ("pirate run --seed ", ["pirate", "run", "--seed"]),
    ],
)  # fmt: skip
@pytest.mark.thorough
def test_a_shell_completes(shell: Shell, typed: str, expected: list[str]) -> None:
    found = [word.replace(str(shell.folder), "{home}") for word in shell.completed(typed)]

    assert found == expected


def test_a_shell_lists_what_fits(shell: Shell) -> None:
    assert "enter" in shell.offers("pirate run mitre_bend --from ", "regrip")


def test_a_shell_runs_nothing_of_what_it_lists(shell: Shell) -> None:
    assert "evil_1" in shell.offers("pirate run evil", "evil_2")
