"""`pirate cache`: shows and clears the kept results of checks."""

from __future__ import annotations

from pirate_sm.cli.options.files import CacheOptions
from pirate_sm.core import kept_entries
from pirate_sm.core.errors import UsageError
from pirate_sm.core.visible import visible

_MIB = 1 << 20


def show_cache(options: CacheOptions) -> int:
    """Print where results are kept and how many, or remove them; return the exit code.

    Raises:
        UsageError: They cannot be removed, or their folder is one that is not used.
    """
    found = kept_entries.results()
    if found is None:
        print(f"{kept_entries.FOLDER_VARIABLE} is empty: no results are kept")
    else:
        _show(found, "result", options)
    _show(kept_entries.charts(), "table", options)
    return 0


def _show(kept: kept_entries.Entries, noun: str, options: CacheOptions) -> None:
    folder, entries = visible(str(kept.folder)), kept.all()
    if kept.refused():
        raise UsageError(
            f"{folder} is not used: it must be your own folder, with mode 0700, and no link"
        )
    many = f"1 {noun}" if len(entries) == 1 else f"{len(entries)} {noun}s"
    if options.what == "clear":
        try:
            kept.remove(entries)
        except OSError as error:
            raise UsageError(f"{noun}s in {folder} cannot be removed: {error.strerror}") from None
        print(f"{many} removed from {folder}")
        return
    size, most = sum(each.size for each in entries) / _MIB, kept_entries.LARGEST / _MIB
    print(f"{folder}: {many}, {size:.1f} of at most {most:.0f} MiB")
