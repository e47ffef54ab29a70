"""The words of a mission in drawings: steps and triggers in short."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pirate_sm.core import models as model
from pirate_sm.core.fields import Parameter
from pirate_sm.core.models import ConditionTrigger, OperatorTrigger, TimeTrigger, Trigger
from pirate_sm.views.drawing.wrapping import INDENT


def amount(value: float | int | Parameter, unit: str = "") -> str:
    """Return the quantity as written in a mission: ``200 ms``, ``3``, ``$give_up``."""
    if isinstance(value, Parameter):
        return f"${value.name}"
    if unit == "s" and 0 < value < 1:
        return f"{value * 1000:g} ms"
    if unit == "s" and value >= 60 and value % 60 == 0:
        return f"{value / 60:g} min"
    return f"{value:g} {unit}".strip()


def step_lines(steps: Iterable[model.Step], indent: str = "") -> tuple[str, ...]:
    """Return one line for each step, with inner steps indented below it."""
    lines: list[str] = []
    deeper = indent + " " * INDENT
    for step in steps:
        inside = indent
        if step.condition is not None and not isinstance(step, model.CommandStep):
            lines.append(f"{indent}if {step.condition}:")
            inside = deeper
        lines += _lines(step, inside)
    return tuple(lines)


def _lines(step: model.Step, indent: str) -> Iterator[str]:
    deeper = indent + " " * INDENT
    match step:
        case model.RepeatStep():
            yield f"{indent}{amount(step.repeat.times)} times:{_leads(step)}"
            yield from step_lines(step.repeat.do, deeper)
        case model.ChooseStep():
            yield from _choice_lines(step, indent, deeper)
        case model.CommandStep():
            yield f"{indent}{_command(step)}"
        case model.CallStep():
            given = ", ".join(f"{name} = {value}" for name, value in step.arguments.items())
            yield f"{indent}call {step.call}{f' ({given})' if given else ''}{_leads(step)}"
        case model.AskStep():
            yield f"{indent}ask “{step.ask}” ({', '.join(step.choices)}){_leads(step)}"
        case model.WaitStep():
            limit = f", ≤ {amount(step.within.time, 's')}" if step.within is not None else ""
            triggers = " or ".join(map(trigger_text, step.wait))
            yield f"{indent}wait for {triggers}{limit}{_leads(step)}"
        case model.ControlStep():
            yield f"{indent}control {step.control}{_leads(step)}"
        case model.LogStep():
            yield f"{indent}log “{step.log}”"


def _choice_lines(step: model.ChooseStep, indent: str, deeper: str) -> Iterator[str]:
    for number, choice in enumerate(step.choose):
        word = "else if" if number else "if"
        yield f"{indent}{word} {choice.condition}:{'' if number else _leads(step)}"
        yield from step_lines(choice.do, deeper)
    if step.otherwise:
        yield f"{indent}else:"
        yield from step_lines(step.otherwise, deeper)


def _command(step: model.CommandStep) -> str:
    extra = []
    if step.condition is not None:
        extra.append(f"if {step.condition}")
    if step.unneeded == "skip":
        extra.append("if needed")
    if step.timeout is not None:
        extra.append(f"≤ {amount(step.timeout, 's')}")
    if step.retry:
        extra.append(f"retry {amount(step.retry)}")
    return f"{step.command}{''.join(f', {each}' for each in extra)}{_leads(step)}"


def _leads(step: model.Step) -> str:
    """Return where a failure of the step leads, if that differs from the mission's default."""
    if step.on_failure is None:
        return ""
    return ", or go on" if step.on_failure == model.CONTINUE else f", or {step.on_failure}"


def short(step: model.Step) -> str:
    """Return the name of a step in messages about its failure."""
    match step:
        case model.CommandStep():
            return step.command
        case model.CallStep():
            return f"call {step.call}"
        case model.AskStep():
            return f"“{step.ask}”"
        case model.RepeatStep():
            return "repeat"
        case model.ChooseStep():
            return "choose"
        case model.WaitStep():
            return "wait"
        case model.ControlStep():
            return f"control {step.control}"
        case model.LogStep():
            return "log"


def trigger_text(trigger: Trigger) -> str:
    """Return the condition of the trigger, after its name if it has one."""
    match trigger:
        case ConditionTrigger():
            held = trigger.held if isinstance(trigger.held, Parameter) or trigger.held else None
            text = trigger.when + (f" for {amount(held, 's')}" if held is not None else "")
        case TimeTrigger():
            text = f"after {amount(trigger.after, 's')}"
        case OperatorTrigger():
            text = f"operator: {trigger.operator}"
    return f"{trigger.name}: {text}" if trigger.name else text


def seconds(value_s: float) -> str:
    """Return a time in seconds."""
    return f"{value_s:g} s"
