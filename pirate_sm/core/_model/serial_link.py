"""The serial link of a robot: topics, message types, layout and timing."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints, model_validator

from pirate_sm.core._model.base import Frozen, Name
from pirate_sm.core._model.quantities import Count, Duration

TypeName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z]\w*/[A-Za-z]\w*$")]
"""A ROS message type as on the wire, ``package/Type``."""


class SetpointTopic(Frozen):
    """A topic that carries a whole array of setpoints, or its echo.

    Attributes:
        topic: Name of the topic.
        type: Its message type, ``package/Type``.
        id: Field with the id of the array.
        values: Field with one integer per slot.
        hold: Field with one bit per slot, the lowest for slot 0: set if the firmware's dead man's
            switch keeps the slot's value, clear if it writes 0. If it is the id's field, these are
            the upper bits of the id. Empty: the message has no such bits.
    """

    topic: str
    type: TypeName
    id: Name = "id"
    values: Name = "setpoints"
    hold: Name | Literal[""] = ""


class StateTopic(Frozen):
    """The topic with the measurements of the boards.

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
    """Advice for problems that no message of the link reports; empty where there is none.

    Attributes:
        no_motion: Advice if motors ignore setpoints.
        no_sensors: Advice if no board reports.
        motor_error: Advice if one motor does not move.
    """

    no_motion: str = ""
    no_sensors: str = ""
    motor_error: str = ""


class Serial(Frozen):
    """The serial link to the robot, rosserial protocol revision 1.

    Attributes:
        baud: Baud rate of the port.
        boot: Longest duration of the boot loader after the port is opened.
        echo_within: An array not echoed for this long is sent again.
        recover_within: The link is lost if a silent controller or a missing port is not back within
            this time after the boot loader's time.
        refresh_every: The array in force is written again if nothing else was written for this
            long, earlier on a lossy line. Without this key nothing is repeated.
        stop_after: The firmware's dead man's switch stops every slot without a hold bit after this
            time without a valid array. Without this key the firmware has no such switch.
        heartbeat_within: The guardian sends the safe array after this time without a message from
            the runner.
        messages: Folder in the robot's folder with one ``<Type>.msg`` per message type.
        setpoints: The topic for arrays of setpoints.
        echo: The topic on which the controller repeats each accepted array.
        state: The topic with the measurements of the boards.
        advice: Advice for problems that no message reports.
    """

    baud: Annotated[Count, Field(gt=0)]
    boot: Duration
    echo_within: Annotated[Duration, Field(gt=0)]
    recover_within: Annotated[Duration, Field(gt=0)] = 6.0
    refresh_every: Annotated[Duration, Field(gt=0)] | None = None
    stop_after: Annotated[Duration, Field(gt=0)] | None = None
    heartbeat_within: Annotated[Duration, Field(gt=0)]
    messages: str = "messages"
    setpoints: SetpointTopic
    echo: SetpointTopic
    state: StateTopic
    advice: Advice = Advice()

    @model_validator(mode="after")
    def _refreshed_in_time(self) -> Serial:
        if self.stop_after is None:
            return self
        if self.refresh_every is None:
            raise ValueError(
                "'stop_after' needs 'refresh_every': without repeats the firmware's switch stops "
                "the robot whenever a mission waits"
            )
        if 2 * self.refresh_every > self.stop_after:
            raise ValueError(
                f"'refresh_every' is {self.refresh_every:g} s and 'stop_after' "
                f"{self.stop_after:g} s: at least two repeats must fit, or one lost frame stops "
                "the robot"
            )
        return self
