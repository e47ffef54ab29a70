"""Settings of a synthetic camera: the light, the view and the errors of its pictures."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pirate_sm.core._model.base import Frozen
from pirate_sm.core._model.quantities import Count, Duration, Length, Ratio

LampColour = Literal["neutral", "warm", "cold"]


class Lighting(Frozen):
    """The light on the setup.

    Attributes:
        gain: Brightness of the picture; 1 is well exposed, more than 1.5 overexposed.
        lamp: Colour of the lamp; the camera's white balance stays as for ``neutral``.
        uneven: How much darker the picture is at its darkest edge than at its brightest.
        glare: Whether the robot's own lamps shine on the pipe.
    """

    gain: Annotated[Ratio, Field(gt=0, le=10)] = 1.0
    lamp: LampColour = "neutral"
    uneven: Annotated[Ratio, Field(ge=0, lt=1)] = 0.25
    glare: bool = False


class Imperfections(Frozen):
    """The errors of a camera.

    Attributes:
        noise: Standard deviation of the noise of each pixel, of 255.
        blur: Standard deviation of the blur of the lens, in pixels.
        shutter: How long the shutter is open; what moves is smeared.
        jpeg: Quality of the JPEG compression, 100 for the best; 0 for none.
        lost: Share of frames that are lost.
    """

    noise: Annotated[float, Field(ge=0, le=50)] = 3.0
    blur: Annotated[float, Field(ge=0, le=20)] = 0.6
    shutter: Annotated[Duration, Field(ge=0, le=1)] = 0.01
    jpeg: Annotated[Count, Field(le=100)] = 90
    lost: Annotated[Ratio, Field(ge=0, lt=1)] = 0.0


class Hand(Frozen):
    """Something that covers a part of the picture, such as a hand.

    Attributes:
        at: Where its middle is in the plane of the setup.
        size: Its diameter.
    """

    at: tuple[Length, Length]
    size: Annotated[Length, Field(gt=0)]


class SyntheticView(Frozen):
    """A camera that draws its pictures from the truth of the simulator.

    Attributes:
        light: The light on the setup.
        camera: The errors of the camera.
        through: What the robot is seen through: ``air`` between open walls, or ``pvc``, a clear
            pipe with reflections.
        hides: What covers a part of the picture.
        seed: Of noise and lost frames, beside the seed of the run.
    """

    light: Lighting = Lighting()
    camera: Imperfections = Imperfections()
    through: Literal["air", "pvc"] = "air"
    hides: tuple[Hand, ...] = ()
    seed: Count = 0
