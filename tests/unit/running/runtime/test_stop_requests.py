from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from pirate_sm.running.runtime.ending import BY_SIGNAL, PATIENCE_S, CaughtSignals, StopRequests


@pytest.fixture(autouse=True)
def usual_signals() -> Iterator[None]:
    """Ctrl-C is heard even where the tests were started to ignore it, as in the background."""
    before = {number: signal.signal(number, signal.SIG_DFL) for number in BY_SIGNAL}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", list(BY_SIGNAL))
def test_a_signal_asks_for_a_stop_with_its_own_exit_code(number: signal.Signals) -> None:
    requests = StopRequests()
    before = signal.getsignal(number)

    with CaughtSignals(requests):
        signal.raise_signal(number)

    assert requests.stop is not None
    assert requests.stop.exit_code == 128 + number
    assert not requests.urgent
    assert signal.getsignal(number) == before


class Clock:
    now_s = 0.0

    def now(self) -> float:
        return self.now_s


def test_a_second_ctrl_c_insists_and_later_ones_do_not_break_into_the_safe_stop() -> None:
    requests, clock = StopRequests(), Clock()

    with CaughtSignals(requests, now=clock.now):
        signal.raise_signal(signal.SIGINT)
        assert not requests.urgent
        signal.raise_signal(signal.SIGINT)
        assert requests.urgent
        clock.now_s = PATIENCE_S - 0.01
        for _ in range(100):
            signal.raise_signal(signal.SIGINT)


def test_ctrl_c_ends_a_backend_that_hangs_and_does_not_say_that_nothing_moved() -> None:
    requests, clock = StopRequests(), Clock()

    with CaughtSignals(requests, now=clock.now):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        clock.now_s = PATIENCE_S
        with pytest.raises(KeyboardInterrupt, match="look at the robot"):
            signal.raise_signal(signal.SIGINT)


def test_ctrl_c_after_a_stop_is_ignored_by_a_process_that_ends() -> None:
    before = signal.getsignal(signal.SIGINT)
    try:
        with CaughtSignals(StopRequests(), ends_process=True):
            signal.raise_signal(signal.SIGINT)
        for _ in range(10):
            signal.raise_signal(signal.SIGINT)
    finally:
        for number in BY_SIGNAL:
            signal.signal(number, signal.SIG_DFL)
        signal.signal(signal.SIGINT, before)


def test_a_terminal_that_goes_after_ctrl_c_does_not_insist() -> None:
    requests = StopRequests()

    with CaughtSignals(requests):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGHUP)

    assert requests.stop == BY_SIGNAL[signal.SIGINT]
    assert not requests.urgent


def test_an_ignored_signal_stays_ignored() -> None:
    requests = StopRequests()
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with CaughtSignals(requests):
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)

    assert requests.stop is None
