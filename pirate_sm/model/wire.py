"""How a robot speaks over its serial port: topics, message types, layout and timing."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints

from pirate_sm.model.base import Frozen, Name
from pirate_sm.model.quantities import Count, Duration

TypeName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z]\w*/[A-Za-z]\w*$")]
"""A ROS message type as it stands on the wire, ``package/Type``."""


class SetpointTopic(Frozen):
    """A topic that carries a whole array of setpoints, or its echo.

    Attributes:
        topic: Name of the topic.
        type: Its message type, ``package/Type``.
        id: Field with the array's id.
        values: Field with one integer per slot.
    """

    topic: str
    type: TypeName
    id: Name = "id"
    values: Name = "setpoints"


class StateTopic(Frozen):
    """The topic that carries what the boards measure.

    Attributes:
        topic: Name of the topic.
        type: Its message type, ``package/Type``.
        layout: ``board``: all channels of one board in ``values``. ``value``: one ``value`` of one
            ``channel``.
        board: Field with the board's id.
        channel: Field with the channel's number.
        values: Field with the values of all channels of a board.
        value: Field with the value of one channel.
    """

    topic: str
    type: TypeName
    layout: Literal["board", "value"]
    board: Name = "board"
    channel: Name = "channel"
    values: Name = "values"
    value: Name = "value"


class Advice(Frozen):
    """What a person can do about what no message of the link tells; empty where unknown.

    Attributes:
        no_motion: When motors ignore setpoints.
        no_sensors: When no board reports.
        motor_error: When one motor does not move.
    """

    no_motion: str = ""
    no_sensors: str = ""
    motor_error: str = ""


class Serial(Frozen):
    """The serial link to the robot, rosserial protocol revision 1.

    Attributes:
        baud: Rate of the port.
        boot: How long the boot loader may take after the port has been opened.
        echo_within: An array not echoed for so long is sent again.
        recover_within: A controller that has fallen silent, or whose port has gone, must be back
            within so long beyond the boot loader's time; then the link is lost.
        heartbeat_within: The guardian sends the safe array when it has not heard the runner for so
            long.
        messages: Folder beside the profile with one ``<Type>.msg`` per type.
        setpoints: The topic that takes arrays of setpoints.
        echo: The topic that repeats an array that was taken over.
        state: The topic that carries what the boards measure.
        advice: What a person can do about what no message tells.
    """

    baud: Annotated[Count, Field(gt=0)]
    boot: Duration
    echo_within: Annotated[Duration, Field(gt=0)]
    recover_within: Annotated[Duration, Field(gt=0)] = 6.0
    heartbeat_within: Annotated[Duration, Field(gt=0)]
    messages: str = "messages"
    setpoints: SetpointTopic
    echo: SetpointTopic
    state: StateTopic
    advice: Advice = Advice()
