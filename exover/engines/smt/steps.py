"""Whole steps: the state after every event as terms over the state before it and the event's values.

A step is an update and then passes of steps 3 to 5 until nothing changes. While the terms are made, Z3 decides which
components of a pass (a rule, a required launch, the settling of a request) have to run, and how often. A component is
due if a variable that it reads may have changed since it last ran or, if it is spontaneous, at the beginning. It is
left out only if Z3 proves that it would change nothing, whatever the state between steps in which the step began. The
terms end when no component is due, so they describe the step exactly, without a bound or an approximation.
"""

from collections.abc import Callable
from dataclasses import field
from functools import cached_property

from exover.dataclass import dataclass
from exover.engines.smt.solver import Prover
from exover.loop.exact.actions import TableActions, fallen, tried
from exover.loop.exact.events import Kind, kinds, parameters, parts, update
from exover.loop.exact.layout import sort_of
from exover.loop.exact.symbolic_state import Note, SymbolicState
from exover.loop.exact.term import Term, variables
from exover.model.model import Parameter
from exover.model.property import Label


@dataclass(frozen=True, slots=True)
class Input:
    """A value that comes with an event: the variable that stands for it, and that it lies in its domain."""

    var: Term
    parameter: Parameter
    domain: Term


@dataclass(frozen=True, slots=True)
class SymbolicStep:
    """A kind of event, when it can happen, and what every variable that it may change is afterwards."""

    kind: Kind
    inputs: tuple[Input, ...]
    enabled: Term
    after: dict[str, Term]
    marks: dict[Label, Term]
    notes: tuple[Note, ...]


@dataclass(frozen=True, slots=True)
class SymbolicComponent:
    """A part of a pass: what it does to a symbolic state, and the variables that it reads."""

    name: str
    run: Callable[[SymbolicState], None]
    reads: frozenset[str]


@dataclass
class SymbolicSteps:
    """The steps of a closed loop."""

    actions: TableActions
    prover: Prover
    unstable: dict[str, Term] = field(default_factory=dict)
    """Maps a component to the condition that it is unstable, which is false in every state between steps."""
    invariants: tuple[Term, ...] = ()
    """Further invariants of the states between steps, found by Houdini."""
    looked: bool = False
    """Whether such invariants have been searched."""
    _made: dict[Kind, SymbolicStep] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.layout, self.terms, self.model = self.actions.layout, self.actions.terms, self.actions.model
        memory = [tried(number) for number in range(len(self.model.launches))]
        memory += [fallen(request.name) for request in self.model.requests]
        self.present = dict(self.layout.vars)
        self.start = dict.fromkeys(memory, self.terms.false)
        self._memory = {name: self.terms.var(name, "Bool") for name in memory}
        self.components = [self._component(part.name, part.run) for part in parts(self.actions)]
        self.spontaneous = {each.name for each in self.components if self._is_spontaneous(each)}

    # ---- components ----

    def _component(self, name: str, run: Callable[[SymbolicState], None]) -> SymbolicComponent:
        frame = SymbolicState(self.terms, self.present | self._memory)
        run(frame)
        before = self.present | self._memory
        guards = (note.guard for note in frame.notes)
        changed = [*frame.all(frame.written(before)), *frame.marks.values(), *guards]
        return SymbolicComponent(name, run, frozenset(var.name for var in variables(changed)))

    def _is_spontaneous(self, component: SymbolicComponent) -> bool:
        """Return whether a component may do something in a step that changed nothing it reads; remember when it is not.

        It may, if it would do something at the start, or if it reads what a step remembers and then forgets. At the
        end of a step it does nothing, whatever was remembered, which is then all that is known of it.
        """
        memory = sorted(component.reads & self.start.keys())
        unstable = self._unstable(component, self.start)
        if memory:
            unstable = self.terms.both((unstable, self._unstable(component, dict.fromkeys(memory, self.terms.true))))
        initial = {self.layout.vars[name]: value for name, value in self.layout.initial.items()}
        fresh = self.terms.replaced(unstable, initial) is not self.terms.false
        if not fresh:
            self.unstable[component.name] = unstable
        return fresh or bool(memory)

    def _unstable(self, component: SymbolicComponent, memory: dict[str, Term]) -> Term:
        """Return where a component would change the state if the step remembers this.

        No argument is moved without a flag that changes as well, so that flags alone are looked at.
        """
        before = SymbolicState(self.terms, self.present | self.start | memory)
        after = before.copy()
        component.run(after)
        flags = self.present.keys() - self.layout.held
        return self.terms.either(where for name, where in after.changed(before).items() if name in flags)

    # ---- what is true between steps ----

    @cached_property
    def lemmas(self) -> tuple[Term, ...]:
        """What is true of every state between steps: values lie in their domains, and every component is stable."""
        stable = [self.terms.negation(term) for term in self.unstable.values()]
        parts = [*self.layout.domains.values(), *self.layout.sound.values(), *stable]
        return tuple(part for part in parts if part is not self.terms.true)

    # ---- steps ----

    @cached_property
    def all(self) -> tuple[SymbolicStep, ...]:
        """The steps of all kinds of events."""
        for kind in self.kinds:
            if kind not in self._made:  # what was made before the time was over stays
                self._made[kind] = self._step(kind)
        return tuple(self._made.values())

    @cached_property
    def kinds(self) -> tuple[Kind, ...]:
        """The kinds of events."""
        return tuple(kinds(self.model, self.actions.may_wait))

    def inputs(self, kind: Kind) -> tuple[Input, ...]:
        """Return the values that an event of this kind brings."""
        declared = parameters(self.model, kind)
        vars_ = [self.terms.var(f"{kind.verb} {kind.name}: {p.name}", sort_of(p.type)) for p in declared]
        pairs = zip(vars_, declared, strict=True)
        return tuple(Input(var, p, self.layout.domain(p.type, var)) for var, p in pairs)

    def _step(self, kind: Kind) -> SymbolicStep:
        inputs = self.inputs(kind)
        frame = SymbolicState(self.terms, self.present | self.start)
        before = frame.copy()
        possible = update(self.actions, frame, kind, tuple(each.var for each in inputs))
        enabled = self.terms.both((possible, *(each.domain for each in inputs)))
        self._settle_down(frame, enabled)
        changed = {name: frame[name] for name in frame.written(before.values) if name in self.present}
        return SymbolicStep(kind, inputs, enabled, changed, frame.marks, tuple(frame.notes))

    def _settle_down(self, frame: SymbolicState, enabled: Term) -> None:
        """Run passes until no component is due: then nothing changes any more."""
        touched = frame.written(self.present | self.start)
        due = {c.name for c in self.components if c.name in self.spontaneous or not c.reads.isdisjoint(touched)}
        while due:
            for component in self.components:
                if component.name not in due:
                    continue
                due.discard(component.name)
                after = frame.copy()
                component.run(after)
                changed = after.changed(frame)
                frame.marks, frame.notes = after.marks, after.notes
                if changed and self._possible(enabled, changed):
                    frame.values = after.values
                    due |= {c.name for c in self.components if c.reads & changed.keys()}

    def _possible(self, enabled: Term, changed: dict[str, Term]) -> bool:
        moved = self.terms.either(changed.values())
        return self.prover.satisfiable((enabled, moved), self.lemmas)
