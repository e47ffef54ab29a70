"""Compares the topics that a device has introduced with those in its robot's profile."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pirate_sm.backends.serial.link.wanted_topics import Wanted
from pirate_sm.diagnosis.facts import TopicFact
from pirate_sm.rosserial.topics import Direction, TopicInfo


def topic_facts(
    wanted: Sequence[Wanted],
    offered: Mapping[tuple[Direction, str], TopicInfo],
    counts: Mapping[int, int],
    elapsed_s: float,
) -> tuple[TopicFact, ...]:
    """Return the facts of each topic: the wanted ones, then those that only the device has.

    Args:
        wanted: The profile's topics.
        offered: The device's topics, by direction and name.
        counts: Number of frames of each topic, by its number.
        elapsed_s: Time over which they were counted, s.
    """
    found: list[TopicFact] = []
    others = dict(offered)
    for each in wanted:
        name = each.name.lstrip("/")
        info = others.pop((each.direction, name), None)
        ours = each.type, each.md5
        if info is None:
            found.append(TopicFact(name, each.direction, None, "", ours[0], "", ours[1], 0.0))
        else:
            found.append(_offered(info, *ours, counts, elapsed_s))
    return (*found, *(_offered(info, "", "", counts, elapsed_s) for info in others.values()))


def _offered(
    info: TopicInfo, our_type: str, our_md5: str, counts: Mapping[int, int], elapsed_s: float
) -> TopicFact:
    rate = counts.get(info.number, 0) / elapsed_s
    its = info.name, info.direction, info.number, info.type
    return TopicFact(*its, our_type, info.md5, our_md5, rate)
