"""Takes samples of a prepared run: for viewers, or to keep what its inputs do not give again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING, TypeAlias

from pirate_sm.core.engine import EngineState
from pirate_sm.core.geometry import Place
from pirate_sm.core.simulation import InSpace, Stood, Trail
from pirate_sm.running.wiring.prepared import Prepared

if TYPE_CHECKING:
    from pirate_sm.running.recording.format.samples import PlacesSample
    from pirate_sm.running.recording.write.gathered import Pictured, PlacesOfTrail, Sample
    from pirate_sm.running.recording.write.sampler import Look, LookBack

State: TypeAlias = Callable[[], EngineState | None]
"""Returns the engine's state; None before it has started."""


def samples_for_viewers(prepared: Prepared, state: State) -> Look[Sample]:
    """Return a function that takes samples with everything that viewers are shown."""
    from pirate_sm.running.recording.viewers.viewer_messages import ViewerSnapshot
    from pirate_sm.running.recording.write.gathered import Sample

    numbers = prepared.engine.numbers

    def look(now_s: float, stood: Stood | None) -> Sample | None:
        now = state()
        if now is None:
            return None
        camera = prepared.camera() if prepared.camera else None
        places, known = _wheels(prepared, stood)
        beside = _space(prepared, stood), _rolls(prepared, stood)
        return Sample(now_s, ViewerSnapshot(now, numbers(now), places, known, camera, *beside))

    return look


def samples_to_keep(prepared: Prepared, state: State) -> Look[PlacesSample | Pictured]:
    """Return a function that takes samples of what the run's inputs do not give again."""
    from pirate_sm.running.recording.format.samples import PlacesSample, places_sample
    from pirate_sm.running.recording.viewers.wheel_places import WheelPlacing
    from pirate_sm.running.recording.write.gathered import Pictured

    true, camera = prepared.wheels, prepared.camera
    if true is not None and camera is None and prepared.in_space is None:
        # Nearly every run at full speed.
        return lambda now_s, stood: (
            places_sample(now_s, True, true(), None, _rolls(prepared, None))
            if stood is None
            else PlacesSample(now_s, True, stood.places_m, (), stood.space.rolls_rad)
        )
    loaded = prepared.loaded
    robot = loaded.loaded_robot.profile, loaded.robot
    placing = WheelPlacing(*robot, loaded.pipe, prepared.order.start_at_m)

    def look(now_s: float, stood: Stood | None) -> PlacesSample | Pictured | None:
        now = state()
        if now is None:
            return None
        places, known = _wheels(prepared, stood)
        taken = places or placing.look(now, now_s) or ()
        beside = _space(prepared, stood), _rolls(prepared, stood)
        sample = places_sample(now_s, known, taken, *beside)
        seen = camera() if camera else None
        return sample if seen is None else Pictured(sample, seen)

    return look


def samples_of_trails(prepared: Prepared) -> LookBack[PlacesOfTrail] | None:
    """Return a function that takes samples to keep, of steps that were taken at once.

    It is None if such samples need more than where the robot was.
    """
    from pirate_sm.running.recording.format.samples import PlacesSample
    from pirate_sm.running.recording.write.gathered import PlacesOfTrail

    if prepared.wheels is None or prepared.camera is not None:
        return None
    flat = prepared.in_space is None

    def look_back(times_s: Sequence[float], trail: Trail) -> PlacesOfTrail:
        def samples(kept: Sequence[PlacesOfTrail]) -> Iterator[PlacesSample]:
            columns = trail.read([each.noted for each in kept])
            all_s = chain.from_iterable(each.times_s for each in kept)
            for at_s, places_m, z_m, rolls_rad in zip(all_s, *columns, strict=True):
                if flat:
                    yield PlacesSample(at_s, True, places_m, (), rolls_rad)
                else:
                    yield PlacesSample(at_s, True, places_m, (*z_m, *rolls_rad))

        return PlacesOfTrail(times_s, trail.noted(times_s), samples)

    return look_back


def _wheels(prepared: Prepared, stood: Stood | None) -> tuple[tuple[Place, ...] | None, bool]:
    """Return where the wheels are, None if nobody knows; and whether that is true."""
    if prepared.wheels is not None:
        return prepared.wheels() if stood is None else stood.wheels, True
    taken = prepared.reckoned() if prepared.reckoned else None
    return (taken.wheels if taken else None), False


def _space(prepared: Prepared, stood: Stood | None) -> InSpace | None:
    """Return what the wheels' places leave out of a robot in space; None if nobody knows."""
    if prepared.in_space is not None:
        return prepared.in_space() if stood is None else stood.space
    taken = prepared.reckoned() if prepared.reckoned else None
    return InSpace(taken.z_m, taken.rolls_rad) if taken is not None and taken.z_m else None


def _rolls(prepared: Prepared, stood: Stood | None) -> tuple[float, ...]:
    """Return the rolls of a simulated robot that moves in a plane; empty for any other one."""
    if prepared.rolls is None:
        return ()
    return prepared.rolls() if stood is None else stood.space.rolls_rad
