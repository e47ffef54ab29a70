"""Odometry: the distance travelled, and the detector that reports words and joints by it.

The distance is the median of what the wheels of the holding part have rolled. In a bend, single
wheels slip and roll up to twice as far as the robot moves. The wheels of one clamped part all move
alike, so the median ignores one of three that slips. The median is taken over short pieces of the
way, since another wheel may slip next. Wheels that the engine does not believe, such as dead ones,
are not counted; where it believes none of the part, those of the other count.

A driven wheel that last reported 0.3 s ago is 3 cm farther. This distance is added up from its last
known speed, but conservatively: not once its board counts as silent; not after the command to stop;
and no faster than the wheel that reported last, which shows when the whole robot has slowed down or
stands. What has been added stays until the wheel reports, so that positions do not jump back.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence
from dataclasses import replace
from math import inf, isnan, nan, radians
from statistics import median

from pirate_sm.core.companion import CompanionBase
from pirate_sm.core.effects import CommandStatus, Effect, Log, Setpoints, StateChange
from pirate_sm.core.engine import EngineState
from pirate_sm.core.errors import UsageError
from pirate_sm.core.events import BuiltInFault, Event, FaultReport, Truth
from pirate_sm.core.geometry import drawn_walls
from pirate_sm.core.models import Pipe, Profile
from pirate_sm.core.robot import RobotSpec, confirmed_parts
from pirate_sm.core.sensing import WHOLE
from pirate_sm.robot.detectors.dead_reckoning import Felt, Reckoned, Reckoner, Shape
from pirate_sm.robot.detectors.route_report import RouteReport
from pirate_sm.robot.detectors.word_timing import LOOK_EVERY_S, WordDetector, words_of


class Rolling:
    """Follows the wheels from one look to the next.

    Args:
        robot: The robot with the wheels.
    """

    def __init__(self, robot: RobotSpec) -> None:
        count = len(robot.wheels)
        self._robot = robot
        self._now_s = -inf
        self._heard_s, self._rolled_m = [nan] * count, [nan] * count

    def look(self, state: EngineState, now_s: float) -> tuple[float, ...]:
        """Return how far each wheel has rolled since its last report, m; backward is negative.

        Args:
            state: The engine's state; a wheel is driven if the setpoints in force and the newest
                ones both drive it.
            now_s: Time, not earlier than in any earlier call.
        """
        robot, sensing = self._robot, state.sensing
        in_force, newest = state.robot.values, state.robot.latest
        robots = self._freshest(state)
        for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True):
            place, heard_s = wheel.place, sensing.heard_s[position]
            if heard_s != self._heard_s[place]:
                self._heard_s[place], self._rolled_m[place] = heard_s, 0.0
            if in_force[wheel.slot] and newest[wheel.slot]:
                speed = _slower(sensing.numbers[wheel.speed] * wheel.metres_per_rad, robots)
                until_s = min(now_s, heard_s + robot.link.silent_after_s)
                lasting_s = max(0.0, until_s - max(self._now_s, heard_s))
                self._rolled_m[place] += speed * lasting_s
        self._now_s = now_s
        return tuple(self._rolled_m)

    def _freshest(self, state: EngineState) -> float:
        """Return the speed of the driven wheel that reported last, m/s; 0 if none is known."""
        robot, sensing = self._robot, state.sensing
        last_s, found = -inf, 0.0
        for wheel, position in zip(robot.wheels, robot.wheel_boards, strict=True):
            if sensing.shares[wheel.place] and sensing.heard_s[position] > last_s:
                speed = sensing.numbers[wheel.speed] * wheel.metres_per_rad
                if not isnan(speed):
                    last_s, found = sensing.heard_s[position], speed
        return found


def _slower(own: float, robots: float) -> float:
    """Return the slower of two speeds; 0 if signs differ, the other if one is unknown."""
    if isnan(own):
        return robots
    return sorted((own, robots, 0.0))[1]


_PIECE_S = 0.3
"""Longer than a round of the boards, so that each wheel has reported in it [decided]."""


class Odometer:
    """Counts the distance travelled, from zero.

    Args:
        robot: The robot whose wheels are counted.
    """

    def __init__(self, robot: RobotSpec) -> None:
        count = len(robot.wheels)
        self._robot = robot
        self._rolling = Rolling(robot)
        self._angles = [nan] * count
        self._ways_m: dict[int, float] = defaultdict(float)
        self._stopped_s = inf
        self._counted_m = 0.0
        self._piece_s = nan
        self._begun_m: Sequence[float] = ()
        self._sharing: tuple[int, ...] = ()

    def look(self, state: EngineState, now_s: float, holding: Sequence[int]) -> float:
        """Return how far the robot has travelled along the pipe, m; backward counts negative.

        Args:
            state: The engine's state.
            now_s: Time, not earlier than in any earlier call.
            holding: Wheels of the part that holds the robot, or all wheels.
        """
        unheard = self._rolling.look(state, now_s)
        self._measure(state)
        totals = [self._ways_m[place] + more for place, more in enumerate(unheard)]
        piece_m = self._piece(totals)
        sharing = self._sharers(state, now_s, holding)
        if sharing != self._sharing or now_s - self._piece_s >= _PIECE_S:
            self._counted_m += piece_m
            self._begun_m, self._piece_s, self._sharing = totals, now_s, sharing
            piece_m = 0.0
        return self._counted_m + piece_m

    def _piece(self, totals: Sequence[float]) -> float:
        """Return how far the robot has travelled since the present piece began, m."""
        if not self._sharing:
            return 0.0
        return median(totals[place] - self._begun_m[place] for place in self._sharing)

    def _measure(self, state: EngineState) -> None:
        """Read the wheels' odometers."""
        for wheel in self._robot.wheels:
            shown, before = state.sensing.angles[wheel.place], self._angles[wheel.place]
            if not isnan(shown) and not isnan(before):
                self._ways_m[wheel.place] += (shown - before) * wheel.metres_per_rad
            self._angles[wheel.place] = shown

    def _may_roll(self, state: EngineState, now_s: float) -> bool:
        """Return whether wheels are driven, or one has not reported since and is not silent."""
        in_force, newest = state.robot.values, state.robot.latest
        if any(in_force[wheel.slot] or newest[wheel.slot] for wheel in self._robot.wheels):
            self._stopped_s = inf
            return True
        self._stopped_s = min(self._stopped_s, now_s)
        heard_s = [state.sensing.heard_s[position] for position in self._robot.wheel_boards]
        silent_s = now_s - self._robot.link.silent_after_s
        return any(silent_s < at <= self._stopped_s for at in heard_s)

    def _sharers(self, state: EngineState, now_s: float, holding: Sequence[int]) -> tuple[int, ...]:
        """Return the indices of the wheels whose median counts now."""
        if not self._may_roll(state, now_s):
            return ()
        in_force, newest = state.robot.values, state.robot.latest
        silent_s = now_s - self._robot.link.silent_after_s
        driven = [
            wheel.place
            for wheel, position in zip(self._robot.wheels, self._robot.wheel_boards, strict=True)
            if state.sensing.heard_s[position] > silent_s
            and not isnan(self._angles[wheel.place])
            and (in_force[wheel.slot] or newest[wheel.slot] or wheel.place in self._sharing)
        ]
        driven = [place for place in driven if place not in state.sensing.distance.out] or driven
        return tuple(place for place in driven if place in holding) or tuple(driven)


# --- the detector ---------------------------------------------------------------------------------

_SHAPES = 4
"""That a bend is passed is only said when the shape fits the pipe in so many looks [decided]."""

_DOUBTED_M = 0.12
"""On the next 50 mm a part still comes round the corner; after this way it is a fault [decided]."""

_BENT_RAD = radians(10)
"""Each joint of a robot that passes a bend turns by 21 deg or more [measured]."""

_PATIENCE_S = 1.0
"""How long a joint may be silent at the start, or while clamps change."""


class Odometry(CompanionBase):
    """A companion that reckons from the engine's signals and reports detector words.

    Args:
        profile: The robot's profile, with its detector words.
        robot: The robot as the engine knows it.
        pipe: The pipe.
        first_wheel_m: Position of the first wheel at the start; by default the pipe's.

    Attributes:
        reckoned: The estimated position; None until every joint has reported.

    Raises:
        UsageError: The robot has no odometry, or the position is outside the pipe.
    """

    def __init__(
        self, profile: Profile, robot: RobotSpec, pipe: Pipe, first_wheel_m: float | None = None
    ) -> None:
        if robot.odometry < 0:
            raise UsageError(f"detector odometry: {robot.name} has no signal of odometry_of")
        self._route = route = pipe.route()
        self._radius_m = profile.body.wheel_radius
        self._walls = drawn_walls(route)
        length_m = sum(robot.body.lengths_m)
        self.first_wheel_m = pipe.start_of(length_m) if first_wheel_m is None else first_wheel_m
        if not 0.0 <= self.first_wheel_m <= route.length_m:
            raise UsageError(
                f"the start at {self.first_wheel_m * 1000:.4g} mm is outside the pipe, "
                f"which is {route.length_m * 1000:.4g} mm long"
            )
        self._roll_rad = pipe.start.roll if pipe.start is not None else 0.0
        self._pipe_roll_rad = pipe.roll
        self.due_s, self._wait_s = 0.0, LOOK_EVERY_S
        self.reckoned: Reckoned | None = None
        self._warned, self._placed_s, self._travel = False, nan, nan
        self._take(robot)
        words = words_of(profile)
        errors = (0.0,) * len(words)
        valid_for_s = profile.detector.valid_for
        self._detector = WordDetector(words, errors, route.bends, valid_for_s)
        self._ahead = RouteReport(route, valid_for_s)
        self._said: tuple[Event | None, ...] = ()
        self._shapes: deque[Shape] = deque(["unknown"], _SHAPES)
        self._doubted_m = self._bent_m = nan
        behind = [word for word in words if word.name in robot.words_behind]
        ways_m = [point.passed_m for word in behind for point in (word.forward, word.backward)]
        self._clear_m = max(ways_m, default=nan)
        self._swept: dict[int, tuple[float, float]] = {}
        self._first_word = words[0].name if words else ""

    def _take(self, robot: RobotSpec) -> None:
        """Follow this robot from now on."""
        self._robot = robot
        self._reckoner = Reckoner(robot.body, self._route, robot.odometry)
        self._odometer = Odometer(robot)
        self._top_m_s = max(wheel.top_m_s for wheel in robot.wheels)

    def react(self, effects: Sequence[Effect], now_s: float) -> None:
        """Look soon when a command begins or ends, a state is confirmed, or wheels are driven."""
        if any(map(self._tells, effects)):
            self.due_s = min(self.due_s, now_s + LOOK_EVERY_S)

    def _tells(self, effect: Effect) -> bool:
        """Return whether an effect shows that the robot may move in another way."""
        if isinstance(effect, Setpoints):
            return self._robot.travel(effect.values) != self._travel
        return isinstance(effect, CommandStatus | StateChange)

    def look(self, state: EngineState, now_s: float) -> Sequence[Log]:
        """Update the estimated position; return a warning if it is unknown."""
        numbers, robot = list(state.sensing.numbers), self._robot
        anchor = self.reckoned.anchor if self.reckoned else WHOLE
        wheels = robot.body.wheels_of(anchor)
        numbers[robot.odometry] = self._odometer.look(state, now_s, wheels)
        held = confirmed_parts(robot, state.robot)
        if self.reckoned is not None:
            felt = Felt(state.surveyed.part, state.surveyed.reported.roll_rad)
            self.reckoned = self._follow(self.reckoned, numbers, held, felt, now_s)
        elif self._reckoner.unknown(numbers):
            return self._warn(numbers) if now_s >= _PATIENCE_S else ()
        else:
            self.reckoned = self._reckoner.begin(self.first_wheel_m, numbers, held, self._roll_rad)
            self._warned, self._placed_s = False, now_s
        self._travel = travel = robot.travel(state.robot.values)
        places_m = self.reckoned.places_m
        self._sweep(numbers, in_bend=state.surveyed.in_bend)
        if held != robot.held[state.robot.configuration]:  # nobody knows where the others are
            self.reckoned = self.reckoned._replace(shape="unknown")
        elif self._rigid():
            self.reckoned = self.reckoned._replace(shape="contradicts")
        self._shapes.append(self.reckoned.shape)
        fits = self._clear() and all(each == "fits" for each in self._shapes)
        seen = all(part.diameter >= 0 for part in robot.body.parts)
        barred = frozenset[str]() if fits or not seen else robot.words_behind
        word = self._detector.look(now_s, places_m, travel, barred)
        report = self._ahead.look(now_s, places_m, self._front_roll_rad())
        self._said = word, report, self._doubt(barred, self.reckoned, numbers)
        self._wait_s = self._rest_s(state, travel, barred)
        return self._warn(numbers) if self.reckoned.lost else ()

    def _rest_s(self, state: EngineState, travel: int, barred: frozenset[str]) -> float:
        """Return after what time to look again.

        Until a command has arrived, and while a word waits for the shape, that is soon.
        """
        assert self.reckoned is not None, "the caller has just reckoned"
        unsure = self._detector.due in barred or any(map(isnan, self.reckoned.places_m))
        if state.robot.flight is not None or unsure:
            return LOOK_EVERY_S
        rest_s = self._ahead.wait_s(self.reckoned.places_m, self._top_m_s) if travel else inf
        return max(LOOK_EVERY_S, min(rest_s, self._detector.wait_s(self._top_m_s)))

    def _clear(self) -> bool:
        """Return whether the robot has rolled on for as long as a word asks since it was bent.

        Its wheels slip while it comes round a bend, so odometry may be far ahead by then. What is
        sure is that none of them has left the bend before all parts lie along one axis.
        """
        at = self.reckoned
        assert at is not None, "the caller has just reckoned"
        held = len(at.spots) == len(self._robot.parts)
        if held and not at.straight:
            self._bent_m = at.odometer_m
        return not abs(at.odometer_m - self._bent_m) < self._clear_m

    def _sweep(self, numbers: Sequence[float], *, in_bend: bool) -> None:
        """Follow the least and the largest angle of each joint since a bend was announced."""
        if not in_bend:
            self._swept = {}
        elif self._swept or self._detector.due == self._first_word:  # else it began in the bend
            for joint in (each for each in self._robot.body.joints if each >= 0):
                least, most = self._swept.get(joint, (inf, -inf))
                angle = numbers[joint]
                self._swept[joint] = min(least, angle), max(most, angle)  # NaN changes neither

    def _rigid(self) -> list[int]:
        """Return the joints that have not been bent since a bend was announced."""
        return [joint for joint, (least, most) in self._swept.items() if most - least < _BENT_RAD]

    def _doubt(
        self, barred: frozenset[str], at: Reckoned, numbers: Sequence[float]
    ) -> FaultReport | None:
        """Return a fault once the shape has contradicted for long that a bend is passed."""
        if self._detector.due not in barred or at.shape != "contradicts":
            self._doubted_m = nan
        elif isnan(self._doubted_m):
            self._doubted_m = at.odometer_m
        elif inf > abs(at.odometer_m - self._doubted_m) >= _DOUBTED_M:
            self._doubted_m = inf  # it is said once
            where = f"odometry is where it would say '{self._detector.due}', but the robot"
            message = f"{where} does not fit the pipe there: {self._misfit(at, numbers)}"
            return BuiltInFault.PLACE_CONTRADICTED.report(message)
        return None

    def _misfit(self, at: Reckoned, numbers: Sequence[float]) -> str:
        """Return what the joints show that does not fit the pipe."""
        for joint in self._rigid():
            return f"{self._robot.vocabulary.numbers[joint]} has not moved in the bend"
        for part, spot in at.spots.items():
            if not self._reckoner.lies(numbers, part, spot.middle_m):
                shown = self._robot.body.parts[part].diameter
                name = self._robot.vocabulary.numbers[shown]
                bore_m = self._route.diameter_at(spot.middle_m)
                return (
                    f"{name} shows {numbers[shown] * 1000:.0f} mm where it has "
                    f"{bore_m * 1000:.0f} mm"
                )
        return "a wheel would be in a wall, or its parts do not lie along one axis"

    def _front_roll_rad(self) -> float:
        """Return the roll of the front part against the frame of the pipe; NaN is unknown."""
        assert self.reckoned is not None, "the caller has just reckoned"
        if self._route.section == "bars":
            return -self._pipe_roll_rad
        return self._reckoner.roll_of(self.reckoned, 0)

    def _follow(
        self,
        before: Reckoned,
        numbers: Sequence[float],
        held: frozenset[int],
        felt: Felt,
        now_s: float,
    ) -> Reckoned:
        """Return the reckoning after this look.

        If a joint is silent when the clamps change, the old clamps are assumed until it reports.
        Any motion in that time is an error.
        """
        after = self._reckoner.look(before, numbers, held, felt)
        if after.lost:
            stood = self._reckoner.look(before, numbers, frozenset(before.spots) - {WHOLE})
            after = self._reckoner.look(stood, numbers, held)
            if after.lost and now_s - self._placed_s < _PATIENCE_S:
                return stood
        if not after.lost:
            self._placed_s = now_s
        return after

    def _warn(self, numbers: Sequence[float]) -> Sequence[Log]:
        """Return, once, a warning that the position is unknown."""
        if self._warned:
            return ()
        self._warned = True
        names = self._robot.vocabulary.numbers
        silent = [names[joint] for joint in self._reckoner.unknown(numbers)]
        because = f": {', '.join(silent)} unknown" if silent else ""
        if self.reckoned is None:
            message = f"odometry does not know yet where the robot is{because}"
        else:
            message = f"odometry has lost the robot's place while the hold changed{because}"
        return (Log("warning", f"{message}; it says no word"),)

    def truth(self) -> Truth | None:
        """Return the estimated position; None while the position of a wheel is unknown."""
        at = self.reckoned
        if at is None or any(isnan(place) for place in at.places_m):
            return None
        moved_m = at.places_m[0] - self.first_wheel_m
        found = Truth(at.points, self._radius_m, self._walls, moved_m)
        if self._route.section == "bars":
            return found
        parts = 0, len(self._robot.parts) - 1
        front, rear = (self._reckoner.roll_of(at, part) for part in parts)
        z_m = tuple(z for _, _, z in at.chain.points)
        return replace(found, z_m=z_m, rolls_rad=(front - rear, front, rear))

    def restart(self, robot: RobotSpec) -> None:
        """Count from zero again, with the robot where it is."""
        self._take(robot)
        if self.reckoned is not None:
            self._bent_m -= self.reckoned.odometer_m
            self._doubted_m -= self.reckoned.odometer_m
            self.reckoned = self.reckoned._replace(odometer_m=0.0)

    def speak(self, now_s: float) -> Sequence[Event]:
        """Return the word and the report that become valid here, or must be repeated."""
        self.due_s = now_s + self._wait_s
        said, self._said = self._said, ()
        return tuple(each for each in said if each is not None)
