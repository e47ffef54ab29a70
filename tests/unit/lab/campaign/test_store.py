"""Results can be read after whatever happens to the client or its disk."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from typing import Protocol

import pytest
from late import late

from pirate_sm.core.errors import UsageError
from pirate_sm.lab.campaign import store as stores
from pirate_sm.lab.campaign.chunk import RunRow
from pirate_sm.lab.campaign.store import Store, is_store

from .rows import row

pyarrow = late("pyarrow")
parquet = late("pyarrow.parquet")


class Opened(Protocol):
    def __call__(self, folder: Path) -> Store: ...


@pytest.fixture
def opened() -> Iterator[Opened]:
    with ExitStack() as stack:

        def open_(folder: Path) -> Store:
            store = Store(
                folder, clock=count(0, 10).__next__
            )  # so late that all is written at once
            store.begin({"campaign": "trial"})
            stack.callback(store.close)
            return store

        yield open_


def rows(*seeds: int) -> list[RunRow]:
    return [row("key", seed) for seed in seeds]


def seeds_in(folder: Path) -> list[int]:
    return sorted(each.seed for rows in Store(folder).read() for each in rows)


def test_rows_come_back_as_they_were(opened: Opened, tmp_path: Path) -> None:
    store = opened(tmp_path)
    failed = row("key", 3, "failed", "Ω: 30 % less, \n…")
    store.add([failed])

    (read,) = Store(tmp_path).read()
    assert repr(read) == repr([failed])  # NaN is not equal to itself
    assert is_store(tmp_path)
    assert Store(tmp_path).mark() == {"campaign": "trial"}


MARK = {
    "campaign": "trial",
    "cells": [
        {"key": "key", "values": {"name": "bend", "pipe": "mitre_90"}},
        {"key": "other", "values": {"name": "far", "set_way": "2 m"}},
    ],
}


def test_files_have_what_runs_have_drawn_and_the_values_of_their_cells_also_merged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stores, "_MOST_FILES", 2)
    store = Store(tmp_path, clock=count(0, 10).__next__)
    store.begin(MARK)
    added = [
        row("key", 1)._replace(drawn={"start_m": 0.01}),
        row("other", 2)._replace(drawn={"gamma_4_stiff_after": 3.5}),
    ]
    for each in added:
        store.add([each])
    store.close()
    (file,) = (tmp_path / "results").glob("*.parquet")
    read_back = parquet.read_table(file).to_pylist()

    names = ("name", "pipe", "set_way", "drawn_start_m", "drawn_gamma_4_stiff_after")
    assert [tuple(each[name] for name in names) for each in read_back] == [
        ("bend", "mitre_90", None, 0.01, None),
        ("far", None, "2 m", None, 3.5),
    ]
    (read,) = Store(tmp_path).read()
    assert repr(read) == repr(added)


def test_results_of_before_rows_had_what_was_drawn_are_read(opened: Opened, tmp_path: Path) -> None:
    opened(tmp_path)
    old = {name: [value] for name, value in rows(5)[0]._asdict().items() if name != "drawn"}
    parquet.write_table(pyarrow.table(old), tmp_path / "results" / "0-00000001.parquet")

    assert [each.drawn for found in Store(tmp_path).read() for each in found] == [{}]


def test_a_torn_file_is_named_and_the_others_are_read(opened: Opened, tmp_path: Path) -> None:
    store = opened(tmp_path)
    for seeds in ((0, 1), (2, 3), (4, 5)):
        store.add(rows(*seeds))
    store.close()
    last = sorted((tmp_path / "results").glob("*.parquet"))[-1]
    last.write_bytes(last.read_bytes()[:-20])
    (tmp_path / "results" / "0-99999999.parquet.part").write_bytes(b"PAR1")

    assert seeds_in(tmp_path) == [0, 1, 2, 3]
    reading = Store(tmp_path)
    assert len(list(reading.read())) == 2
    assert list(reading.damaged) == [last]
    assert "magic bytes" in reading.damaged[last]
    after = opened(tmp_path)
    after.add(rows(4, 5))
    assert seeds_in(tmp_path) == [0, 1, 2, 3, 4, 5]
    assert not list((tmp_path / "results").glob("*.part"))


def test_a_file_with_a_changed_byte_is_damaged(opened: Opened, tmp_path: Path) -> None:
    opened(tmp_path).add(rows(*range(50)))
    (file,) = (tmp_path / "results").glob("*.parquet")
    whole = file.read_bytes()
    column = whole.index(b"\x28\xb5\x2f\xfd")  # the first page, compressed
    for at in range(column, column + 20):
        file.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        reading = Store(tmp_path)
        assert list(reading.read()) == []
        assert list(reading.damaged) == [file]


def test_a_damaged_file_outlives_the_merging_of_others_and_is_set_aside(
    opened: Opened, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stores, "_MOST_FILES", 4)
    store = opened(tmp_path)
    store.add(rows(0))
    (first,) = (tmp_path / "results").glob("*.parquet")
    first.write_bytes(b"PAR1")
    for seed in range(1, 5):
        store.add(rows(seed))

    assert first.read_bytes() == b"PAR1"
    assert seeds_in(tmp_path) == [1, 2, 3, 4]
    store.set_aside()
    assert not first.exists()
    assert first.with_name(f"{first.name}.damaged").read_bytes() == b"PAR1"
    assert not store.damaged


def test_results_with_columns_of_another_version_say_so(opened: Opened, tmp_path: Path) -> None:
    opened(tmp_path)
    file = tmp_path / "results" / "0-00000001.parquet"
    parquet.write_table(pyarrow.table({"seed": [1]}), file)
    reading = Store(tmp_path)

    assert list(reading.read()) == []
    assert "columns are those of another version" in reading.damaged[file]


def test_many_files_become_few_and_nothing_is_lost(
    opened: Opened, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stores, "_MOST_FILES", 4)
    store = opened(tmp_path)
    for seed in range(35):
        store.add(rows(seed))

    assert seeds_in(tmp_path) == [*range(35)]
    assert len(list((tmp_path / "results").glob("*.parquet"))) < 8


def test_files_that_are_large_together_are_not_merged(
    opened: Opened, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stores, "_MOST_FILES", 4)
    store = opened(tmp_path)
    store.add(rows(0))
    (file,) = (tmp_path / "results").glob("*.parquet")
    monkeypatch.setattr(stores, "_MOST_MERGED_BYTES", 3 * file.stat().st_size)
    for seed in range(1, 9):
        store.add(rows(seed))

    assert len(list((tmp_path / "results").glob("*.parquet"))) == 9
    assert seeds_in(tmp_path) == [*range(9)]


def test_many_rows_are_read_in_parts(opened: Opened, tmp_path: Path) -> None:
    store = opened(tmp_path)
    store.add(rows(*range(20_000)))
    store.add(rows(*range(20_000, 20_007)))
    files = sorted((tmp_path / "results").glob("*.parquet"))
    together = pyarrow.concat_tables(map(parquet.read_table, files))
    for file in files:
        file.unlink()
    parquet.write_table(together, tmp_path / "results" / "1-00000001.parquet")

    assert [len(each) for each in Store(tmp_path).read()] == [20_000, 7]
    assert seeds_in(tmp_path) == [*range(20_007)]


def test_rows_that_wait_are_written_when_the_store_is_closed(tmp_path: Path) -> None:
    store = Store(tmp_path, clock=lambda: 0.0)
    store.begin({})
    store.add(rows(1))
    assert seeds_in(tmp_path) == []
    store.close()
    assert seeds_in(tmp_path) == [1]


def test_a_full_disk_is_reported_and_what_was_written_is_kept(
    opened: Opened, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = opened(tmp_path)
    store.add(rows(1))

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        with pytest.raises(UsageError, match=r"No space left on device; .* continue with --resume"):
            store.add(rows(2))
    assert seeds_in(tmp_path) == [1]
    assert not list((tmp_path / "results").glob("*.part"))


def test_one_process_at_a_time_writes(opened: Opened, tmp_path: Path) -> None:
    store = opened(tmp_path)
    with pytest.raises(UsageError, match="another process writes"):
        opened(tmp_path)
    store.close()
    opened(tmp_path).close()
