from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import pirate_sm
from pirate_sm.lab.learning.environment import InPipe
from pirate_sm.lab.learning.rewards import Transition

from .conftest import act, drawn, made

INTO_THE_BEND = ("ClampFront", "ClampRear", "DriveForward")
NEWT = {"robot": "tests/robots/newt", "pipe": "straight_113"}


def shown(observation: Any) -> dict[str, Any]:
    return {name: np.asarray(value).tolist() for name, value in observation.items()}


def test_gymnasium_finds_no_fault_with_it() -> None:
    with made() as environment:
        check_env(environment.unwrapped)


def test_an_action_for_each_command_and_one_to_wait(environment: InPipe) -> None:
    commands = pirate_sm.load("mitre_bend").robot.table.commands

    assert environment.spaces.actions == (*commands, "wait")
    assert len(commands) == 14


def test_a_command_is_one_step(environment: InPipe) -> None:
    environment.reset(seed=1)
    observation, _, terminated, truncated, info = act(environment, "ClampFront")

    assert (info["command"], info["outcome"]) == ("ClampFront", "done")
    assert info["now_s"] > 1.0
    assert (terminated, truncated) == (False, False)
    assert environment.observation_space.contains(observation)


def test_a_wait_ends_after_half_a_second_or_with_a_word(environment: InPipe) -> None:
    environment.reset(seed=1)
    for name in INTO_THE_BEND:
        info = act(environment, name)[-1]
    waits = []
    for _ in range(20):
        before_s = info["now_s"]
        observation, _, _, _, info = act(environment, "wait")
        waits.append(info["now_s"] - before_s)
        if observation["word"]:
            break

    assert environment.spaces.words[observation["word"]] == "close"
    assert waits[:-1] == pytest.approx([0.5] * (len(waits) - 1))
    assert waits[-1] < 0.5


def test_masks_agree_with_what_is_refused() -> None:
    """Every action of a random play is tried, allowed or not."""
    lot = np.random.default_rng(4)
    told: set[tuple[bool, bool]] = set()
    environment = InPipe(time_limit_s=20.0)
    _, info = environment.reset(seed=4)
    for _ in range(40):
        action = int(lot.integers(len(environment.spaces.actions)))
        allowed = bool(environment.action_masks()[action])
        _, _, terminated, truncated, info = environment.step(action)
        told.add((allowed, info["outcome"] == "refused"))
        assert (info["reason"] != "") >= (info["outcome"] == "refused")
        if terminated or truncated:
            _, info = environment.reset()
    environment.close()

    assert told == {(True, False), (False, True)}


def test_equal_seeds_give_equal_episodes(environment: InPipe) -> None:
    courses = []
    for seed in (3, 3, 4):
        lot = np.random.default_rng(0)
        observation, info = environment.reset(seed=seed)
        course = [shown(observation)]
        for _ in range(5):
            observation, *_, info = environment.step(drawn(lot, info["action_mask"]))
            course.append(shown(observation))
        courses.append(course)

    assert courses[0] == courses[1]
    assert courses[0] != courses[2]


def test_a_place_beyond_the_pipe_is_refused() -> None:
    with (
        pytest.raises(pirate_sm.UsageError, match="99 m is not in the pipe"),
        made(reach_m=99.0) as one,
    ):
        one.reset(seed=1)


def test_a_place_is_reached() -> None:
    with made(reach_m=0.4, reward="reach") as environment:
        environment.reset(seed=1)
        for name in INTO_THE_BEND:
            act(environment, name)
        for _ in range(4):
            _, reward, terminated, truncated, info = act(environment, "wait")
            if terminated:
                break

    assert (terminated, truncated, info["success"]) == (True, False, True)
    assert reward == pytest.approx(1.0, abs=0.01)
    assert info["place_m"] >= 0.4


def test_time_is_up() -> None:
    with made(time_limit_s=1.2) as environment:
        _, info = environment.reset(seed=1)
        while True:
            _, _, terminated, truncated, info = act(environment, "wait")
            if truncated or terminated:
                break

    assert (terminated, truncated, info["success"]) == (False, True, False)
    assert info["now_s"] == pytest.approx(1.2)


def test_a_robot_that_comes_into_the_bend_out_of_its_plane_has_failed(environment: InPipe) -> None:
    environment.reset(seed=1)
    for name in ("ClampRear", "AlignRight", "DriveForward"):
        act(environment, name)
    for _ in range(20):
        _, reward, terminated, truncated, info = act(environment, "wait")
        if terminated:
            break

    assert (terminated, truncated, info["success"]) == (True, False, False)
    assert (info["outcome"], info["faults"]) == ("fault", ("pipe.impassable",))
    assert reward == pytest.approx(-1.0, abs=0.05)


def test_another_robot_and_its_own_commands() -> None:
    with made(**NEWT) as environment:
        observation, info = environment.reset(seed=0)

        assert environment.observation_space.contains(observation)
        assert environment.unwrapped.spaces.actions[-1] == "wait"  # type: ignore[attr-defined]
        assert info["action_mask"][-1] == 1
        assert "ClampFront" not in environment.unwrapped.spaces.actions  # type: ignore[attr-defined]


def test_a_reward_of_ones_own() -> None:
    steps: list[Transition] = []

    def reward(step: Transition) -> float:
        steps.append(step)
        return 7.0

    with made(reward=reward) as environment:
        environment.reset(seed=1)
        assert act(environment, "ClampRear")[1] == 7.0
    assert [step.command for step in steps] == ["ClampRear"]
    assert steps[0].after.now_s > steps[0].before.now_s


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"reward": "leest_slip"}, "there is no reward 'leest_slip': did you mean 'least_slip'?"),
        ({"missoin": "climb"}, "there is no option 'missoin': did you mean 'mission'?"),
        ({"mission": "mitre_bendd"}, "mitre_bend"),
        ({"defects": "weels_3_4_dead"}, "wheels_3_4_dead"),
        ({"time_limit_s": 0}, "time_limit_s: expected a number above 0, got 0"),
        ({"backend": "trace"}, "has no simulated robot"),
        ({**NEWT, "states": {}}, "states: name a mission"),
    ],
)
def test_what_does_not_fit_is_said_at_once(options: dict[str, Any], message: str) -> None:
    with pytest.raises(pirate_sm.UsageError, match=message.replace("?", r"\?")):
        InPipe(**options)


def test_a_step_needs_an_episode(environment: InPipe) -> None:
    with pytest.raises(pirate_sm.UsageError, match="reset the environment"):
        environment.step(0)
