"""MIDI devices are found by the name of their card; what cannot be opened says why."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from pirate_sm.core.errors import UsageError
from pirate_sm.robot.control_panel.panel_reader import (
    MidiSystem,
    card_names,
    open_device,
    read_device,
)

CARDS = """\
 0 [PCH            ]: HDA-Intel - HDA Intel PCH
                      HDA Intel PCH at 0xf7f10000 irq 30
 2 [nanoKONTROL2   ]: USB-Audio - nanoKONTROL2
                      KORG INC. nanoKONTROL2 at usb-0000:00:14.0-2, full speed
"""


@pytest.fixture
def system(tmp_path: Path) -> MidiSystem:
    cards, devices = tmp_path / "cards", tmp_path / "snd"
    cards.write_text(CARDS)
    devices.mkdir()
    for name in ("controlC0", "midiC2D0", "midiC7D0", "pcmC0D0p", "seq"):
        (devices / name).touch()
    return MidiSystem(cards, devices)


def test_a_card_has_a_short_and_a_long_name() -> None:
    assert card_names(CARDS) == {
        0: "HDA Intel PCH: HDA Intel PCH at 0xf7f10000 irq 30",
        2: "nanoKONTROL2: KORG INC. nanoKONTROL2 at usb-0000:00:14.0-2, full speed",
    }
    assert card_names("--- no soundcards ---\n") == {}


def test_a_device_is_found_by_a_part_of_its_cards_name(system: MidiSystem) -> None:
    assert system.find("nanokontrol2") == system.devices / "midiC2D0"
    assert system.find("KORG INC") == system.devices / "midiC2D0"


def test_a_device_that_is_not_there_is_refused_with_those_that_are(system: MidiSystem) -> None:
    with pytest.raises(UsageError) as refused:
        system.find("Launchpad")
    assert "no MIDI device is named 'Launchpad'; connected: " in str(refused.value)
    assert "midiC2D0 (nanoKONTROL2: KORG INC." in str(refused.value)
    assert "midiC7D0 (unknown card)" in str(refused.value)


def test_a_machine_without_sound_has_no_device(tmp_path: Path) -> None:
    bare = MidiSystem(tmp_path / "cards", tmp_path / "snd")
    assert bare.listed() == []
    with pytest.raises(UsageError, match="no MIDI device is connected"):
        bare.find("nanoKONTROL2")


def test_a_file_is_no_device(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="is not a device"):
        open_device(tmp_path / "file")
    with pytest.raises(UsageError, match="No such file"):
        open_device(tmp_path / "none")


def test_a_device_without_permission_names_the_group_that_has_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*_: object) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(os, "open", refuse)
    group = Path("/dev/null").group()
    with pytest.raises(UsageError, match=rf"only the group '{group}' may; `sudo usermod -aG"):
        open_device(Path("/dev/null"))


@pytest.mark.parametrize("number", [errno.EBUSY, errno.EAGAIN])
def test_a_device_that_another_program_reads_says_so(
    monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def refuse(*_: object) -> int:
        raise OSError(number, "busy")

    monkeypatch.setattr(os, "open", refuse)
    with pytest.raises(UsageError, match="another program uses it"):
        open_device(Path("/dev/null"))


def test_reading_tells_bytes_from_a_device_that_has_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(fd: int, most: int) -> bytes:
        raise OSError(errno.ENODEV, "No such device")

    end, other = os.pipe()
    os.set_blocking(end, False)
    assert read_device(end) == b""
    os.write(other, b"\xb0")
    assert read_device(end) == b"\xb0"
    os.close(other)
    assert read_device(end) == "its device has closed"
    os.close(end)
    monkeypatch.setattr(os, "read", read)
    assert read_device(end) == "No such device"
