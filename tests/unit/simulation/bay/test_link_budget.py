"""How much the line carries at 57,600 baud, and what too much does."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median

import pytest

from pirate_sm.core.models import Pipe, Profile
from pirate_sm.simulation.bay.bay_defects import Switches
from pirate_sm.simulation.bay.virtual import VirtualBay

from .conftest import BAUD_BYTES_PER_S, ECHO, SETPOINTS, STATE, Host, MakeBay, array, read_array

FRAME_S = 48 / BAUD_BYTES_PER_S
Times = dict[int, float]


def at_rate(host: Host, hertz: float, count: int) -> tuple[Times, Times]:
    """When each array was sent, and when its echo was whole."""
    sent: Times = {}
    host.listen(0.2)
    for number in range(count):
        sent[number] = host.now_s
        host.send(SETPOINTS, array(number, number))
        # Not in step with the firmware's cycle.
        host.listen(1 / hertz + (0.001 if number % 3 else -0.002))
    host.listen(0.5)
    echoed = {read_array(h.payload)[0]: h.at_s for h in host.heard if h.topic == ECHO}
    return sent, echoed


@pytest.fixture
def uart_model(profile: Profile, texts: dict[str, str], pipe: Pipe) -> Callable[[], Host]:
    """The protocol document's model: 250 states of 14 B a second, echoes at once."""
    assert profile.serial is not None
    state = profile.serial.state.model_copy(update={"layout": "value"})
    changed = profile.model_copy(
        update={
            "serial": profile.serial.model_copy(update={"state": state}),
            "link": profile.link.model_copy(update={"cycle": 0.004, "echo_delay": 0.0}),
        }
    )
    own = {**texts, state.type: "uint8 board\nuint8 channel\nfloat32 value"}

    def made() -> Host:
        host = Host(VirtualBay(changed, pipe, own, Switches(poll_s=0.0005, dead_man=False)))
        host.connect()
        return host

    return made


@pytest.mark.thorough
def test_in_the_uart_model_20_hz_fits(uart_model: Callable[[], Host]) -> None:
    host = uart_model()
    sent, echoed = at_rate(host, 20.0, 200)
    trips = [echoed[number] - sent[number] - FRAME_S for number in sent]

    # From the whole array at the bay to the whole echo at the host; the line alone takes 8.3 ms.
    assert median(trips) == pytest.approx(0.0095, abs=0.0015)
    assert max(trips) < 0.0135
    assert host.bay.overrun == 0


def test_in_the_uart_model_100_hz_saturates(uart_model: Callable[[], Host]) -> None:
    host = uart_model()
    quiet = [each for each in host.listen(2.0) if each.topic == STATE]
    bytes_before, began = len(host.raw), host.now_s
    at_rate(host, 100.0, 300)
    busy = [each for each in host.heard if each.topic == STATE and each.at_s > began + 0.2]

    assert len(quiet) == pytest.approx(500, abs=5)
    # 300 echoes leave states a fraction of the line.
    assert len([each for each in busy if each.at_s < began + 3.2]) / 3.0 < 100
    assert (len(host.raw) - bytes_before) / (host.now_s - began) > 0.85 * BAUD_BYTES_PER_S


def test_20_hz_of_setpoints_fit(host: Host) -> None:
    sent, echoed = at_rate(host, 20.0, 200)
    states = [each for each in host.heard if each.topic == STATE]
    trips = [echoed[number] - sent[number] for number in sent]

    assert host.bay.overrun == 0
    assert max(trips) < 0.105
    assert len(states) / (states[-1].at_s - states[0].at_s) > 62.0


def test_100_hz_of_setpoints_do_not(host: Host) -> None:
    sent, echoed = at_rate(host, 100.0, 300)
    lost = [number for number in sent if number not in echoed]
    assert host.bay.overrun > 0
    assert len(lost) > 30


def sent_together(make: MakeBay, frames: int, phase_s: float, **switches: object) -> Host:
    host = make(boot_s=1.0, **switches)
    host.connect()
    host.listen(0.1 + phase_s)
    for number in range(frames):
        host.send(SETPOINTS, array(number))
    host.listen(0.3)
    return host


def test_two_setpoint_frames_in_flight_overrun_the_ring(make: MakeBay) -> None:
    hosts = [sent_together(make, 2, phase / 1000) for phase in range(16)]
    overrun = [host for host in hosts if host.bay.overrun]

    assert len(overrun) >= 8
    assert all(len(host.events("received")) < 2 for host in overrun)


@pytest.mark.thorough
def test_one_never_does(make: MakeBay) -> None:
    hosts = [sent_together(make, 1, phase / 1000) for phase in range(16)]

    assert [host.bay.overrun for host in hosts] == [0] * 16
    assert [len(host.events("echoed")) for host in hosts] == [1] * 16


def test_a_ring_without_an_end_loses_nothing(make: MakeBay) -> None:
    hosts = [sent_together(make, 3, phase / 1000, ring=None) for phase in range(16)]

    assert [len(host.events("received")) for host in hosts] == [3] * 16


def test_an_old_client_obeys_but_falls_silent_after_an_overrun(make: MakeBay) -> None:
    host = sent_together(make, 4, 0.0, old_client=True)
    assert host.bay.overrun > 0
    assert not host.bay.configured
    host.send(SETPOINTS, array(9, *(0,) * 5, 1000))

    assert host.listen(1.0) == []
    assert max(host.bay.duties) == 1.0
    host.send(0)
    assert host.listen(0.2) != []
