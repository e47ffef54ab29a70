"""Robots whose motors are not those that the profile assumes, in the simulator."""

import pytest

from pirate_sm.core.effects import CommandStatus, Fault


@pytest.mark.parametrize("mission", ["mitre_bend", "enter_2d"])
@pytest.mark.parametrize("stall", ["0.70 Nm", "0.5 Nm", "2 Nm"])
def test_belief_in_a_clamp_needs_no_motor_as_strong_as_assumed(run, tmp_path, mission, stall):
    """The profile assumes 1.01 Nm; 500 mNm were asked for, and 0.70 Nm at 70 % are 490 mNm."""
    twin = tmp_path / "twin.yaml"
    motors = f"{{bend: {{stall_torque: {stall}}}}}"
    twin.write_text(f"format: 1\nrobot: pirate_ii\nmotors: {motors}\n", "utf-8")
    record = run(mission, backend="sim", twin=str(twin))
    assert record.ended.outcome == "succeeded", record.ended.message


def test_belief_in_a_clamp_at_its_end_stop_does_not_release_the_other(run, tmp_path):
    """The front of a robot whose joints turn faster comes to rest in the mouth of the bend."""
    twin = tmp_path / "twin.yaml"
    motors = "{bend: {no_load_speed: 1 rad/s}}"
    twin.write_text(f"format: 1\nrobot: pirate_ii\nmotors: {motors}\n", "utf-8")
    record = run("take_bend", backend="sim", seed=9501, twin=str(twin))
    assert record.ended.outcome == "failed"
    assert [fault.code for fault in record.of(Fault)] == ["clamp.lost"]
    assert "RelaxRear" not in [command.name for command in record.of(CommandStatus)]


def test_belief_in_a_time_limit_needs_no_motor_as_fast_as_assumed(run, tmp_path):
    """Three quarters of what the thesis's data sheets give at 6 V."""
    twin = tmp_path / "twin.yaml"
    motors = "{bend: {no_load_speed: 0.27 rad/s}}"
    twin.write_text(f"format: 1\nrobot: pirate_ii\nmotors: {motors}\n", "utf-8")
    record = run("mitre_bend", backend="sim", twin=str(twin))
    assert record.ended.outcome == "succeeded", record.ended.message
