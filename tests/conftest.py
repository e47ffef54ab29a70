"""Settings that hold for every test."""

from __future__ import annotations

import gc
import os
import pty
import tty
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

from pirate_sm.simulation.machine_code.built_library import find_library

# The same examples on every machine and no wall clock; HYPOTHESIS_PROFILE=explore draws new ones.
same = {"derandomize": True, "database": None, "deadline": None}
settings.register_profile("repeatable", max_examples=15, **same)
settings.register_profile("thorough", max_examples=100, **same)
settings.register_profile("explore", max_examples=2_000, deadline=None)
settings.load_profile(profile := os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))
if profile == "repeatable":
    # Otherwise examples hang on the constants of all modules that happen to be loaded, which each
    # process would read for seconds.
    providers.is_local_module_file = lambda path: False

# On a busy machine the threads of linear algebra wait for each other a hundred times longer than
# the small matrices here take. It counts only if it is set before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Runs leave no recordings behind, those of child processes neither.
os.environ["PIRATE_SM_RUNS"] = ""
# And no results: one that a test has changed the checks for would be found again by the next.
os.environ["PIRATE_SM_CACHE"] = ""


@pytest.hookimpl(optionalhook=True)  # without xdist nobody asks
def pytest_xdist_auto_num_workers() -> int:
    """Return one worker more than there are cores: some tests wait for processes and ports."""
    return (os.cpu_count() or 1) + 1


def pytest_report_header() -> list[str]:
    """Return why the simulator is compiled while tests wait for it, as after changes of sources.

    The first test that simulates something can then take more than a minute, which looks as if it
    had stopped.
    """
    found = find_library()
    return [] if found.library else [f"slow, the simulator is compiled as it runs: {found.why_not}"]


# Otherwise the garbage collector takes a sixth of the processor time of the suite.
gc.set_threshold(50_000, 20, 20)


def pytest_collection_finish() -> None:
    """Spare the garbage collector the thousands of tests."""
    gc.collect()
    gc.freeze()


class MidiPlug:
    """A MIDI device that a test plays: a pseudo-terminal behind a link, as a port is to udev.

    Attributes:
        path: Where it is; the same again after it was plugged in anew.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / "midi"
        self._ends: tuple[int, ...] = ()
        self.plug()

    def plug(self) -> None:
        self._ends = pty.openpty()
        tty.setraw(self._ends[1])  # bytes arrive as they were sent
        self.path.symlink_to(os.ttyname(self._ends[1]))

    def unplug(self) -> None:
        self.path.unlink(missing_ok=True)
        for end in self._ends:
            with suppress(OSError):
                os.close(end)
        self._ends = ()

    def send(self, data: bytes) -> None:
        while data:
            data = data[os.write(self._ends[0], data) :]

    def press(self, *numbers: int) -> None:
        """Press these buttons together, and release them."""
        self.send(bytes([0xB0, *(b for n in numbers for b in (n, 127))]))
        self.send(bytes([0xB0, *(b for n in reversed(numbers) for b in (n, 0))]))


@pytest.fixture(scope="session")
def assumed_speeds(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A twin whose motors are as fast as the profile assumed before decision 127.

    Its joints close before it has driven far: some courses are found with it only.
    """
    path = tmp_path_factory.mktemp("twins") / "assumed_speeds.yaml"
    speeds = "{bend: {no_load_speed: 1 rad/s}, wheel: {no_load_speed: 4.17 rad/s}}"
    path.write_text(f"format: 1\nrobot: pirate_ii\nmotors: {speeds}\n", "utf-8")
    return str(path)


@pytest.fixture
def midi(tmp_path: Path) -> Iterator[MidiPlug]:
    plug = MidiPlug(tmp_path)
    yield plug
    plug.unplug()
