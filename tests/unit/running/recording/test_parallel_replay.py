"""A replay that is shared out among processes says the same as one that is not."""

from __future__ import annotations

import multiprocessing
import os
import signal
from itertools import pairwise
from multiprocessing.pool import ThreadPool
from types import SimpleNamespace

import pytest
from recording_runs import record

from pirate_sm.running.recording.parallel_replay import _heed_no_keys, _stretches, replay_shared
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import replay
from pirate_sm.running.recording.write import piece_maker, recorder
from pirate_sm.running.wiring import Order


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "CHECKPOINT_S", 2.0)
        return record(tmp_path_factory.mktemp("runs") / "run.mcap", Order("mitre_bend", seed=2))


@pytest.fixture(scope="module")
def wrong(tmp_path_factory):
    """A run of which one checkpoint says something else."""
    right, calls = piece_maker.state_to_text, 0

    def changed(state):
        nonlocal calls
        calls += 1
        return right(state._replace(wake_at_s=1e6) if calls == 4 else state)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorder, "CHECKPOINT_S", 2.0)
        patch.setattr(piece_maker, "state_to_text", changed)
        return record(tmp_path_factory.mktemp("runs") / "run.mcap", Order("mitre_bend", seed=2))


def alone(recording, **options):
    with recorded_mission(recording.header) as loaded:
        return replay(recording, loaded, **options)


@pytest.fixture(params=["threads", pytest.param("processes", marks=pytest.mark.thorough)])
def workers(request, monkeypatch):
    if request.param == "threads":
        threads = SimpleNamespace(Pool=lambda processes, _: ThreadPool(processes))
        monkeypatch.setattr(multiprocessing, "get_context", lambda _: threads)


@pytest.mark.thorough
@pytest.mark.usefixtures("workers")
def test_shared_out_the_same_is_found(run):
    assert replay_shared(run, 2) == alone(run)


@pytest.mark.thorough
def test_so_is_a_stretch(run):
    after = run.checkpoint(7.0)

    assert replay_shared(run, 2, after=after, until_s=20.0) == alone(run, after=after, until_s=20.0)


@pytest.mark.usefixtures("workers")
def test_so_is_the_first_difference(wrong):
    found = replay_shared(wrong, 2)

    assert found == alone(wrong)
    assert found.difference is not None
    assert found.difference.remembers == ("wake_at_s",)


@pytest.mark.parametrize("most", [1, 3, 8, 1000])
def test_the_stretches_are_the_whole_run_without_a_gap(run, most):
    stretches = list(_stretches(run, most, None, 1e9))

    assert stretches[0].after is None
    assert stretches[-1].until is None
    assert all(a.until == b.after for a, b in pairwise(stretches))
    assert len(stretches) <= min(most, len(list(run.checkpoints()))) + 1


@pytest.mark.parametrize(("after_s", "until_s"), [(0.0, 1e9), (0.0, 12.0), (12.0, 1e9)])
def test_the_stretches_are_of_similar_length(run, after_s, until_s):
    stretches = list(_stretches(run, 3, run.checkpoint(after_s), until_s))

    begins_s = [each.after.at_s if each.after else 0.0 for each in stretches]
    share_s = (min(until_s, run.until_s) - begins_s[0]) / 3
    assert len(stretches) == 3
    for begin_s, end_s in pairwise(begins_s):
        assert share_s <= end_s - begin_s < share_s + 2.1, "there is a checkpoint each 2 s"


def test_an_interrupt_from_the_keyboard_is_left_to_the_main_process():
    before = signal.getsignal(signal.SIGINT)
    try:
        _heed_no_keys()
        os.kill(os.getpid(), signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
