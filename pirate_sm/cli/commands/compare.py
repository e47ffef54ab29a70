"""`pirate compare`: compares two recorded runs, or two campaigns."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pirate_sm.cli.commands.replay import DIFFERENT, SAME, opened_recording, print_visible, title
from pirate_sm.cli.errors import say
from pirate_sm.cli.options.recordings import CompareOptions
from pirate_sm.core.errors import UsageError
from pirate_sm.core.expressions import Vocabulary
from pirate_sm.core.on_disk import is_folder, is_there, why_hidden
from pirate_sm.core.units import format_quantity
from pirate_sm.lab.campaign.store import is_store
from pirate_sm.running.recording.compare import (
    Comparison,
    compare,
    compared_run,
    of_each_kind,
    story,
    unlike,
)
from pirate_sm.running.recording.format.header import RunHeader
from pirate_sm.running.recording.recorded_mission import recorded_mission

UNREADABLE = 2


_MOST_SIGNALS = 12


def run_compare(options: CompareOptions) -> int:
    """Compare two recorded runs, or two campaigns, and print the result; return the exit code.

    Raises:
        RecordingError: One of the recordings cannot be read.
        UsageError: The results of a campaign cannot be read, or these two cannot be compared.
    """
    first, second = Path(options.first), Path(options.second)
    if is_store(first) and is_store(second):
        return _compare_campaigns(first, second)
    _refuse_folders(first, second)
    courses, vocabularies, headers = [], [], []
    for name, path in (("A", options.first), ("B", options.second)):
        with opened_recording(path) as recording, recorded_mission(recording.header) as loaded:
            headers.append(recording.header)
            courses.append(compared_run(recording, loaded))
            vocabularies.append(loaded.robot.vocabulary)
        print_visible(f"{name}: {title(recording)}")
    result = compare(*courses)
    head = ["", f"{story(courses[0], courses[1], result)}."]
    lines = [*head, "", *_circumstances(*headers), "", *_legs(result), ""]
    for line in [*lines, *_deviations(result, vocabularies[0])]:
        print_visible(line)
    return DIFFERENT if result.parted is not None else SAME


def _refuse_folders(*places: Path) -> None:
    """Refuse what does not exist, and folders, as recordings are files.

    Raises:
        UsageError: There is one; the message says what is in it, and what is expected.
    """
    missing = [f"there is no '{place}'" for place in places if not is_there(place)]
    missing += [
        f"'{place}' cannot be read: {why}" for place in places if (why := why_hidden(place))
    ]
    if missing:
        raise UsageError("; ".join(missing))
    problems = [
        f"'{place}' is a folder with{'' if is_store(place) else 'out'} results of a campaign"
        for place in places
        if is_folder(place)
    ]
    if problems:
        wanted = "two recordings of runs (.mcap), or two folders with results of campaigns"
        raise UsageError(f"{'; '.join(problems)}: name {wanted}")


def _compare_campaigns(first: Path, second: Path) -> int:
    from pirate_sm.lab.campaign.comparing import compare as compare_campaigns
    from pirate_sm.lab.campaign.comparing import comparison_text
    from pirate_sm.lab.campaign.conductor import stored

    both = stored(first), stored(second)
    for name, place, each in zip("AB", (first, second), both, strict=True):
        print_visible(f"{name}: {each.plan.name} in {place}, with {each.plan.version}")
    compared = compare_campaigns(*(each.tallies for each in both))
    for line in comparison_text(compared).splitlines():
        print_visible(line)
    damaged = [problem for each in both for problem in each.damaged]
    for problem in damaged:
        say(problem)
    if damaged:
        return UNREADABLE
    return DIFFERENT if compared.worse else SAME


def _circumstances(first: RunHeader, second: RunHeader) -> Iterator[str]:
    """Yield the differences in the set-up of the two runs, one line each."""
    found = unlike(first, second)
    if not found:
        yield "A and B were made with the same seed, parameters and files"
        return
    names, ones = (max(len(each[column]) for each in found) for column in (0, 1))
    yield f"{'what differed':<{max(names, 13)}}  {'A':<{max(ones, 1)}}  B"
    for each in found:
        yield f"{each.name:<{max(names, 13)}}  {each.first:<{max(ones, 1)}}  {each.second}"


def _legs(result: Comparison) -> Iterator[str]:
    """Yield when each run reached each mark of the mission, and where they part."""
    yield f"{'what the mission comes to':<42} {'A':>9} {'B':>9} {'B - A':>9}   lasted A, B"
    for leg in result.legs:
        later_s = leg.second_s - leg.first_s
        yield (
            f"{leg.mark:<42} {leg.first_s:>7.2f} s {leg.second_s:>7.2f} s {later_s:>+7.2f} s   "
            f"{leg.lasted_first_s:.2f} s, {leg.lasted_second_s:.2f} s"
        )
    if result.parted is not None:
        yield f"here the runs diverge: A reaches '{result.parted[0]}', B '{result.parted[1]}'"


def _deviations(result: Comparison, vocabulary: Vocabulary) -> Iterator[str]:
    """Yield the signals with the largest deviations, relative to the range of their kind."""
    apart = [each for each in result.deviations if each.most > 0]
    if result.deviations and not apart:
        yield "every signal is the same in A and B"
    if apart:
        yield "largest differences, relative to the range of signals of their kind:"
    for each in of_each_kind(apart)[:_MOST_SIGNALS]:
        dimension = vocabulary.dimension(each.name)
        most, typical, a, b = (
            format_quantity(float(f"{value:.4g}"), dimension)
            for value in (each.most, each.typical, each.first, each.second)
        )
        yield (
            f"  {each.name:<16} up to {most}, typically {typical}; "
            f"most after '{each.where}' at {each.at_s:.2f} s of A: {a} and {b}"
        )
