"""Generate the waits of phases and steps."""

from __future__ import annotations

from math import inf

from pirate_sm.core._engine.mission import program as out
from pirate_sm.core._loading.mission.scope import TIME_LIMIT, Label, Scope, trigger_names
from pirate_sm.core._loading.problems import Path
from pirate_sm.core._model import mission as model
from pirate_sm.core._model.triggers import ConditionTrigger, OperatorTrigger, TimeTrigger, Trigger

KNOWN_WITHIN = " known within "
"""Follows a condition that needs a bound of the distance, the bound follows."""


def wait_fields(
    scope: Scope,
    it: model.Phase | model.WaitStep,
    path: Path,
    after: Label | None,
    failed: Label | int,
) -> dict[str, object]:
    """Return the fields of a wait instruction for a phase or step.

    Args:
        scope: The mission that is being compiled.
        it: The phase or step.
        path: Its path in the file.
        after: The next step, for triggers without a target; None in a phase.
        failed: Target of a failure of the step.
    """
    within, target, name, fails = inf, failed, "", False
    if it.within is not None:
        at = (*path, "within")
        within = scope.waited(it.within.time, (*at, "time"))
        fails, name = it.within.go is None, it.within.go or model.FAIL
        target = failed if it.within.go is None else scope.target(name, (*at, "go"))
    names = trigger_names(it.wait)
    for number, trigger in enumerate(it.wait):
        if trigger.name is not None and trigger.name in {*names[:number], TIME_LIMIT}:
            at = (*path, "wait", number, "name")
            scope.problems.add("mission.name", at, f"'{trigger.name}' names another trigger here")
    triggers = tuple(
        _trigger(scope, trigger, name, (*path, "wait", number), after)
        for number, (trigger, name) in enumerate(zip(it.wait, names, strict=True))
    )
    return {
        "phase": scope.full_phase,
        "triggers": triggers,
        "within_s": within,
        "within": target,
        "within_name": name,
        "place": scope.place((*path, "wait")),
        "fails": fails,
        "compares": any(_compares(trigger) for trigger in triggers),
        "counts_on": it.counts_on,
    }


def _trigger(
    scope: Scope, trigger: Trigger, name: str, path: Path, after: Label | None
) -> out.TriggerSpec:
    on = trigger.go is None and after is not None
    go = after if on else scope.target(trigger.go or "", (*path, "go"))
    place, go_name = scope.place(path), trigger.go or model.CONTINUE
    spec = out.TriggerSpec(name, "", go, go_name, place=place)  # type: ignore[arg-type]
    match trigger:
        case ConditionTrigger(when=when):
            held = scope.waited(trigger.held, (*path, "held"), zero=True)
            what, asks, bound = when.partition(KNOWN_WITHIN)
            condition = scope.condition(what, (*path, "when"), in_wait=True)
            text = when + (f" for {held:g} s" if held else "")
            spec = spec._replace(text=text, condition=condition, held_s=held)
            if not asks:
                return spec
            shifted = " " * (len(when) - len(bound)) + bound  # so that faults show their place
            return spec._replace(known_within_m=scope.bound_m(shifted, (*path, "when")))
        case TimeTrigger():
            after_s = scope.waited(trigger.after, (*path, "after"))
            return spec._replace(text=f"after {after_s:g} s", after_s=after_s)
        case OperatorTrigger(operator=word):
            return spec._replace(text=f"operator: {word}", answer=word)


def _compares(trigger: out.TriggerSpec) -> bool:
    """Return whether the trigger uses the change of a signal since the wait began."""
    return trigger.condition is not None and any(
        name.startswith("change(") for name in trigger.condition.names
    )
