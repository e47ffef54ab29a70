"""Every event and effect comes back from a recording as it was, bit by bit."""

from __future__ import annotations

import json
import struct
from typing import Any, get_args

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pirate_sm.core.effects import Effect, Setpoints, WakeAt
from pirate_sm.core.events import Event, SensorFrame, Tick
from pirate_sm.running.recording.format.engine_topics import Abandoned, Started, Topics, WireLayout

LAYOUT = WireLayout(
    {7: ("angle", "load"), 8: ("angle", "angle", "load")}, (("a", "duty"), ("b", "angle"))
)
TOPICS = Topics(LAYOUT)
INPUTS = (*get_args(Event), Started, Abandoned)
EVERYTHING = (*INPUTS, *get_args(Effect))


def bits(value: Any) -> Any:
    """The value with each float as its bits; all NaN are one."""
    if isinstance(value, float):
        return "nan" if value != value else struct.pack("<d", value)  # noqa: PLR0124
    if isinstance(value, tuple):
        return type(value).__name__, tuple(map(bits, value))
    return type(value).__name__, value


def topic_of(made: Any) -> Any:
    return TOPICS.of_input(made) if isinstance(made, INPUTS) else TOPICS.of_effect(made)


def row_of(topic: Any, made: Any, step: int) -> tuple[Any, ...]:
    return (step, step / 3, made) if topic.is_input else (step, step / 3, 2, made)


@pytest.mark.parametrize("kind", EVERYTHING, ids=lambda kind: kind.__name__)
@settings(max_examples=settings.default.max_examples // 2)
@given(data=st.data())
def test_everything_comes_back_as_it_was(kind: type[Any], data: st.DataObject) -> None:
    made = data.draw(st.lists(st.from_type(kind), min_size=1, max_size=4))
    topic = TOPICS.by_name[topic_of(made[0]).name]
    made = [each for each in made if topic_of(each) is topic]
    rows = [row_of(topic, each, step) for step, each in enumerate(made)]

    written = topic.encode(rows)

    jsonschema.validate(json.loads(written), topic.schema)
    place = 0 if topic.is_input else 2
    expected = [(step, step / 3, place, bits(each)) for step, each in enumerate(made)]
    assert [(*row[:3], bits(row[3])) for row in topic.decode(written)] == expected


@given(st.lists(st.tuples(st.floats(), st.floats()), min_size=1))
def test_frames_of_a_known_board_have_a_column_for_each_channel(
    values: list[tuple[float, float]],
) -> None:
    frames = [SensorFrame(7, each) for each in values]
    topic = TOPICS.of_input(frames[0])
    written = topic.encode([(step, 0.0, frame) for step, frame in enumerate(frames)])

    batch = json.loads(written)

    jsonschema.validate(batch, topic.schema)
    assert list(batch["values"]) == ["angle_raw", "load_raw"]
    assert [bits(row[3]) for row in topic.decode(written)] == [bits(each) for each in frames]


def test_whole_numbers_stay_whole() -> None:
    frame = SensorFrame(7, (5, 5.0))
    topic = TOPICS.of_input(frame)
    (row,) = topic.decode(topic.encode([(0, 0.0, frame)]))

    assert [type(value) for value in row[3].values] == [int, float]


def test_setpoints_have_columns_with_units() -> None:
    setpoints = Setpoints(3, (0.5, 1.5))
    batch = json.loads(TOPICS.of_effect(setpoints).encode([(4, 0.25, 0, setpoints)]))

    assert batch == {
        "step": [4], "t_s": [0.25], "nth": [0], "setpoint_id": [3],
        "values": {"a_duty": [0.5], "b_rad": [1.5]},
    }  # fmt: skip


@pytest.mark.parametrize("event", [SensorFrame(7, (1.0,)), SensorFrame(9, (1.0, 2.0))])
def test_a_frame_that_fits_no_board_is_kept_all_the_same(event: SensorFrame) -> None:
    topic = TOPICS.of_input(event)
    (row,) = topic.decode(topic.encode([(0, 0.0, event)]))

    assert row[3] == event


def test_channels_of_one_name_are_told_apart() -> None:
    assert TOPICS.of_input(SensorFrame(8, (1.0, 2.0, 3.0))).names == (
        "angle_raw", "angle_raw_1", "load_raw",
    )  # fmt: skip


def test_no_field_hides_a_column_that_every_row_has() -> None:
    for topic in TOPICS.by_name.values():
        assert not {name for name, _ in topic.fields} & set(topic.keys)


def test_schemas_are_valid() -> None:
    for topic in TOPICS.by_name.values():
        jsonschema.Draft202012Validator.check_schema(topic.schema)


@pytest.mark.parametrize(
    "batch",
    [
        b"",
        b"{}",
        b"[]",
        b'{"step":[0],"t_s":[0.0]}',
        b'{"step":["0"],"t_s":[0.0],"nth":[0],"at_s":[1.0]}',
        b'{"step":[0],"t_s":[0.0],"nth":[0],"at_s":["soon"]}',
        b'{"step":[0],"t_s":[0.0],"nth":[0],"at_s":[true]}',
        b'{"step":[0,1],"t_s":[0.0],"nth":[0],"at_s":[1.0]}',
        b'{"step":3,"t_s":[0.0],"nth":[0],"at_s":[1.0]}',
    ],
)
def test_a_batch_of_another_form_is_refused(batch: bytes) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - of whatever kind
        list(TOPICS.by_name["/engine/out/WakeAt"].decode(batch))


def test_events_without_fields_need_only_their_place() -> None:
    topic = TOPICS.of_input(Tick())

    assert [row[0] for row in topic.decode(topic.encode([(3, 0.0, Tick()), (5, 1.0, Tick())]))] == [
        3,
        5,
    ]


def test_infinity_is_told_from_unknown() -> None:
    topic = TOPICS.of_effect(WakeAt(1.0))
    rows = [(n, 0.0, 0, WakeAt(value)) for n, value in enumerate((float("inf"), float("nan")))]

    assert json.loads(topic.encode(rows))["at_s"] == ["inf", None]
