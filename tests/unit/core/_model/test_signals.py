"""Kinds of derived signals and limits that are written wrongly are refused where they are made."""

from __future__ import annotations

from typing import ClassVar

import pytest

from pirate_sm.core._model.robot.limits import Limit
from pirate_sm.core._model.robot.signals import DerivedSignal, SignalRow


@pytest.mark.parametrize(
    ("operation", "sources", "slot", "constants"),
    [
        ("norm", ("a", "b", "c", "d"), "", ()),
        ("norm", (), "", ()),
        ("roll", ("x", "y"), "", ()),
        ("torque", ("current",), "", ("1 Nm/A",)),
        ("torque", ("current",), "wheel", ()),
        ("diameter", ("apex",), "", (0.09,)),
        ("rate", ("angle",), "wheel", ()),
    ],
)
def test_an_operation_takes_neither_more_nor_fewer_operands(operation, sources, slot, constants):
    with pytest.raises(TypeError, match=f"'{operation}' does not take these operands"):
        SignalRow(operation, sources, slot, constants)


@pytest.mark.parametrize(("of", "operation"), [("parts", "diameter"), ("signals", "mean")])
def test_a_signal_is_made_by_a_known_operation_of_signals_alone(of, operation):
    with pytest.raises(TypeError, match=r"HeightOf needs rows\(\)"):

        class HeightOf(DerivedSignal):
            OF: ClassVar = of
            OPERATION: ClassVar = operation

            height_of: str


def test_a_limit_is_a_multiple_of_a_number_that_motors_have():
    with pytest.raises(TypeError, match="motors have no number 'stall_curent'"):
        Limit("rate", "current", "stall_curent")
