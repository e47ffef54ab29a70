"""What runner and guardian say to each other travels through a pipe."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.robot.backends.serial.guardian.guard import Instructions, Note, NoteKind, NoteReader

from ..bench import WANTED


@given(
    notes=st.lists(st.builds(Note, st.sampled_from(NoteKind), st.binary(max_size=50))),
    cut=st.integers(1, 20),
)
def test_notes_travel_in_any_pieces(notes: list[Note], cut: int) -> None:
    data = b"".join(note.to_bytes() for note in notes)
    reader = NoteReader()
    read = []
    for at in range(0, len(data), cut):
        read += reader.feed(data[at : at + cut])

    assert read == notes


def test_instructions_come_back_as_they_were_given_but_for_texts_for_people() -> None:
    given = Instructions(0.3, tuple(each._replace(text="uint8 x") for each in WANTED), 2.0, 60.0)

    assert Instructions.from_json(given.to_json()) == given._replace(wanted=WANTED)


def test_bytes_that_are_no_note_are_refused_with_the_first_of_them() -> None:
    garbage = b"\xff" * len(Note(NoteKind.DATA, b"").to_bytes())

    with pytest.raises(ValueError, match="not a note"):
        NoteReader().feed(garbage)
