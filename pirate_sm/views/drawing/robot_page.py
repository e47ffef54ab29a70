"""A robot as a page in Markdown or HTML: what its commands and controls mean."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from typing import NamedTuple, TypeAlias, assert_never

from pirate_sm import __version__
from pirate_sm.core.loading import ChartOutline, LoadedRobot, reach
from pirate_sm.core.models import (
    Command,
    Control,
    Duty,
    Grip,
    HeldTorque,
    Level,
    Profile,
    Share,
    Slot,
    Speed,
    Stage,
    Target,
)
from pirate_sm.core.spelling import listed
from pirate_sm.core.units import in_degrees
from pirate_sm.views.drawing.command_needs import Need, RegionChange, changes, needs
from pirate_sm.views.drawing.graph.graph import Cluster, Graph, chart_graph
from pirate_sm.views.drawing.mission_words import seconds
from pirate_sm.views.drawing.side_view import Faults, side_text, side_view
from pirate_sm.views.drawing.side_view_svg import side_svg
from pirate_sm.views.drawing.svg.svg_writer import svg
from pirate_sm.views.drawing.text_formats import mermaid
from pirate_sm.views.drawing.wrapping import printable

# --- pages --------------------------------------------------------------------------------------


class Heading(NamedTuple):
    """A heading; the page's own has level 1."""

    level: int
    text: str


class Paragraph(NamedTuple):
    """A paragraph; ``lead`` is its bold beginning."""

    text: str
    lead: str = ""


class PageTable(NamedTuple):
    """Rows with as many cells as the header; an empty header is not shown."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]


class Drawing(NamedTuple):
    """A graph."""

    graph: Graph


class PagePicture(NamedTuple):
    """A picture as SVG, and as lines of text for pages that cannot show it."""

    svg: str
    text: str


Block: TypeAlias = Heading | Paragraph | PageTable | Drawing | PagePicture

_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { border: 1px solid #8888; padding: .3rem .6rem; text-align: left; vertical-align: top; }
figure { margin: 1rem 0; overflow-x: auto; }
"""


def markdown(blocks: Sequence[Block], note: str = "") -> str:
    """Return the page as Markdown, with graphs in Mermaid and pictures in text.

    Args:
        blocks: The page.
        note: A comment in the source of the page.
    """
    texts = [_markdown(block) for block in blocks]
    if note:
        texts.insert(1, f"<!-- {note} -->")
    return "\n\n".join(texts) + "\n"


def _markdown(block: Block) -> str:
    match block:
        case Heading():
            return f"{'#' * block.level} {_marked(block.text)}"
        case Paragraph():
            lead = f"**{_marked(block.lead)}** " if block.lead else ""
            return lead + _marked(block.text)
        case PageTable():
            lines = [block.header, ["---"] * len(block.header), *block.rows]
            return "\n".join(
                f"| {' | '.join(cell if row == 1 else _marked(cell) for cell in cells)} |"
                for row, cells in enumerate(lines)
            )
        case Drawing():
            return f"```mermaid\n{mermaid(block.graph)}```"
        case PagePicture():
            return f"```text\n{block.text}\n```"
    assert_never(block)


def html(blocks: Sequence[Block]) -> str:
    """Return the page as one HTML file without external resources, with pictures in SVG."""
    title = next((block.text for block in blocks if isinstance(block, Heading)), "")
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en"><head><meta charset="utf-8">',
            f'<meta name="generator" content="pirate-sm {escape(__version__)}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{_text(title)}</title><style>{_STYLE}</style></head><body>",
            *(_html(block) for block in blocks),
            "</body></html>",
            "",
        ]
    )


def _html(block: Block) -> str:
    match block:
        case Heading():
            return f"<h{block.level}>{_text(block.text)}</h{block.level}>"
        case Paragraph():
            lead = f"<b>{_text(block.lead)}</b> " if block.lead else ""
            return f"<p>{lead}{_text(block.text)}</p>"
        case PageTable():
            return "\n".join(["<table>", *_rows(block), "</table>"])
        case Drawing():
            return f"<figure>{svg(block.graph)}</figure>"
        case PagePicture():
            return f"<figure>{block.svg}</figure>"
    assert_never(block)


def _rows(table: PageTable) -> Iterator[str]:
    if any(table.header):
        yield f"<tr>{''.join(f'<th>{_text(cell)}</th>' for cell in table.header)}</tr>"
    for row in table.rows:
        yield f"<tr>{''.join(f'<td>{_text(cell)}</td>' for cell in row)}</tr>"


def _text(text: str) -> str:
    return escape(printable(" ".join(text.split())))


def _marked(text: str) -> str:
    """Return the text on one line, with all characters of Markdown's markup escaped."""
    line = printable(" ".join(text.split()))
    return "".join(f"\\{each}" if each in "\\|<*`[]" else each for each in line)


# --- robots -------------------------------------------------------------------------------------


NOTHING = "–"

_GENERAL = (
    "What a command needs is said for a robot whose clamps are all confirmed. Where they are not, "
    "no command that opens a part is taken unless another part, whose clamp is confirmed, goes on "
    "holding, except for one that lets go and says so; and wheels are driven only with a confirmed "
    "clamp."
)


def robot_page(robot: LoadedRobot, faults: Faults | None = None) -> list[Block]:
    """Return the page; what is wrong with the robot is marked in its picture."""
    view = side_view(robot, faults)
    return [
        Heading(1, robot.profile.robot),
        Paragraph(robot.profile.description),
        *_body(robot.profile),
        PagePicture(side_svg(view), side_text(view)),
        Heading(2, "Commands"),
        *_overview(robot.profile),
        *(block for name in robot.profile.commands for block in command_blocks(robot, name)),
        *_other_names(robot.profile),
        Heading(2, "States"),
        *(block for place in range(len(robot.table.regions)) for block in _region(robot, place)),
        *_controls(robot.profile),
        *_safety(robot.profile),
    ]


# --- the robot ---------------------------------------------------------------------------------


def _body(profile: Profile) -> Iterator[Block]:
    body = profile.body
    rows = []
    for name in body.parts:
        wheels = listed(wheel.name for wheel in body.wheels if wheel.part == name)
        joints = listed(joint.name for joint in body.joints if joint.part == name)
        rows.append((f"part {name}", f"{wheels}; bent by {joints}"))
    rolls = [link.roll for link in body.links if link.roll]
    if rolls:
        rows.append(("rotation", listed(rolls)))
    least, largest = reach(profile)
    rows.append(("pipes", f"inner diameter {least * 1e3:.0f} to {largest * 1e3:.0f} mm"))
    rows.append(
        ("length", f"{sum(link.length for link in body.links) * 1e3:.0f} mm, wheel to wheel")
    )
    yield PageTable(("", ""), rows)


def _safety(profile: Profile) -> Iterator[Block]:
    yield Heading(2, "Safety")
    yield Paragraph(
        f"{_things(profile, profile.safe_state.zero)} are set to zero; every other motor keeps "
        "what it was last given, so that clamps stay held.",
        "Safe state:",
    )
    for rule in profile.rules:
        after = f"once {rule.after}, " if rule.after else ""
        if rule.expect is not None:
            what = f"{after}{rule.expect} within {rule.within_steps} commands"
        else:
            what = f"{after}{'never ' + rule.never if rule.never else f'always {rule.always}'}"
        yield Paragraph(f"{what}" + (f": {rule.why}" if rule.why else ""), f"Rule {rule.rule}:")


def _other_names(profile: Profile) -> Iterator[Block]:
    if profile.aliases or profile.not_commands:
        yield Heading(2, "Other names")
        rows = [(alias, name) for alias, name in profile.aliases.items()]
        rows += [(name, f"none: {why}") for name, why in profile.not_commands.items()]
        yield PageTable(("name", "command"), rows)


# --- its commands ------------------------------------------------------------------------------


def _overview(profile: Profile) -> Iterator[Block]:
    yield PageTable(
        ("command", "what it does", "at most"),
        [
            (name, each.description or NOTHING, seconds(each.timeout))
            for name, each in profile.commands.items()
        ],
    )
    yield Paragraph(_GENERAL)


def command_blocks(robot: LoadedRobot, name: str) -> Iterator[Block]:
    """Yield what the page says of a command: what it needs and moves, and how long that takes."""
    profile, index = robot.profile, robot.table.command_index[name]
    command = profile.commands[name]
    yield Heading(3, name)
    if command.description:
        yield Paragraph(command.description)
    yield from _needed(robot, index)
    found = changes(robot.normal, index)
    yield PageTable(("region", "from", "to", "motors"), [_change(robot, each) for each in found])
    if command.posture:
        yield from _posture(profile, command.posture)
    angles = {slot.name: slot.roll or slot.name for slot in profile.slots}
    yield Paragraph(f"when {command.done.in_words(angles)}.", "Done")
    yield Paragraph(
        f"if that takes longer than {seconds(command.timeout)}; nominally it takes "
        f"{seconds(command.nominal)}.",
        "Fails",
    )
    yield from _special(command)


def _special(command: Command) -> Iterator[Block]:
    if command.asks_for != "false":
        yield Paragraph(f"where {command.asks_for} already.", "Unneeded")
    if command.lets_go:
        yield Paragraph("it may open the last clamp: nothing holds the robot then.", "Lets go:")


def _needed(robot: LoadedRobot, index: int) -> Iterator[Block]:
    found = needs(robot.normal, index)
    if not found.any_of:
        yield Paragraph("it is taken nowhere.", "Needs:")
    elif found.unless is not None:
        together = " together" if len(found.unless) > 1 else ""
        yield Paragraph(f"anything but {_need(robot, found.unless, 'and')}{together}.", "Needs")
    else:
        partly = "; it is not taken in all of these combinations" if found.partly else ""
        for number, each in enumerate(found.any_of):
            yield Paragraph(f"{_need(robot, each)}{partly}.", "or" if number else "Needs")


def _need(robot: LoadedRobot, need: Need, word: str = "") -> str:
    parts = [
        f"{robot.table.regions[region]} {listed(names, 'or')}" for region, names in need.items()
    ]
    return (listed(parts, word) if word else "; ".join(parts)) or "nothing"


def _change(robot: LoadedRobot, change: RegionChange) -> tuple[str, str, str, str]:
    region = robot.table.regions[change.region]
    slots = {robot.profile.slots[slot].name for slot in change.slots}
    before = listed(change.before, "or") + (" (or it stays)" if change.sometimes else "")
    stages = robot.profile.actuation[region][change.after]
    return region, before, change.after, given(robot.profile, stages, slots)


def _posture(profile: Profile, name: str) -> Iterator[Block]:
    cases = profile.postures[name]
    yield Paragraph(f"the joints take the posture {name}, where one of these holds:", "First")
    yield PageTable(
        ("where", "motors"),
        [
            (case.when, given(profile, [case.set_]) if case.set_ else f"refused: {case.refuse}")
            for case in cases
        ],
    )


# --- its states --------------------------------------------------------------------------------


def _region(robot: LoadedRobot, place: int) -> Iterator[Block]:
    region = robot.table.regions[place]
    yield Heading(3, region)
    yield Drawing(_picture(robot.outline, place))
    states = robot.profile.actuation[region]
    rows = [
        (name, given(robot.profile, states[name]), _holding(robot, place, name))
        for name in robot.table.states[place]
    ]
    yield PageTable(("state", "motors", "holds"), rows)


def _controls(profile: Profile) -> Iterator[Block]:
    if profile.controls:
        yield Heading(2, "Controls")
        yield Paragraph("Other ways to actuate these states, which a mission chooses by name.")
    for name, control in profile.controls.items():
        yield Heading(3, name)
        if control.description:
            yield Paragraph(control.description)
        if control.extends is not None:
            yield Paragraph(f"{control.extends}, with these changes.", "As")
        rows = [
            (region, state, given(profile, stages))
            for region, states in control.actuation.items()
            for state, stages in states.items()
        ]
        if control.gravity_compensation:
            yield Paragraph("Wheels that are kept at a speed or a torque also bear the weight.")
        if control.grip is not None:
            up_to = most(control.grip)
            yield Paragraph(f"Clamps press as hard as tilt and friction ask for, up to {up_to}.")
        if rows:
            yield PageTable(("region", "state", "motors"), rows)


def most(grip: Grip) -> str:
    """Return the largest torque of a grip, in words."""
    return "what a motor bears" if grip.at_most is None else f"{grip.at_most * 1000:g} mNm"


def _picture(outline: ChartOutline, place: int) -> Graph:
    """Return one region of the chart, without a frame around it."""
    region = outline.regions[place]
    alone = replace(
        outline,
        regions=(region,),
        states=(outline.states[place],),
        initial=(outline.initial[place],),
        transitions=tuple(each for each in outline.transitions if each.region == region),
    )
    return replace(chart_graph(alone, region), clusters=(Cluster(region),))


def _holding(robot: LoadedRobot, place: int, state: str) -> str:
    """Return the parts that are held in this state of the region, where it decides on that."""
    spec = robot.normal
    inside = [
        index for index, states in enumerate(robot.table.configurations) if states[place] == state
    ]
    parts = [
        name
        for part, name in enumerate(spec.parts)
        if place in spec.part_regions[part] and all(part in spec.held[index] for index in inside)
    ]
    return listed(parts) or NOTHING


# --- motors ------------------------------------------------------------------------------------


def given(profile: Profile, stages: Sequence[Stage], only: set[str] | None = None) -> str:
    """Return what the stages write to all slots, or only to those in ``only``."""
    slots = {slot.name: slot for slot in profile.slots}
    texts = []
    for stage in stages:
        given = [
            f"{_thing(slots[name])} {_value(value)}"
            for name, value in stage.items()
            if only is None or name in only
        ]
        if given:
            texts.append(", ".join(given))
    return "; then ".join(texts) or NOTHING


def _value(value: object) -> str:
    match value:
        case Duty():
            return f"{value.value * 100:g} %"
        case Target():
            return f"to {in_degrees(value.angle_rad)}"
        case Share():
            return f"to {value.factor:g} × {value.joint}"
        case Level():
            level = in_degrees(value.angle_rad)
            return f"until the part that turns is at {level} to the horizontal"
        case Speed():
            return f"at {value.value * 1000:g} mm/s"
        case HeldTorque():
            return f"bears {value.value * 1000:g} mNm"
        case _:
            return "as it is"


def _thing(slot: Slot) -> str:
    """Return the part that a slot moves, in the words of missions."""
    return slot.joint or slot.wheel or slot.roll or slot.name


def _things(profile: Profile, names: Sequence[str]) -> str:
    slots = {slot.name: slot for slot in profile.slots}
    return listed(_thing(slots[name]) for name in names)


# --- controls -----------------------------------------------------------------------------------


def control_text(profile: Profile, name: str) -> str:
    """Return what a control of the profile does, line by line."""
    chain = list(_extended(profile, name))
    title = f"{name} (control of {profile.robot})"
    about = profile.controls[name].description
    lines = [f"{title}: {about}" if about else title, ""]
    if len(chain) > 1:
        lines.append(f"It extends {', which extends '.join(other for other, _ in chain[1:])}.")
    stages = {
        (region, state): each
        for _, control in reversed(chain)
        for region, states in control.actuation.items()
        for state, each in states.items()
    }
    lines += [
        f"{region}.{state}: {given(profile, each)}" for (region, state), each in stages.items()
    ]
    compensates = (control.gravity_compensation for _, control in chain)
    if next((each for each in compensates if each is not None), False):
        lines.append("Wheels that are kept at a speed or a torque also bear the weight.")
    grip = next((control.grip for _, control in chain if control.grip is not None), None)
    if grip is not None:
        lines.append(_grip_text(grip))
    lines += [
        "All other states are actuated as usual.",
        "",
        "At the head of a mission, or as a step:",
        "",
    ]
    lines += [f"  control: {name}", f"  do: [{{control: {name}}}]"]
    return "\n".join(lines)


def _extended(profile: Profile, name: str) -> Iterator[tuple[str, Control]]:
    """Yield a control and those that it extends, itself first."""
    other: str | None = name
    while other is not None:
        yield other, profile.controls[other]
        other = profile.controls[other].extends


def _grip_text(grip: Grip) -> str:
    friction = grip.friction
    known = (
        "that slipping wheels show"
        if friction == "estimate"
        else ", ".join(f"{value:g} ({part})" for part, value in friction.items())
    )
    return (
        f"Clamps press as tilt and friction ask for, up to {most(grip)}: friction"
        f" {known}, safety {grip.safety:g}."
    )
