"""Networks that nobody built: well-formed ones, and ways to spoil them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from random import Random
from typing import Any, TypeAlias

Network: TypeAlias = dict[str, Any]

MISSION = """\
format: 1
mission: visit
robot: pirate_ii
pipe: net
start: hold
phases:
  hold: {do: [ClampFront, ClampRear], go: there}
ends:
  there: {succeed: Holding}
"""


def well_formed(rng: Random) -> Network:
    """A network of two tees, whose runs keep clear of each other.

    The arms at the second tee are shorter than its distance from all other runs.
    """
    wide = rng.choice([100, 110, 120])
    narrow = rng.choice([each for each in (90, 100, 110, 120) if each <= wide])
    elbow = {"elbow": f"{rng.choice([90, -90])} deg", "radius": f"{rng.randint(150, 200)} mm",
             "roll": _roll(rng)}  # fmt: skip
    legs = rng.choice(
        [
            [],
            [elbow, _straight(rng, 400, 600)],
            [{"mitre": "45 deg", "roll": _roll(rng)}, _straight(rng, 400, 600)],
        ]
    )
    ends = rng.sample(["open", "closed"] * 3, 4)
    return {
        "format": 1,
        "pipe": "net",
        "section": "round",
        "diameter": f"{wide} mm",
        "frame": {"pitch": f"{rng.randint(-80, 80)} deg", "roll": _roll(rng)},
        "runs": {
            "main": {"from": "entry", "to": "t1", "segments": [_straight(rng, 900, 1500)]},
            "past": {"from": "t1.on", "to": "far", "segments": [_straight(rng, 500, 2000)]},
            "off": {
                "from": "t1.branch", "to": "t2", "diameter": f"{narrow} mm",
                "segments": [_straight(rng, 1200, 1800), *legs],
            },
            "left": {"from": "t2.on", "to": "one", "diameter": f"{narrow} mm",
                     "segments": [_straight(rng, 300, 500)]},
            "right": {"from": "t2.branch", "to": "two", "diameter": f"{narrow - 5} mm",
                      "segments": [_straight(rng, 300, 500)]},
        },
        "junctions": {"t1": {"tee": "90 deg", "roll": _roll(rng)},
                      "t2": {"tee": "90 deg", "roll": _roll(rng)}},
        "ends": dict(zip(("entry", "far", "one", "two"), ends, strict=True)),
        "routes": {"home": ["main", "off", "right"], "on": ["main", "past"],
                   "cross": ["past", "off", "left"]},
        "start": {"run": "main", "at": "700 mm", "roll": _roll(rng)},
    }  # fmt: skip


def _straight(rng: Random, least: int, most: int) -> dict[str, str]:
    return {"straight": f"{rng.randint(least, most)} mm"}


def _roll(rng: Random) -> str:
    return f"{rng.choice([0, 30, 90, 135, 180, -45, -90])} deg"


def _run(net: Network, rng: Random) -> Network:
    found: Network = net["runs"][rng.choice(list(net["runs"]))]
    return found


Spoil: TypeAlias = Callable[[Network, Random], Any]


def _port(key: str, port: str) -> Spoil:
    return lambda net, rng: _run(net, rng).update({key: port})


def _start(**start: str) -> Spoil:
    return lambda net, rng: net.update(start=start)


def _begin_with(*segments: Network) -> Spoil:
    def spoil(net: Network, rng: Random) -> None:
        _run(net, rng)["segments"][:0] = [dict(each) for each in segments]

    return spoil


def _end_with(*segments: Network) -> Spoil:
    return lambda net, rng: _run(net, rng)["segments"].extend(dict(each) for each in segments)


def _unconnected(net: Network, rng: Random) -> None:
    net["runs"]["lost"] = {"from": "here", "to": "there", "segments": [_straight(rng, 300, 900)]}
    net["ends"] |= {"here": "open", "there": "closed"}


def _loop(net: Network, rng: Random) -> None:
    """A run from end to end of two others, where it does not reach."""
    net["runs"]["round"] = {"from": "far", "to": "two", "segments": [_straight(rng, 300, 900)]}
    del net["ends"]["far"], net["ends"]["two"]


def _back_into_main(net: Network, rng: Random) -> None:
    """A branch that turns back by two quarter turns, and runs through the main run."""
    net["junctions"]["t1"]["roll"] = net["junctions"]["t2"]["roll"] = "0 deg"
    quarter = {"elbow": "90 deg", "radius": f"{rng.randint(150, 200)} mm"}
    net["runs"]["off"]["segments"] = [
        {"straight": "400 mm"}, quarter, {"straight": "100 mm"}, dict(quarter), {"straight": "2 m"}
    ]  # fmt: skip


SPOILS: dict[str, tuple[Spoil, str]] = {
    name: (spoil, code)
    for name, code, spoil in (
        ("an unknown end", "pipe.junction", _port("to", "nowhere")),
        ("an unknown tee", "pipe.junction", _port("from", "t9.branch")),
        ("a port of two runs", "pipe.junction",
         lambda net, rng: net["runs"]["past"].update({"from": "t1.branch"})),
        ("an arm without a run", "pipe.junction",
         lambda net, rng: net["runs"].pop(rng.choice(["past", "left", "right"]))),
        ("an end of no run", "pipe.junction", lambda net, rng: net["ends"].update(attic="open")),
        ("an end ajar", "choice", lambda net, rng: net["ends"].update(far="ajar")),
        ("an end that is missing", "pipe.junction", lambda net, rng: net["ends"].pop("entry")),
        ("no tee", "pipe.junction", lambda net, rng: net["junctions"].pop("t2")),
        ("a slanting tee", "range", lambda net, rng: net["junctions"]["t1"].update(tee="45 deg")),
        ("a route to an unknown run", "pipe.route",
         lambda net, rng: net["routes"]["home"].append("attic")),
        ("a route by runs that do not meet", "pipe.route",
         lambda net, rng: net["routes"].update(home=["main", "right"])),
        ("a route that comes twice", "pipe.route",
         lambda net, rng: net["routes"].update(home=["main", "off", "main"])),
        ("a route of nothing", "length", lambda net, rng: net["routes"].update(home=[])),
        ("no route", "pipe.route", lambda net, rng: net.pop("routes")),
        ("a branch that is too wide", "pipe.junction",
         lambda net, rng: net["runs"]["right"].update(diameter="121 mm")),
        ("an arm of another width", "pipe.junction",
         lambda net, rng: net["runs"]["past"].update(diameter="85 mm")),
        ("a loop that does not close", "pipe.junction", _loop),
        ("a run of its own", "pipe.junction", _unconnected),
        ("a run through another", "pipe.crossing", _back_into_main),
        ("an elbow first", "pipe.segment", _begin_with({"elbow": "90 deg", "radius": "180 mm"})),
        ("a reducer last", "pipe.segment",
         _end_with({"reducer": "60 mm", "to": "87 mm"})),
        ("two mitres", "pipe.segment", _end_with({"mitre": "30 deg"}, {"mitre": "30 deg"},
                                                 {"straight": "600 mm"})),
        ("a mitre beside an elbow", "pipe.segment",
         _end_with({"elbow": "30 deg", "radius": "180 mm"}, {"mitre": "30 deg"},
                   {"straight": "600 mm"})),
        ("walls that meet", "pipe.segment",
         _end_with({"mitre": "90 deg"}, {"straight": "30 mm"}, {"mitre": "30 deg"},
                   {"straight": "600 mm"})),
        ("a mitre of nothing", "pipe.segment", _begin_with({"straight": "300 mm"},
                                                           {"mitre": "0 deg"})),
        ("an elbow that folds", "pipe.segment",
         _begin_with({"straight": "300 mm"}, {"elbow": "90 deg", "radius": "30 mm"})),
        ("a mitre that is too sharp", "range",
         _begin_with({"straight": "300 mm"}, {"mitre": "150 deg"})),
        ("a reducer to nothing", "range",
         _begin_with({"straight": "300 mm"}, {"reducer": "60 mm", "to": "0 mm"})),
        ("a reducer without an end", "missing-key",
         _begin_with({"straight": "300 mm"}, {"reducer": "60 mm"})),
        ("a tee in a run", "segment", _end_with({"tee": "90 deg", "take": "on"})),
        ("an unknown fitting", "segment", _end_with({"corner": "90 deg"})),
        ("two fittings in one", "unknown-key",
         lambda net, rng: net["runs"]["main"]["segments"][0].update(mitre="90 deg")),
        ("a misspelt key", "unknown-key", lambda net, rng: _run(net, rng).update(diamter="9 mm")),
        ("a straight of less than nothing", "range",
         lambda net, rng: net["runs"]["main"].update(segments=[{"straight": "-1 m"}])),
        ("a heavy straight", "quantity",
         lambda net, rng: net["runs"]["main"].update(segments=[{"straight": "1 kg"}])),
        ("a number for a length", "quantity",
         lambda net, rng: net["runs"]["main"].update(segments=[{"straight": 7}])),
        ("an endless straight", "quantity",
         lambda net, rng: net["runs"]["main"].update(segments=[{"straight": "1e400 m"}])),
        ("no segments", "length", lambda net, rng: _run(net, rng).update(segments=[])),
        ("segments in words", "kind",
         lambda net, rng: _run(net, rng).update(segments="a metre")),
        ("runs in a list", "kind", lambda net, rng: net.update(runs=["main"])),
        ("runs and segments", "value",
         lambda net, rng: net.update(segments=[_straight(rng, 1, 9)])),
        ("no beginning", "missing-key", lambda net, rng: _run(net, rng).pop("from")),
        ("no diameter", "missing-key", lambda net, rng: net.pop("diameter")),
        ("a diameter of less than nothing", "range",
         lambda net, rng: net.update(diameter="-120 mm")),
        ("bars", "pipe.section", lambda net, rng: net.update(section="bars")),
        ("a square section", "choice", lambda net, rng: net.update(section="square")),
        ("a frame that is too steep", "range",
         lambda net, rng: net["frame"].update(pitch="120 deg")),
        ("a frame and a tilt", "value", lambda net, rng: net.update(tilt="10 deg")),
        ("a start beyond the run", "pipe.place", _start(run="main", at="9 m")),
        ("a start in an unknown run", "pipe.route", _start(run="attic", at="700 mm")),
        ("a start beside the route", "pipe.route", _start(run="left", at="300 mm")),
        ("patches that overlap", "pipe.place",
         lambda net, rng: _run(net, rng).update(patches=[
             {"from": "0 mm", "to": "200 mm", "static": 0.3, "kinetic": 0.2},
             {"from": "100 mm", "to": "250 mm", "static": 0.3, "kinetic": 0.2}])),
        ("a patch beyond the run", "pipe.place",
         lambda net, rng: _run(net, rng).update(patches=[
             {"from": "0 mm", "to": "90 m", "static": 0.3, "kinetic": 0.2}])),
        ("an obstacle beyond the route", "pipe.place",
         lambda net, rng: net.update(blockages=[{"at": "90 m", "lasting": "5 s"}])),
    )
}  # fmt: skip
"""What is wrong, how it comes about, and by which code it is told."""


MISFITS: dict[str, tuple[Spoil, str]] = {
    "too wide": (lambda net, rng: _all_wide(net, rng.randint(124, 180)), "pipe.reach"),
    "too narrow": (lambda net, rng: net["runs"]["right"].update(diameter="48 mm"), "pipe.reach"),
    "narrowed too far": (
        lambda net, rng: net["runs"]["right"]["segments"].extend(
            [{"reducer": "60 mm", "to": "45 mm"}, {"straight": "200 mm"}]),
        "pipe.reach"),
    "over a tee": (
        lambda net, rng: net["start"].update(at=net["runs"]["main"]["segments"][0]["straight"]),
        "geometry.too_close"),
    "half outside": (
        lambda net, rng: net["start"].update(at=f"{rng.randint(0, 450)} mm"), "geometry.too_close"),
}  # fmt: skip
"""Why the robot does not fit a network, how that comes about, and by which code it is told."""


ONCE = "ClampFront, ClampRear"
ROUND = "RelaxFront, BendInto, ClampFront, RelaxRear, BendBack, ClampRear, DriveForward, Brake"
BACK = "RelaxRear, BendInto, ClampRear, RelaxFront, BendBack, ClampFront, DriveBackward, Brake"
TURN = "RelaxFront, AlignRight, ClampFront, RelaxRear, AlignStraight, ClampRear"
DRIVE = "DriveForward, Brake"


def mission_on(net: Network, rng: Random) -> str:
    """A mission on one of the routes, which bends, turns and drives as it comes."""
    route = rng.choice(list(net["routes"]))
    net["routes"] = {route: net["routes"].pop(route), **net["routes"]}
    net["start"]["run"] = net["routes"][route][0]
    net["start"]["at"] = rng.choice(["300 mm", "465 mm", "700 mm"])
    steps = ", ".join((ONCE, *rng.choices((ROUND, BACK, TURN, DRIVE), k=rng.randint(1, 6))))
    return MISSION.replace("pipe: net", f"pipe: net\nroute: {route}").replace(ONCE, steps)


def _all_wide(net: Network, diameter_mm: int) -> None:
    net["diameter"] = f"{diameter_mm} mm"


JUNK = (None, True, 7, -1.5, "", "120", "x y", "1 mm", "-3 deg", "9e99 m", [], {}, [[]], {"a": 1})


def junk_in(net: Network, rng: Random) -> None:
    """Something else stands instead of one value anywhere in a network."""
    spots = list(_spots(net))
    where, key = rng.choice(spots)
    where[key] = rng.choice(JUNK)


def _spots(value: Any) -> Iterator[tuple[Any, Any]]:
    keys = value if isinstance(value, dict) else range(len(value) if isinstance(value, list) else 0)
    for key in keys:
        yield value, key
        yield from _spots(value[key])
