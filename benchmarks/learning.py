"""The environments for learning: refusals, rates, and an agent that learns to pass the bend.

    python -m benchmarks.learning [--play STEPS] [--learn EPISODES] [--seeds N] [--envs N]
                                  [--repeats N]

Masked random play counts refused commands. The rates are steps per second of the wall clock: one
environment alone, and a vector of them on as many processes as there are processors, with equal
seeds and equal actions, in turn, the most of each. Then a table learns to pass the bend with the
commands of the thesis's sequence to choose from, plays other seeds by what it has learnt, and is
written as a mission, which is checked and run with these seeds. Its reward is one of its own, see
`reward`.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from os import cpu_count
from pathlib import Path
from time import perf_counter
from typing import Any

import gymnasium
import numpy as np

import pirate_sm
import pirate_sm.learning
from benchmarks.learning_table import Played, Table, learn, play
from benchmarks.learnt_mission import mission_of
from pirate_sm.lab.learning.environment import InPipe
from pirate_sm.lab.learning.rewards import Transition, least_commands
from pirate_sm.lab.learning.vector import InPipes
from pirate_sm.learning import IN_PIPE

MISSION = "mitre_bend"
REPEATS = 3
STEPS = 60
FIRST_SEED = 10_000
"""The agent is tried with seeds from here on, with which it has not learnt."""

WITHOUT = (
    *("AlignLeft", "AlignRight", "AlignStraight"),
    *("DriveBackward", "Reset", "ToggleLighting"),
)
"""Commands that the sequence of the thesis does not use; with them the table takes too long."""


AWAY_FROM_THE_WALL = "RearClampedFrontBendingBack"
"""The front bends away from the inner wall of the bend, which the check refuses there."""


def reward(step: Transition) -> float:
    """Return what the fewest commands are worth, less what the check would find."""
    away = step.command and AWAY_FROM_THE_WALL in step.after.states.values()
    return least_commands(step) - (1.0 if away else 0.0)


def main() -> int:
    """Print a line for each finding."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--play", type=int, default=100_000)
    parser.add_argument("--learn", type=int, default=400)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--envs", type=int, default=48)
    parser.add_argument("--repeats", type=int, default=REPEATS)
    wishes = parser.parse_args()
    _rates(wishes.envs, wishes.repeats)
    _learn(wishes.learn, wishes.seeds)
    _play(wishes.envs, wishes.play)
    return 0


class Dice:
    """Random actions that the masks allow, the same for each environment in any company."""

    def __init__(self, count: int) -> None:
        self._dice = [np.random.default_rng(seed) for seed in range(count)]

    def one(self, index: int, mask: Any) -> int:
        """Return an action of one environment."""
        return int(self._dice[index].choice(np.flatnonzero(mask)))

    def all(self, masks: Any) -> Any:
        """Return an action of each environment."""
        return np.array([self.one(index, mask) for index, mask in enumerate(masks)])


def _vector(count: int) -> InPipes:
    vector = gymnasium.make_vec(IN_PIPE, num_envs=count)
    assert isinstance(vector, InPipes)
    return vector


def _rates(count: int, repeats: int) -> None:
    alone, together = [], []
    workers = cpu_count() or 1
    single = gymnasium.make(IN_PIPE)
    vector = _vector(count)
    for _ in range(repeats):
        dice, steps, began_s = Dice(count), 0, perf_counter()
        for index in range(count):
            steps += play_alone(single, index, dice)
        alone.append(steps / (perf_counter() - began_s))
        dice, taken, began_s = Dice(count), 0, perf_counter()
        vector.reset(seed=0)
        over = np.zeros(count, dtype=bool)
        for _ in range(STEPS):
            masks = vector.action_masks()
            _, _, terminated, truncated, _ = vector.step(dice.all(masks))
            taken += int((~over).sum())
            over = terminated | truncated
        together.append(taken / (perf_counter() - began_s))
        assert taken == steps, "they have gone another way"
    single.close()
    vector.close()
    print(
        f"masked random play, steps/s: one environment {max(alone):.0f}, {count} on {workers} "
        f"processes {max(together):.0f}, {max(together) / max(alone):.2f} times as many"
    )


def play_alone(environment: Any, index: int, dice: Dice) -> int:
    """Take the steps of one environment of the vector; return how many."""
    _, info = environment.reset(seed=index)
    taken, over = 0, False
    for _ in range(STEPS):
        action = dice.one(index, info["action_mask"])
        if over:
            _, info = environment.reset()
            over = False
            continue
        _, _, terminated, truncated, info = environment.step(action)
        taken, over = taken + 1, terminated or truncated
    return taken


def _play(count: int, steps: int) -> None:
    vector, dice = _vector(count), Dice(count)
    _, _ = vector.reset(seed=0)
    outcomes: Counter[str] = Counter()
    while outcomes.total() < steps:
        masks = vector.action_masks()
        _, _, _, _, info = vector.step(dice.all(masks))
        told = info.get("_outcome", np.zeros(count, dtype=bool))
        outcomes.update(str(each) for each in np.array(info.get("outcome", []))[told])
    vector.close()
    found = ", ".join(f"{number} {outcome}" for outcome, number in outcomes.most_common())
    print(f"masked random play, {outcomes.total()} steps: {outcomes['refused']} refused; {found}")


def _learn(episodes: int, seeds: int) -> None:
    environment = gymnasium.make(IN_PIPE, mission=MISSION, reward=reward)
    one = environment.unwrapped
    assert isinstance(one, InPipe)
    actions = one.spaces.actions
    table = Table(len(actions), without=[actions.index(name) for name in WITHOUT])
    began_s = perf_counter()
    played = learn(environment, table, episodes)
    print(
        f"learnt from {episodes} episodes, {sum(each.steps for each in played)} steps, "
        f"{perf_counter() - began_s:.0f} s: {len(table)} situations, the first success was in "
        f"episode {next((i for i, each in enumerate(played, 1) if each.success), 0)}"
    )
    tried = [play(environment, table, FIRST_SEED + i, learns=False) for i in range(seeds)]
    print(f"by the table: {_summary(tried)}")
    environment.close()
    _print_thesis()
    usual = Counter(each.course for each in tried if each.success).most_common(1)
    if usual:
        _run(mission_of(usual[0][0], pirate_sm.load(MISSION), "learnt_bend"), seeds)


def _summary(tried: list[Played]) -> str:
    """Return how often the place was reached, and the most frequent commands."""
    reached = [each for each in tried if each.success]
    usual = Counter(tuple(each.commands) for each in reached).most_common(1)
    commands = f"{len(usual[0][0])} commands ({', '.join(usual[0][0])})" if usual else "never"
    time_s = sum(each.time_s for each in reached) / max(len(reached), 1)
    return f"{len(reached)} of {len(tried)} seeds reach it, in {time_s:.1f} s, by {commands}"


def _print_thesis() -> None:
    """Print the commands of the sequence of the thesis."""
    run = pirate_sm.run(MISSION)
    columns = zip(run.commands["name"], run.commands["status"], strict=True)
    names = [name for name, status in columns if status == "done"]
    found = f"{len(names)} commands ({', '.join(names)})"
    print(f"by the thesis: {run.outcome} in {run.duration_s:.1f} s, by {found}")


def _run(text: str, seeds: int) -> None:
    """Check and run the mission that was learnt."""
    print(text)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "learnt_bend.yaml"
        file.write_text(text, encoding="utf-8")
        findings = pirate_sm.check(file)
        print(f"as a mission: {len(findings)} findings")
        for finding in findings:
            print(f"  {finding}")
        options: dict[str, Any] = {"start_jitter_m": 0.01, "friction_jitter": 0.1, "check": False}
        mission = pirate_sm.load(file)
        runs = [pirate_sm.run(mission, seed=FIRST_SEED + seed, **options) for seed in range(seeds)]
    ends = Counter(run.outcome for run in runs)
    print(f"as a mission, {seeds} seeds: {dict(ends)}")


if __name__ == "__main__":
    sys.exit(main())
