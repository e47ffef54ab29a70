"""Each command `python -m benchmarks.X` works: it is run at its smallest, where it says little.

Pools of processes are replaced by this process, to which everything is sent as to another one.
"""

from __future__ import annotations

import pickle
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, Self, TypeVar

import pytest

from benchmarks import campaign

ROOT = Path(__file__).resolve().parents[3]

SMALLEST = (
    "align --rolls 1",
    "batch --mission mitre_bend --robots 1 --threads 2 --repeats 1",
    "belief --runs 1",
    "bench --small",
    "charts --repeats 1",
    "check --runs 1 --mission climb --phases 30 --held 2",
    "binary_frames --minutes 0.2",
    "completion --repeats 1",
    "console --seconds 1 --stops 1",
    "fidelity --row 'round: elbow' --seeds 1",
    "force_intervals",
    "gliding enter_2d --repeats 1",
    "growth --small",
    "kills --rounds 1",
    "learning --play 1 --learn 1 --seeds 1 --envs 1 --repeats 1",
    "loops --seeds 1",
    "maps --row take_elbow --seeds 1",
    "mistakes --only syntax",
    "panel --stops 1",
    "physics --repeats 1",
    "physics_agreement",
    "physics_properties --share 0.02",
    "recording --repeats 1 --minutes 1 --real-time 1 --bends 1",
    "recording --hours 0.02",
    "resume --virtual 0 --real 0 --lies 1 --hours 0.02",
    "robots --robots 1",
    "soak --commands 100 --missions 1",
    "space --row elbow --seeds 1",
    "stored_runs --runs 800 --cells 2",
    "twin --seeds 1 --times 1",
    "upright --seeds 1 --row careful",
    "vision see speed --frames 1",
    "ways enter_2d",
)
"""The commands with options with which each takes seconds."""

NOT_RUN = {
    "bends": "the mission in real time; `kills` runs the same processes for a shorter time",
    "camera_bends": "a minute of pictures for each bend; test_by_camera.py runs one of small ones",
    "campaign_kills": "campaigns on a cluster of processes that are killed, for minutes",
    "campaigns": "campaigns on a cluster of processes, for minutes",
    "editor": "talks with a server in a process; test_random_edits.py does the same",
    "falsify": "hundreds of runs of three missions; test_falsify.py searches in a toy",
    "mutants": "copies and compiles the tree, and runs tests itself; see test_mutants.py",
    "page": "runs in real time that browsers watch; test_page_process.py stops one",
    "witness": "serves a port until it is asked to end; `kills` starts it",
}

MAY_MISS_A_BAR = {"kills", "physics", "soak", "twin", "vision"}
"""They judge times, or numbers for which they need more, and end with exit code 1 then."""

T = TypeVar("T")


class InThisProcess:
    """A pool of processes that has none: functions, arguments and results are sent to and fro."""

    def __init__(self, *_: object, **__: object) -> None:
        pass

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def map(self, work: Callable[..., T], *given: Iterable[Any], chunksize: int = 1) -> Iterator[T]:
        return (sent(sent(work)(*sent(each))) for each in zip(*given, strict=False))


def sent(thing: T) -> T:
    it: T = pickle.loads(pickle.dumps(thing))
    return it


def commands() -> Iterator[str]:
    for path in [*(ROOT / "benchmarks").glob("*.py"), *(ROOT / "benchmarks").glob("*/__main__.py")]:
        if '\nif __name__ == "__main__":\n' in path.read_text("utf-8"):
            yield path.parent.name if path.stem == "__main__" else path.stem


def test_every_benchmark_is_run_at_its_smallest_or_it_is_said_why_not() -> None:
    run = {line.split()[0] for line in SMALLEST}

    assert run.isdisjoint(NOT_RUN)
    assert {*commands()} == run | NOT_RUN.keys()


@pytest.mark.thorough
@pytest.mark.timeout(600)  # `bench` alone takes a minute, and others work beside it
@pytest.mark.parametrize("line", SMALLEST)
def test_a_benchmark_runs_to_its_end(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    name, *options = shlex.split(line)
    module = import_module(f"benchmarks.{name}")
    for each in (module, campaign):
        monkeypatch.setattr(each, "ProcessPoolExecutor", InThisProcess, raising=False)
    monkeypatch.setattr(sys, "argv", [name, *options])
    monkeypatch.chdir(tmp_path)  # some keep files in `runs/`
    monkeypatch.setenv("PYTHONPATH", str(ROOT))

    code = module.main()

    assert not code or name in MAY_MISS_A_BAR
    assert capsys.readouterr().out
