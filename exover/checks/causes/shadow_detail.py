"""Details of findings that no step does something: rules that decide instead, conditions that never change."""

from collections.abc import Collection, Iterator

from exover.checks.causes.broken_finding import SHADOWS, BrokenFinding, decide_text, forbid_text, listed, never_launched
from exover.checks.causes.cause_wording import beyond_capacity
from exover.checks.causes.excluded import kept
from exover.checks.causes.shadowing import Shadowing
from exover.checks.questions.idle_guard import NEVER as UNDECIDING
from exover.checks.questions.idle_guard import UNCALLED as UNDEMANDED
from exover.checks.questions.rule_use import ADVICE, CAREFUL, NEVER, SILENT, UNCALLED, standing
from exover.checks.questions.rule_use import VIOLATED as UNNAMED
from exover.model.expression import Cond, Past, Status
from exover.model.kleene import truth
from exover.model.model import Model, Parameter, marks_of
from exover.model.property import Label
from exover.model.ranges import Ranges
from exover.model.reads import reads


def of_rule_use(broken: BrokenFinding) -> str:
    """Return why no answer names the subject, with what engines add to the text of the check."""
    return f"{_unnamed(broken)}{broken.finding.message.removeprefix(UNNAMED)}"


def _unnamed(broken: BrokenFinding) -> str:
    """Return why a rule never acts: ranges, assumptions or rules that decide first; or that it decides silently."""
    model, name = broken.model, broken.finding.subject
    stands = standing(model, broken.verdicts, name)
    shadowing = broken.near.of(name) if broken.near else Shadowing()
    if stands == "silent":
        where = [f"where an answer would name it, {decide_text(shadowing.rules)}"] if shadowing.rules else []
        return "; ".join([SILENT, *where, _taken_out(broken)])
    ranges = Ranges(model)
    found = [each for condition, params in _conditions_of(model, name) for each in ranges.decided(condition, params)]
    never, one, advice = (NEVER, "it", ADVICE) if stands == "idle" else (UNNAMED, "one", CAREFUL)
    if shadowing.forbids is not None and not found:
        return f"{never}, since {forbid_text(shadowing.forbids)} the steps in which {one} would"
    causes = list(map(str, dict.fromkeys(found)))
    causes += never_launched(broken, _settled_by(broken, name))
    causes += list(kept(model, name)) or _before(shadowing, one)
    if shadowing.unassumed and not causes:
        causes.append(f"without the assumptions, {listed(shadowing.unassumed)} would decide in its place")
    if stands == "idle" and not causes:
        causes.append(UNCALLED)
    return "; ".join([f"{never}: {'; '.join(causes)}" if causes else never, advice])


def _before(shadowing: Shadowing, one: str) -> list[str]:
    """Return, as at most one part of a sentence, the rules that decide where one that never acts would."""
    first, *others = shadowing.in_turn or (None,)
    if first is None:
        return [f"where {one} would, {decide_text(shadowing.rules)}"] if shadowing.rules else []
    return [", ".join([f"where {one} would, {decide_text([first])}", *(f"and without it `{each}`" for each in others)])]


def _taken_out(broken: BrokenFinding) -> str:
    """Return what it would change to take out a rule that decides silently."""
    match broken.verdicts.get(("redundancy", broken.finding.subject)):
        case "violated":
            return ADVICE
        case "holds":
            return "to take it out changes decisions"
        case _:
            return "to take it out may change decisions"


def _conditions_of(model: Model, name: str) -> Iterator[tuple[Cond, tuple[Parameter, ...]]]:
    """Yield the conditions of the guards, rules and launch rules of a name, each with the parameters it may read."""
    for request in model.requests:
        yield from ((guard.condition, request.params) for guard in request.guards if guard.name == name)
    for rule in model.rules_named(name):
        yield rule.condition, model.request[rule.slot_of].params if rule.slot_of else ()
    yield from ((each.condition, ()) for each in model.launches if each.name == name)


def _settled_by(broken: BrokenFinding, rule: str) -> Iterator[str]:
    """Yield the active or past requests that a rule's condition reads, if those that no run launches fix its value."""
    for condition, _ in _conditions_of(broken.model, rule):
        if _is_settled(condition, broken.unlaunched):
            yield from (each.name for each in sorted(reads(condition)) if each.kind in ("active", "past"))


def _is_settled(condition: Cond, unlaunched: Collection[str]) -> bool:
    """Return whether a condition has a fixed value, given that some requests are never active and have no past."""

    def known(part: Cond) -> bool | None:
        match part:
            case Status("active" | "running" | "stopping", request) | Past(request) if request in unlaunched:
                return False
            case _:
                return None

    return truth(condition, known) is not None


def of_redundancy(broken: BrokenFinding) -> str:
    """Return the message of the finding, with the rules that decide in the place of the redundant one."""
    rules = broken.near.instead_of(broken.finding.subject) if broken.near else ()
    return "; ".join([broken.finding.message, *([f"in its place {decide_text(rules)}"] if rules else [])])


def of_idle_guard(broken: BrokenFinding) -> str:
    """Return what the guard or remedy never does, with the remedy before it that always applies."""
    label, _ = broken.model.demands[broken.finding.subject]
    before = _certain_before(broken.model, label)
    if before is not None:
        return f"{UNDECIDING}: `{before}` stands before it, and always applies"
    killed = f"no run kills `{label[2]}` for this rule, or gives it up while it waits" if label[0] == "kill" else ""
    return f"{killed or UNDECIDING}: {UNDEMANDED}"


def of_reachability(broken: BrokenFinding) -> str:
    """Return the message of the finding, with what keeps the request from any launch."""
    shadowing = broken.near.before_launch(broken.finding.subject) if broken.near else Shadowing()
    request = broken.model.request[broken.finding.subject]
    ranges = Ranges(broken.model)
    found = [each for guard in request.guards for each in ranges.decided(guard.condition, request.params)]
    parts = [broken.finding.message, *(str(each) for each in dict.fromkeys(found) if not each.truth)]
    parts += beyond_capacity(broken.model, request)
    if shadowing.rules:
        parts.append(f"it is kept from a launch by {listed(shadowing.rules)}")
    if shadowing.alone:
        without = " or without ".join(f"`{each}`" for each in shadowing.alone[:SHADOWS])
        forbidden = "there" if shadowing.forbids is None else f"only in steps that {forbid_text(shadowing.forbids)}"
        parts.append(f"without {without} it would be launched {forbidden}")
        settled = (name for rule in shadowing.alone[:SHADOWS] for name in _settled_by(broken, rule))
        parts += never_launched(broken, (name for name in settled if name != request.name))
    elif shadowing.forbids is not None:
        parts.append(f"it would be launched only in steps that {forbid_text(shadowing.forbids)}")
    return "; ".join(parts)


def _certain_before(model: Model, label: Label) -> str | None:
    """Return the `reject` or `wait` that stands before a remedy wherever its name is written, else None.

    Both always apply, so that no remedy behind them is taken.
    """
    written = [marks_of(each.name, each.remedies, each.slot_of) for each in model.rules_named(label[1])]
    written += [marks_of(each.name, each.remedies, None) for each in model.resources if each.name == label[1]]
    found = set[str | None]()
    for labels in ([each for _, each in remedies] for remedies in written):
        if label in labels:
            before = (each[0] for each in labels[: labels.index(label)] if each[0] != "kill")
            found.add(next(before, None))
    return found.pop() if len(found) == 1 else None
