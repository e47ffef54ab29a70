"""Compare the topics that a device has introduced with those that its robot's profile names."""

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
    """Return what is known of each topic: the wanted ones, then those that only the device has.

    Args:
        wanted: What the profile names.
        offered: What the device has introduced, by direction and name.
        counts: How many frames came on each topic, by its number.
        elapsed_s: In what time.
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
