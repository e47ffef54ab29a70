"""Of very many things some are kept, evenly, the first and the newest always."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pirate_sm.running.recording.signal_names import add_evenly


@given(st.lists(st.floats(0.01, 10.0), min_size=1, max_size=400), st.integers(4, 40))
def test_the_first_and_the_newest_stay_and_never_more_than_may(gaps: list[float], most: int):
    times: list[float] = []
    things: list[int] = []
    apart_s, at_s = 0.0, 0.0
    for number, gap_s in enumerate(gaps):
        at_s += gap_s
        apart_s = add_evenly(times, things, (at_s, number), apart_s, most)
        assert (times[0], things[0]) == (gaps[0], 0)
        assert (times[-1], things[-1]) == (at_s, number)
        assert len(times) == len(things) <= most
        assert times == sorted(times)


def test_few_things_all_stay_and_of_two_at_one_time_the_newer():
    times: list[float] = []
    things: list[str] = []
    for at_s, thing in ((0.0, "a"), (1.0, "b"), (1.0, "c"), (1.1, "d")):
        add_evenly(times, things, (at_s, thing), 0.0, 10)

    assert (times, things) == ([0.0, 1.0, 1.1], ["a", "c", "d"])
