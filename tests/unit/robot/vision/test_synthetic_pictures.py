"""Synthetic pictures: repeatable, and with the light and the errors that were asked for."""

from __future__ import annotations

import numpy as np
import pytest

from .small_setup import GREEN, drawn, scene

CLEAN = {"noise": 0, "blur": 0, "jpeg": 0}


def test_the_same_number_and_seed_give_the_same_picture() -> None:
    _, pictures = drawn()
    _, again = drawn()
    first = pictures.picture(scene(), 3, seed=1)

    assert np.array_equal(first, again.picture(scene(), 3, seed=1))
    assert not np.array_equal(first, pictures.picture(scene(), 4, seed=1))
    assert not np.array_equal(first, pictures.picture(scene(), 3, seed=2))


def test_without_noise_all_pictures_of_a_scene_are_the_same() -> None:
    _, pictures = drawn(camera=CLEAN)

    assert np.array_equal(pictures.picture(scene(), 0), pictures.picture(scene(), 1))


def test_half_the_light_makes_half_as_bright() -> None:
    whole, half = (drawn(light={"gain": g}, camera=CLEAN)[1].picture(scene(), 0) for g in (1, 0.5))

    assert half.mean() == pytest.approx(whole.mean() / 2, rel=0.02)


def test_a_warm_lamp_makes_it_redder_and_a_cold_one_bluer() -> None:
    ratios = []
    for lamp in ("warm", "neutral", "cold"):
        blue, _, red = drawn(light={"lamp": lamp}, camera=CLEAN)[1].picture(scene(), 0).mean((0, 1))
        ratios.append(red / blue)

    assert ratios[0] > 1.5 * ratios[1] > 1.5 * 1.3 * ratios[2]


def test_uneven_light_is_darker_on_the_right() -> None:
    even, uneven = (
        drawn(light={"uneven": u}, camera=CLEAN)[1].picture(scene(), 0).astype(float)
        for u in (0, 0.6)
    )
    left, right = (
        uneven[:, part].mean() / even[:, part].mean() for part in (slice(80), slice(-80, None))
    )

    assert left > 0.8
    assert right < 0.6


def test_noise_has_the_asked_strength() -> None:
    clean, noisy = (
        drawn(camera=CLEAN | {"noise": n})[1].picture(scene(), 0).astype(float) for n in (0, 6)
    )

    assert (noisy - clean).std() == pytest.approx(6, rel=0.1)


def test_what_moves_while_the_shutter_is_open_is_smeared_and_what_stands_is_not() -> None:
    _, pictures = drawn(GREEN, camera=CLEAN)
    still = pictures.picture(scene(), 0).astype(int)
    smeared = pictures.picture(scene(), 0, before=scene(x=0.03)).astype(int)
    changed = np.abs(still - smeared).max(axis=2) > 8

    assert changed.sum() > 200
    across = np.nonzero(changed.any(axis=0))[0]
    assert across.max() - across.min() < 400  # only around the robot


def test_the_robots_lamps_shine_ahead_of_it() -> None:
    dark, lit = (
        drawn(light={"glare": g}, camera=CLEAN)[1].picture(scene(), 0) for g in (False, True)
    )
    eye, _ = drawn()
    u, v = np.round(eye.view.project(np.array([[0.1, 0.02, 0.04]]))[0]).astype(int)

    assert lit[v, u].min() > 250
    assert dark[v, u].max() < 200


def test_a_clear_pipe_changes_what_is_in_it_alone() -> None:
    air, pvc = (drawn(through=t, camera=CLEAN)[1].picture(scene(), 0) for t in ("air", "pvc"))
    eye, _ = drawn()
    inside, outside = np.round(
        eye.view.project(np.array([[0.1, 0, 0.0], [0.0, -0.2, 0.0]]))
    ).astype(int)

    assert (pvc[inside[1], inside[0]] != air[inside[1], inside[0]]).any()
    assert (pvc[outside[1], outside[0]] == air[outside[1], outside[0]]).all()
