"""The faults that any robot can have: one list, which the documentation tells as well."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pirate_sm.core._model.faults import BUILT_IN_FAULTS, BuiltInFault

ROOT = Path(__file__).parents[4]
CODE = re.compile(r"\"([a-z]+\.[a-z_]+)\"")


def rows(page: str) -> list[list[str]]:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    table = text.partition("a mission may handle it |\n")[2].partition("\n\n")[0]
    return [
        [cell.strip(" `") for cell in line.strip("|").split(" | ")] for line in table.split("\n")
    ][1:]


def test_missions_md_lists_every_fault() -> None:
    assert rows("missions.md") == [
        [each.code, each.origin, each.meaning, "yes" if each.catchable else "no"]
        for each in BuiltInFault
    ]


def test_serial_md_says_of_each_fault_whether_a_mission_may_handle_it() -> None:
    said = {row[0]: row[-1] for row in rows("serial.md")}

    assert {"link.lost", "firmware.reset"} <= said.keys()
    assert said == {code: "yes" if BUILT_IN_FAULTS[code].catchable else "no" for code in said}


@pytest.mark.parametrize("folder", [
    *("core/_engine", "robot/backends", "robot/diagnosis", "running/runtime", "views/showing"),
])  # fmt: skip
def test_no_other_file_spells_the_code_of_a_fault(folder: str) -> None:
    assert (ROOT / "pirate_sm" / folder).is_dir()
    spelled = {
        f"{file.name}: {code}"
        for file in (ROOT / "pirate_sm" / folder).rglob("*.py")
        for code in CODE.findall(file.read_text(encoding="utf-8"))
        if code in BUILT_IN_FAULTS
    }

    assert spelled == set()


def test_a_report_bears_the_code() -> None:
    report = BuiltInFault.SENSOR_SILENT.report("no value", of=("wheel_3",))

    assert report[:2] == ("sensor.silent", "no value")
    assert report.of == ("wheel_3",)
