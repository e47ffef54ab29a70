import pytest

from pirate_sm.lab.experiments.reduced_kernel import friction_coefficient


@pytest.mark.parametrize(
    ("slip_m_s", "expected"),
    [
        (0.0, 0.0),
        (0.0005, 0.35),
        (0.001, 0.7),
        (-0.001, 0.7),
        (0.00125, 0.6),
        (0.0015, 0.5),
        (0.2, 0.5),
    ],
)
def test_friction_rises_to_static_falls_to_kinetic_and_stays(
    slip_m_s: float, expected: float
) -> None:
    assert friction_coefficient(slip_m_s, 0.7, 0.5, 0.001) == pytest.approx(expected)
