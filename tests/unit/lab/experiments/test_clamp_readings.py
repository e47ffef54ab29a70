import pytest

from pirate_sm.lab.experiments.clamp_readings import chain_forces_n


def test_forces_of_a_chain_balance_and_bend_it_by_its_torques() -> None:
    torques, spans = [0.16, 1.92, 0.49, 0.24], [0.053, 0.053, 0.065, 0.053, 0.053]
    forces = [f * (-1) ** k for k, f in enumerate(chain_forces_n(torques, spans))]

    assert sum(forces) == pytest.approx(0)
    for joint, torque in enumerate(torques, start=1):
        moment = sum(f * sum(spans[k:joint]) for k, f in enumerate(forces[:joint]))
        assert abs(moment) == pytest.approx(torque)


def test_an_apex_alone_presses_its_wheel_twice_as_hard_as_its_neighbours() -> None:
    assert chain_forces_n([0.5], [0.05, 0.05]) == pytest.approx([10, 20, 10])
