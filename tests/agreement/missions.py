"""Missions that nobody wrote: some make sense as far as they go, some none at all."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from agreement.robots import Words, configurations, words_of

ENDS = ("good", "bad")
TIMES = ("20 ms", "100 ms", "1 s", "3 s", "20 s")


class Invented(NamedTuple):
    """A mission with its robot."""

    words: Words
    mission: dict[str, Any]

    def write(self, name: str = "invented") -> Path:
        """The mission stands in a file, beside those that it calls."""
        path = self.words.folder / f"{name}.yaml"
        path.write_text(json.dumps(self.mission, indent=1), encoding="utf-8")
        return path


def invent(seed: int, kinds: Sequence[str], *, small: bool = False, robots: int = 20) -> Invented:
    """The mission of this number, for a robot of one of these kinds.

    Args:
        seed: The number.
        kinds: As :func:`agreement.robots.words_of` knows them.
        small: Whether it shall be so small that all its courses can be tried one by one.
        robots: How many robots may be made up.
    """
    lot = Random(seed)
    kind = lot.choice(kinds)
    words = words_of(kind, lot.randrange(robots) if kind == "made" else 0)
    return Invented(words, _Inventor(lot, words, small).mission())


class _Inventor:
    """Draws a mission.

    Attributes:
        sense: How likely it does what is possible where the robot is if all has gone well.
        entry: Where the robot is when a phase begins, as far as that is settled.
    """

    def __init__(self, lot: Random, words: Words, small: bool) -> None:
        self.lot, self.words, self.small = lot, words, small
        self.phases = [f"p{number}" for number in range(lot.randint(1, 2 if small else 5))]
        self.sense = lot.choice((0.5, 0.9, 1.0, 1.0, 1.0))
        self.entry: dict[str, int] = {}
        self.conditions = words.conditions
        self.odd = lot.random() < 0.4
        if small:
            self.conditions = tuple(lot.sample(words.conditions, 2))

    def mission(self) -> dict[str, Any]:
        lot, table = self.lot, self.words.robot.table
        mission: dict[str, Any] = {
            "format": 1, "mission": "invented", "robot": str(self.words.path), "start": "p0",
        }  # fmt: skip
        start = table.initial
        if lot.random() < 0.3:
            start = lot.randrange(len(table.configurations))
            mission["starts_in"] = configurations(self.words)[start]
        self.entry["p0"] = start
        if lot.random() < 0.2:
            mission["on_failure"] = lot.choice((*self.phases, *ENDS))
        if lot.random() < 0.3:
            mission["on_fault"] = [self.handler() for _ in range(lot.randint(1, 3))]
        if lot.random() < 0.1:
            mission["time_limit"] = lot.choice(("500 ms", "30 s"))
        if lot.random() < 0.3:
            mission["allow_unclamp"] = "it lies on a table"
        mission["phases"] = {name: self.phase(name) for name in self.phases}
        mission["ends"] = {"good": {"succeed": "Good"}, "bad": {"fail": "Bad: {cause}"}}
        return mission

    def phase(self, name: str) -> dict[str, Any]:
        lot, here = self.lot, self.entry.get(name, self.words.robot.table.initial)
        steps = []
        for _ in range(lot.randint(0 if lot.random() < 0.2 else 1, 2 if self.small else 4)):
            step, here = self.step(here, 2)
            steps.append(step)
        phase: dict[str, Any] = {"do": steps} if steps else {}
        if lot.random() < 0.1:
            phase["on_failure"] = lot.choice([*(p for p in self.phases if p != name), *ENDS])
        if lot.random() < 0.3:
            return phase | {"go": self.target(here, after=name)}
        phase["wait"] = [self.trigger(here) for _ in range(lot.randint(1, 3))]
        time = lot.choice(TIMES if self.odd else (TIMES[-1], "1 min"))
        return phase | {"within": {"time": time, "go": self.target(here)}}

    def target(self, here: int, after: str = "") -> str:
        """Where a phase may go that ends here.

        Args:
            here: The configuration.
            after: Of what makes sense, only phases after this one: none that go round.
        """
        lot = self.lot
        if lot.random() > self.sense:
            return lot.choice((*self.phases, *ENDS))
        fits = [name for name in self.phases if self.entry.get(name, here) == here and name > after]
        new = [name for name in fits if name not in self.entry]
        found = lot.choice((*fits, *new * 3, *ENDS))
        if found in self.phases:
            self.entry.setdefault(found, here)
        return found

    def trigger(self, here: int) -> dict[str, Any]:
        lot, go = self.lot, self.target(here)
        kind = lot.randrange(6)
        if kind == 0:
            return {"after": lot.choice(TIMES if self.odd else TIMES[-2:]), "go": go}
        if kind == 1:
            return {"operator": lot.choice(("yes", "no")), "go": go}
        trigger = {"when": self.condition(), "go": go}
        return trigger | (
            {"held": lot.choice(TIMES if self.odd else TIMES[:-2])} if lot.random() < 0.5 else {}
        )

    def handler(self) -> dict[str, Any]:
        lot = self.lot
        what = {"then": "continue"} if lot.random() < 0.3 else {"go": self._handling()}
        return {"fault": lot.choice(self.words.faults), **what}

    def _handling(self) -> str:
        return self.lot.choice((*self.phases, *ENDS))

    def condition(self) -> str:
        if self.odd and self.lot.random() < 0.2:
            return self.lot.choice(self.words.odd_conditions)
        return self.lot.choice(self.conditions)

    def step(self, here: int, depth: int) -> tuple[Any, int]:
        """A step, and where the robot is after it if all goes well."""
        lot, kind = self.lot, self.lot.randrange(16)
        step: dict[str, Any]
        if kind == 0 and depth:
            inner, here = self.steps(here, depth - 1)
            step = {"repeat": {"times": lot.randint(1, 3), "do": inner}}
        elif kind == 1 and depth:
            inner, _ = self.steps(here, depth - 1)
            step = {"choose": [{"if": self.condition(), "do": inner}]}
            if lot.random() < 0.5:
                step["else"], _ = self.steps(here, depth - 1)
        elif kind == 2:
            choices = {"yes": "continue", "no": "fail", "elsewhere": self.target(here)}
            step = {"ask": "Go on?", "choices": choices}
            if lot.random() < 0.5:
                step["timeout"] = lot.choice(("100 ms", "20 s"))
        elif kind == 3:
            step = {"log": "after {cause}"}
        elif kind == 4:
            step = {"call": lot.choice(self.words.called)}
        else:
            step, here = self.command(here)
        if lot.random() < 0.1:
            step["if"] = self.condition()
        if "log" not in step and lot.random() < 0.1:
            step["on_failure"] = lot.choice(("continue", *self.phases, *ENDS))
        return step, here

    def steps(self, here: int, depth: int) -> tuple[list[Any], int]:
        steps = []
        for _ in range(self.lot.randint(1, 2)):
            step, here = self.step(here, depth)
            steps.append(step)
        return steps, here

    def command(self, here: int) -> tuple[dict[str, Any], int]:
        lot, table = self.lot, self.words.robot.table
        able = [c for c in range(len(table.commands)) if table.follow(here, c) != here]
        if not able or lot.random() > self.sense:
            able = [*range(len(table.commands))]
        chosen = lot.choice(able)
        step: dict[str, Any] = {"command": table.commands[chosen]}
        if lot.random() < 0.25:
            step["retry"] = lot.randint(1, 2)
        if lot.random() < 0.3:
            step["unneeded"] = lot.choice(("skip", "skip", "fail"))
        return step, table.follow(here, chosen)
