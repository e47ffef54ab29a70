"""Generate the instructions of a mission and of the missions that it calls.

While they are written, labels are their targets; then these are resolved to indexes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

from pirate_sm.core._engine.mission import program as out
from pirate_sm.core._engine.mission.program import HandlerSpec, Instruction
from pirate_sm.core._loading.mission.called_missions import (
    Calls,
    arguments_of,
    check_call,
    required_states,
)
from pirate_sm.core._loading.mission.scope import (
    TIME_LIMIT,
    Handlers,
    Label,
    Scope,
    labels_of,
    trigger_names,
)
from pirate_sm.core._loading.problems import Path, Problems
from pirate_sm.core._loading.robot.loader import LoadedRobot
from pirate_sm.core._model import mission as model
from pirate_sm.core._model.triggers import ConditionTrigger, OperatorTrigger, TimeTrigger, Trigger

KNOWN_WITHIN = " known within "
"""Follows a condition that needs a bound of the distance, the bound follows."""


def _wait_fields(
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


MOST_INSTRUCTIONS = 20_000
"""Largest number of instructions, with repeats unrolled and calls inlined."""


class TooLongError(Exception):
    """Raised when the program exceeds ``MOST_INSTRUCTIONS``."""

    def __init__(self) -> None:
        self.by: tuple[Problems, Path] | None = None  # the outermost repeat


@dataclass
class Assembly:
    """The program being written."""

    _kinds: list[type[Any]] = field(default_factory=list)
    _fields: list[dict[str, Any]] = field(default_factory=list)
    _handlers: list[Handlers] = field(default_factory=list)
    _phases: list[str] = field(default_factory=list)
    _turns: list[str] = field(default_factory=list)

    @property
    def length(self) -> int:
        """Return the present number of instructions."""
        return len(self._kinds)

    def mark(self, label: Label) -> None:
        """Set the label to the next instruction."""
        label.index = len(self._kinds)

    def emit(
        self, kind: type[Any], phase: str, handlers: Handlers, /, *, turn: str = "", **fields: Any
    ) -> None:
        """Add an instruction; its fields may hold labels, also inside tuples.

        Args:
            kind: Class of the instruction.
            phase: The phase that it belongs to.
            handlers: Fault handlers in force.
            turn: The round of a repeat, such as ``2 of 4``; empty outside repeats.
            fields: Its fields.

        Raises:
            TooLongError: The program is too long.
        """
        if len(self._kinds) >= MOST_INSTRUCTIONS:
            raise TooLongError
        self._kinds.append(kind)
        self._fields.append(fields)
        self._handlers.append(handlers)
        self._phases.append(phase)
        self._turns.append(turn)

    def finished(
        self,
    ) -> tuple[
        tuple[Instruction, ...],
        tuple[tuple[HandlerSpec, ...], ...],
        tuple[str, ...],
        tuple[str, ...],
    ]:
        """Return the instructions, and the handlers, phase and round of each, without labels."""
        instructions = tuple(
            kind(**{name: _resolved(value) for name, value in fields.items()})
            for kind, fields in zip(self._kinds, self._fields, strict=True)
        )
        handlers = tuple(
            tuple(
                HandlerSpec(code, _resolved(label), name, of, place)
                for code, label, name, of, place in each
            )
            for each in self._handlers
        )
        return instructions, handlers, tuple(self._phases), tuple(self._turns)


def _resolved(value: Any) -> Any:
    if isinstance(value, Label):
        return value.index
    if isinstance(value, tuple):
        items = [_resolved(item) for item in value]
        return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
    return value


@dataclass
class ProgramWriter:
    """Generates instructions; holds the data common to a mission and all called missions."""

    robot: LoadedRobot
    assembly: Assembly
    names: list[str] = field(default_factory=list)
    calls: Calls = field(default_factory=Calls)

    def ends(self, scope: Scope) -> None:
        """Write the ends of the outermost mission, each of which finishes the run."""
        for name, end in scope.source.mission.ends.items():
            self.assembly.mark(scope.targets[name])
            outcome = "failed" if end.succeed is None else "succeeded"
            message = _message_of(end, name, scope)
            # A success that is claimed by a distance may meet a fault, see `claims`.
            handlers = scope.outer if end.succeed is None else scope.handlers
            what = {"outcome": outcome, "message": message, "place": scope.place(("ends", name))}
            self.assembly.emit(out.Finish, "", handlers, end=name, **what)

    def beginning(self, scope: Scope, phase: str) -> Label:
        """Return the label that a mission begins at; :meth:`begin` places it."""
        start = scope.target(phase, ("start",))
        return start if scope.source.mission.control is None else Label()

    def begin(self, scope: Scope, phase: str, beginning: Label) -> None:
        """Write what comes before a mission's first phase: its control, if it names one."""
        name, path = scope.source.mission.control, ("control",)
        if name is None:
            return
        self.assembly.mark(beginning)
        self.assembly.emit(
            out.SwitchControl,
            replace(scope, phase=phase).full_phase,
            scope.handlers,
            control=scope.control(name, path),
            timeout_s=model.CONTROL_WITHIN_S,
            next=scope.target(phase, ("start",)),
            failed=scope.failure(None, path),
            place=scope.place(path),
        )

    def phases(self, scope: Scope) -> None:
        """Write every phase of the scope's mission."""
        handlers = scope.handlers
        scope.check_names()
        for name, phase in scope.source.mission.phases.items():
            inside = replace(scope, phase=name)
            if inside.full_phase not in self.names:  # list the phases of a repeated call once
                self.names.append(inside.full_phase)
            _PhaseWriter(self, inside, handlers).write(phase, ("phases", name))


def _message_of(end: model.End, name: str, scope: Scope) -> str:
    """Return the message of an end, with the values of parameters."""
    if end.succeed is not None:
        return scope.message(end.succeed, ("ends", name, "succeed"))
    return scope.message(end.fail or "", ("ends", name, "fail"))


@dataclass
class _PhaseWriter:
    """Writes the instructions of one phase."""

    compiler: ProgramWriter
    scope: Scope
    handlers: Handlers

    def write(self, phase: model.Phase, path: Path) -> None:
        """Write the phase's entry, its steps and its wait."""
        scope = self.scope
        self.compiler.assembly.mark(scope.targets[scope.phase])
        steps, wait = Label(), Label()
        handles_itself = phase.on_failure == scope.phase  # its steps report that
        self._emit(
            out.Enter,
            phase=scope.full_phase,
            next=steps,
            failed=scope.caller if handles_itself else scope.failure(None, path),
            resume=scope.resumed_at(phase.resume, (*path, "resume")),
            place=scope.place(path),
        )
        self.compiler.assembly.mark(steps)
        after = wait if phase.wait else scope.target(phase.go or "", (*path, "go"))
        self._steps(phase.do, (*path, "do"), after)
        if not phase.do and not phase.wait:
            self._jump(after)
        if phase.wait:
            self.compiler.assembly.mark(wait)
            self._wait(phase, path, None, out.STOP)

    def _emit(self, kind: type[object], **fields: object) -> None:
        scope = self.scope
        turn = "{} of {}".format(*scope.turn) if scope.turn else ""
        self.compiler.assembly.emit(kind, scope.full_phase, self.handlers, turn=turn, **fields)

    def _wait(
        self, it: model.Phase | model.WaitStep, path: Path, after: Label | None, failed: Label | int
    ) -> None:
        self._emit(out.Wait, **_wait_fields(self.scope, it, path, after, failed))

    def _steps(self, steps: Sequence[model.Step], path: Path, after: Label) -> None:
        for number, step in enumerate(steps):
            following = Label() if number + 1 < len(steps) else after
            self._step(step, (*path, number), following)
            if following is not after:
                self.compiler.assembly.mark(following)

    def _guard(self, step: model.Step, path: Path, after: Label) -> None:
        if step.condition is not None:
            body = Label()
            self._branch(step.condition, (*path, "if"), body, after)
            self.compiler.assembly.mark(body)

    def _step(self, step: model.Step, path: Path, after: Label) -> None:
        self._guard(step, path, after)
        match step:
            case model.CommandStep():
                self._command(step, path, after)
            case model.CallStep():
                self._call(step, path, after)
            case model.RepeatStep():
                self._repeat(step, path, after)
            case model.ChooseStep():
                self._choose(step, path, after)
            case model.AskStep():
                self._ask(step, path, after)
            case model.WaitStep():
                self._wait(step, path, after, self._failure(step, path, after))
            case model.ControlStep():
                self._switch(step, path, after)
            case model.LogStep():
                text, place = self.scope.message(step.log, (*path, "log")), self.scope.place(path)
                self._emit(out.Say, level=step.level, message=text, next=after, place=place)

    def _branch(self, text: str, path: Path, if_true: Label, if_false: Label) -> None:
        asked = {"condition": self.scope.condition(text, path), "place": self.scope.place(path)}
        self._emit(out.Branch, if_true=if_true, if_false=if_false, **asked)

    def _command(self, step: model.CommandStep, path: Path, after: Label) -> None:
        scope = self.scope
        command = scope.command(step.command, (*path, "command"))
        if command is None:
            self._jump(after)  # leave out the faulty step
            return
        self._emit(
            out.Do,
            command=command,
            timeout_s=scope.limit(step.timeout, (*path, "timeout")),
            retries=scope.retries(step.retry, (*path, "retry")),
            skip_unneeded=step.unneeded == "skip",
            next=after,
            failed=self._failure(step, path, after),
            place=scope.place(path),
            expected=step.on_failure is not None,
            handled=scope.handles_failures,
        )

    def _switch(self, step: model.ControlStep, path: Path, after: Label) -> None:
        scope = self.scope
        self._emit(
            out.SwitchControl,
            control=scope.control(step.control, (*path, "control")),
            timeout_s=scope.waited(step.timeout, (*path, "timeout")),
            next=after,
            failed=self._failure(step, path, after),
            place=scope.place(path),
        )

    def _failure(self, step: model.Step, path: Path, after: Label) -> Label | int:
        """Return the target of the step's failure; `continue` leads to the next step."""
        if step.on_failure == model.CONTINUE:
            return after
        return self.scope.failure(step.on_failure, path)

    def _repeat(self, step: model.RepeatStep, path: Path, after: Label) -> None:
        at = (*path, "repeat", "times")
        times = self.scope.count(step.repeat.times, at)
        if times < 1:
            self.scope.problems.add("mission.repeat", at, "repeat at least once")
        inside = self.scope if step.on_failure is None else self._failing(step, path, after)
        assembly = self.compiler.assembly
        try:
            for turn in range(times):
                numbered = replace(inside, turn=(turn + 1, times))
                writer = _PhaseWriter(self.compiler, numbered, self.handlers)
                following, before = Label() if turn + 1 < times else after, assembly.length
                writer._steps(step.repeat.do, (*path, "repeat", "do"), following)
                if assembly.length == before:
                    return  # nothing could be written; reported already
                if following is not after:
                    assembly.mark(following)
        except TooLongError as error:
            error.by = self.scope.problems, at
            raise

    def _failing(self, step: model.Step, path: Path, after: Label) -> Scope:
        """Return the scope inside a step; the step's ``on_failure`` overrides the phase's."""
        return replace(self.scope, inner=self._failure(step, path, after))

    def _choose(self, step: model.ChooseStep, path: Path, after: Label) -> None:
        inside = self.scope if step.on_failure is None else self._failing(step, path, after)
        writer = _PhaseWriter(self.compiler, inside, self.handlers)
        for number, choice in enumerate(step.choose):
            at = (*path, "choose", number)
            body, other = Label(), Label()
            self._branch(choice.condition, (*at, "if"), body, other)
            self._block(writer, body, choice.do, (*at, "do"), after)
            self.compiler.assembly.mark(other)
        self._block(writer, Label(), step.otherwise, (*path, "else"), after)

    def _block(
        self,
        writer: _PhaseWriter,
        label: Label,
        steps: Sequence[model.Step],
        path: Path,
        after: Label,
    ) -> None:
        self.compiler.assembly.mark(label)
        if steps:
            writer._steps(steps, path, after)
        else:
            self._jump(after)

    def _jump(self, after: Label) -> None:
        self._emit(out.Require, states=(), what="", next=after, failed=after, place="")

    def _ask(self, step: model.AskStep, path: Path, after: Label) -> None:
        scope = self.scope
        failed = self._failure(step, path, after)
        question = Label()
        self.compiler.assembly.mark(question)
        refused: list[tuple[Label, str]] = []
        choices: list[tuple[str, Label]] = []
        for choice, leads in step.choices.items():
            if leads == model.CONTINUE:
                choices.append((choice, after))
            elif leads == model.FAIL:
                refused.append((Label(), choice))
                choices.append((choice, refused[-1][0]))
            else:
                at = (*path, "choices", choice)
                choices.append((choice, scope.target(leads, at, model.CONTINUE, model.FAIL)))
        timeout = scope.limit(step.timeout, (*path, "timeout"))
        text = scope.message(step.ask, (*path, "ask"))
        self._emit(
            out.Question,
            text=text,
            choices=tuple(choices),
            failed=failed,
            timeout_s=inf if timeout is None else timeout,
            place=scope.place(path),
        )
        for label, choice in refused:
            self.compiler.assembly.mark(label)
            message = f"the operator answered '{choice}' to '{text}'"
            self._emit(out.Raise, message=message, failed=failed, place=scope.place(path))

    def _call(self, step: model.CallStep, path: Path, after: Label) -> None:
        scope = self.scope
        source = self.compiler.calls.source(step.call, scope, (*path, "call"))
        if source is None:
            return
        if not check_call(source, scope, (*path, "call")):
            return
        failed = self._failure(step, path, after)
        values = arguments_of(step, source, scope, path)
        inside = replace(
            scope,
            source=source,
            problems=scope.problems.about(source.document),
            values=values,
            prefix=f"{scope.full_phase}/{source.mission.mission}.",
            targets=labels_of(source.mission),
            caller=failed,
            outer=self.handlers,
            calls=(*scope.calls, source.path),
            phase="",
            inner=None,
        )
        begin = self.compiler.beginning(inside, source.mission.start)
        self._emit(
            out.Require,
            states=required_states(source, scope.robot.table, inside.problems),
            what=f"mission {source.mission.mission}",
            next=begin,
            failed=failed,
            place=scope.place(path),
            expected=step.on_failure is not None,
            handled=scope.handles_failures,
            call=source.mission.mission,
        )
        self.compiler.begin(inside, source.mission.start, begin)
        for name, end in source.mission.ends.items():
            self.compiler.assembly.mark(inside.targets[name])
            message = f"{source.mission.mission}: {_message_of(end, name, inside)}"
            if end.succeed is not None:
                self._emit(out.Say, level="info", message=message, next=after)
            else:
                self._emit(out.Raise, message=message, failed=failed, place=scope.place(path))
        self.compiler.phases(inside)
