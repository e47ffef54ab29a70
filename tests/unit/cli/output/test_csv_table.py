from math import nan
from pathlib import Path

from pirate_sm.cli.output.files import write_csv


def test_an_unknown_number_is_an_empty_cell(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"

    write_csv(file, ("name", "value"), [("a, b", 1.5), ("c", nan)])

    assert file.read_text() == 'name,value\n"a, b",1.5\nc,\n'
