"""The serial link of a robot: topics, message types, layout and timing."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, StringConstraints, model_validator

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
        hold: Field with one bit per slot, the lowest for slot 0: set where the firmware's dead
            man's switch keeps the value, clear where it writes 0. The name of the id's field:
            these are the upper bits of the id. Empty: the message has none.
    """

    topic: str
    type: TypeName
    id: Name = "id"
    values: Name = "setpoints"
    hold: Name | Literal[""] = ""


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
        echo_within: An array not echoed for this long is sent again.
        recover_within: A controller that has fallen silent, or whose port has gone, must be back
            within so long beyond the boot loader's time; then the link is lost.
        refresh_every: The array in force is written again when nothing else has been written for
            so long, sooner on a line that loses frames. Without it nothing is repeated.
        stop_after: The firmware has a dead man's switch: without a valid array for this long it
            stops every slot that is not to be held. Without it the firmware has no switch.
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
