from __future__ import annotations

import signal

import pytest

from pirate_sm.runtime.stopping import BY_SIGNAL, CaughtSignals, StopRequests


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


def test_a_second_ctrl_c_insists_and_a_third_does_what_it_always_did() -> None:
    requests = StopRequests()

    with CaughtSignals(requests):
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        assert requests.urgent
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


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
