"""`pirate cache`: shows and clears the kept results of checks."""

from __future__ import annotations

from pirate_sm.checking import kept_results
from pirate_sm.cli.options.files import CacheOptions
from pirate_sm.core.errors import UsageError
from pirate_sm.core.visible import visible

_MIB = 1 << 20


def show_cache(options: CacheOptions) -> int:
    """Print where results are kept and how many, or remove them; return the exit code.

    Raises:
        UsageError: They cannot be removed.
    """
    folder = kept_results.results_folder()
    if folder is None:
        print(f"{kept_results.FOLDER_VARIABLE} is empty: no results are kept")
        return 0
    entries = kept_results.entries(folder)
    many = "1 result" if len(entries) == 1 else f"{len(entries)} results"
    if options.what == "clear":
        try:
            kept_results.remove(entries)
        except OSError as error:
            raise UsageError(f"results in {folder} cannot be removed: {error.strerror}") from None
        print(f"{many} removed from {visible(str(folder))}")
        return 0
    size, most = sum(each.size for each in entries) / _MIB, kept_results.LARGEST / _MIB
    print(f"{visible(str(folder))}: {many}, {size:.1f} of at most {most:.0f} MiB")
    return 0
