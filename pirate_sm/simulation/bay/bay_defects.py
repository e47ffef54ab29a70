"""The defects that an emulated bay can have, and their random numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from pirate_sm.core.errors import UsageError
from pirate_sm.core.models import Defect, Kind
from pirate_sm.simulation.defects import AtWork

Topic = Literal["state", "echo", "setpoints"]
TOPICS: tuple[Topic, ...] = ("state", "echo", "setpoints")

RING = 64
"""Bytes that the controller buffers for a busy firmware."""


@dataclass(frozen=True)
class Switches:
    """Which defects are switched on; none by default. Times are seconds since the bay started.

    Attributes:
        loss_in: Share of frames lost on their way to the bay.
        loss_out: Share of frames lost on their way to the host.
        never_two: One of two consecutive frames of a topic always arrives (thesis 4-2-2). The
            shares still hold, so at most half of the frames can be lost.
        corruption: Share of bytes changed, in either direction.
        delay_s: Added delay of every frame, in either direction.
        jitter_s: Up to this much more delay, drawn uniformly per frame; the order stays.
        cut_at_s: When the line is cut for good, so that nothing passes either way.
        reset_at_s: When the firmware restarts.
        reset_every_s: Mean time between further restarts, 0 for none.
        hang_at_s: When the firmware hangs.
        hang_for_s: How long it hangs.
        boot_s: How long boot loader and set-up take after a restart; None: drawn anew each time
            between three quarters and the whole of the profile's time.
        ring: Bytes that can wait for the firmware; None: no limit and no overrun.
        poll_s: How often the firmware reads bytes; None: in the idle case of each cycle.
        stale_every_s: Mean time between spells in which boards repeat their values, 0 for none.
        stale_for_s: How long such a spell lasts.
        wrong_md5: Topics that are announced with the md5 of another definition.
        unconfigured_at_s: When the firmware forgets that it was configured: it obeys setpoints
            but neither echoes nor publishes until the host asks for its topics.
        no_echo_at_s: When it stops echoing; it still obeys and publishes.
        spontaneous_at_s: When a motor moves without a command.
        spontaneous_every_s: Mean time between further such motions, 0 for none.
        motors_started: Whether the actuators were started on the panel ([Play], thesis App. D);
            if not, setpoints are echoed and motors ignore them.
        sensors_started: Whether the sensors were started ([Set]); if not, no board reports.
        old_client: The client of 2014 to 2017, which is unconfigured after an overrun.
        dead_man: Whether the firmware has the dead man's switch that the profile describes.
        defects: Defects of the profile, as text with their numbers.
    """

    loss_in: float = 0.0
    loss_out: float = 0.0
    never_two: bool = False
    corruption: float = 0.0
    delay_s: float = 0.0
    jitter_s: float = 0.0
    cut_at_s: float = math.inf
    reset_at_s: tuple[float, ...] = ()
    reset_every_s: float = 0.0
    hang_at_s: float = math.inf
    hang_for_s: float = math.inf
    boot_s: float | None = None
    ring: int | None = RING
    poll_s: float | None = None
    stale_every_s: float = 0.0
    stale_for_s: float = 0.1
    wrong_md5: tuple[Topic, ...] = ()
    unconfigured_at_s: tuple[float, ...] = ()
    no_echo_at_s: float = math.inf
    spontaneous_at_s: tuple[float, ...] = ()
    spontaneous_every_s: float = 0.0
    motors_started: bool = True
    sensors_started: bool = True
    old_client: bool = False
    dead_man: bool = True
    defects: tuple[str, ...] = ()

    def more_defects(self, seed: int, chances: Sequence[np.random.Generator]) -> list[AtWork]:
        """Return the switched-on defects that a profile can name as well.

        Args:
            seed: Seed of the spells of repeated values.
            chances: Random numbers for motions, for restarts and for the times of motions.
        """
        motions, restarts, moments = chances
        spells = np.random.default_rng((seed, len(self.defects)))
        found = [
            *(_at_work("controller_reset", restarts, after=at_s) for at_s in self.reset_at_s),
            *(_at_work("stray_motion", motions, after=at_s) for at_s in self.spontaneous_at_s),
        ]
        if self.stale_every_s:
            every_s, for_s = self.stale_every_s, self.stale_for_s
            found.append(_at_work("stale_repeats", spells, every=every_s, lasting=for_s))
        if self.reset_every_s:
            found.append(_at_work("controller_reset", restarts, every=self.reset_every_s))
        if self.spontaneous_every_s:
            found.append(_at_work("stray_motion", moments, every=self.spontaneous_every_s))
        if self.hang_at_s < math.inf and self.hang_for_s:
            # A lasting defect has no duration.
            for_s = self.hang_for_s if self.hang_for_s < math.inf else 0.0
            found.append(_at_work("controller_hang", moments, after=self.hang_at_s, lasting=for_s))
        return found

    def __post_init__(self) -> None:
        most = 0.5 if self.never_two else 1.0
        for name, limit in (("loss_in", most), ("loss_out", most), ("corruption", 1.0)):
            if not 0.0 <= getattr(self, name) <= limit:
                raise UsageError(f"{name} is a share between 0 and {limit:.0%}")
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name.endswith("_s") and value is not None:
                times = value if isinstance(value, tuple) else (value,)
                if not all(each >= 0.0 for each in times):
                    raise UsageError(f"{field.name} cannot be negative")
        if self.ring is not None and self.ring < 1:
            raise UsageError("ring is at least 1 byte")
        if self.poll_s is not None and not self.poll_s > 0.0:
            raise UsageError("poll_s must be more than 0")


def _at_work(
    kind: Kind,
    rng: np.random.Generator,
    after: float = 0.0,
    every: float = 0.0,
    lasting: float = 0.0,
) -> AtWork:
    text = "a switch of the bay"
    return Defect(kind=kind, description=text, after=after, every=every, lasting=lasting), rng


class Corruption:
    """Changes random bytes.

    Args:
        share: Share of bytes to change.
        rng: Random numbers.
    """

    def __init__(self, share: float, rng: np.random.Generator) -> None:
        self._share = share
        self._rng = rng
        self._spared = self._gap()

    def _gap(self) -> int:
        """Return how many bytes pass before the next one is changed."""
        return int(self._rng.geometric(self._share)) - 1 if self._share > 0.0 else 0

    def damage(self, data: bytes) -> bytes:
        """Return the bytes as they arrive."""
        if self._share == 0.0:
            return data
        changed = bytearray(data)
        while self._spared < len(changed):
            changed[self._spared] ^= int(self._rng.integers(1, 256))
            self._spared += 1 + self._gap()
        self._spared -= len(changed)
        return bytes(changed)
