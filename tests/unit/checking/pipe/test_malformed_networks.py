"""Malformed networks, and a robot that does not fit, are refused with their places."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest
import yaml
from representative import thorough_but

from pirate_sm.checking import catalogue
from pirate_sm.checking.check_project import check_paths
from pirate_sm.checking.findings import Finding

from .invented_networks import (
    MISFITS,
    MISSION,
    SPOILS,
    Network,
    junk_in,
    mission_on,
    well_formed,
)

MALFORMED = [(name, seed) for seed in range(4) for name in SPOILS]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def findings(folder: Path, net: Network, mission: str = "") -> tuple[Finding, ...]:
    text = yaml.safe_dump(net, sort_keys=False)
    (folder / "net.yaml").write_text(text, encoding="utf-8")
    if mission:
        (folder / "visit.yaml").write_text(mission, encoding="utf-8")
    found = check_paths(["."] if mission else ["net.yaml"]).findings
    lines = text.splitlines()
    for each in found:
        assert each.code in catalogue.entries()
        assert each.code != "check.failed", each.message
        assert each.message
        if each.place.file == "net.yaml":
            assert 1 <= each.place.line <= len(lines)
            assert 1 <= each.place.column <= len(lines[each.place.line - 1]) + 1
    return found


def test_there_are_two_hundred_malformed_networks() -> None:
    assert len(MALFORMED) >= 200


@pytest.mark.parametrize("seed", thorough_but(range(10), range(50)))
def test_a_well_formed_network_is_accepted(seed: int, here: Path) -> None:
    assert findings(here, well_formed(Random(seed)), MISSION) == ()


@pytest.mark.parametrize(("name", "seed"), thorough_but(MALFORMED[: len(SPOILS)], MALFORMED))
def test_a_malformed_network_is_refused_at_its_place(name: str, seed: int, here: Path) -> None:
    rng = Random(seed)
    net = well_formed(rng)
    spoil, code = SPOILS[name]
    spoil(net, rng)

    found = findings(here, net)

    assert found
    assert code in {each.code for each in found}, [(each.code, each.message) for each in found]
    assert all(each.severity.word == "error" for each in found)


@pytest.mark.parametrize("seed", thorough_but(range(2), range(10)))
@pytest.mark.parametrize("name", MISFITS)
def test_a_robot_that_does_not_fit_is_refused(name: str, seed: int, here: Path) -> None:
    rng = Random(seed)
    net = well_formed(rng)
    spoil, code = MISFITS[name]
    spoil(net, rng)

    found = findings(here, net, MISSION)

    assert {each.code for each in found} == {code}
    assert all(each.place.file == "net.yaml" for each in found)


@pytest.mark.parametrize("seed", thorough_but(range(20), range(100)))
def test_junk_anywhere_is_refused_or_read_without_a_fault_of_the_program(
    seed: int, here: Path
) -> None:
    rng = Random(seed)
    net = well_formed(rng)
    junk_in(net, rng)

    findings(here, net, MISSION)


@pytest.mark.parametrize("seed", thorough_but(range(5), range(20)))
def test_a_mission_on_any_route_is_judged_by_what_it_does_there(seed: int, here: Path) -> None:
    rng = Random(seed)
    net = well_formed(rng)
    mission = mission_on(net, rng)

    found = findings(here, net, mission)

    assert {each.code.partition(".")[0] for each in found} <= {"geometry", "tee"}
