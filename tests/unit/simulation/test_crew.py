"""Threads that share work."""

from __future__ import annotations

from threading import Event

import pytest

from pirate_sm.simulation.crew import Crew


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_the_work_is_done_once_for_each_thing(threads: int) -> None:
    done: list[int] = []
    with Crew(threads) as crew:
        crew.each(done.append, range(100))
        crew.each(done.append, [])

    assert sorted(done) == [*range(100)]


def test_two_things_are_done_at_once() -> None:
    met = Event(), Event()

    def meet(number: int) -> None:
        met[number].set()
        assert met[1 - number].wait(30.0)

    with Crew(2) as crew:
        crew.each(meet, range(2))


@pytest.mark.parametrize("threads", [1, 2])
def test_what_the_work_raises_leaves_the_rest_to_others(threads: int) -> None:
    done: list[int] = []

    def work(number: int) -> None:
        if number == 0:
            raise ValueError("no")
        done.append(number)

    with Crew(threads) as crew:
        with pytest.raises(ValueError, match="no"):
            crew.each(work, range(10))
        crew.each(done.append, [10])

    assert done[-1] == 10
    assert set(done) >= ({*range(1, 10)} if threads > 1 else set())
