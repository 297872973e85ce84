"""Why the last event of a stream was answered as it was, and counterfactuals: changes that change the answer."""

from collections.abc import Iterable, Mapping

from exover.explain.counterfactuals import search
from exover.explain.recorder import Cause, Decided, Recovered, Watched, watch
from exover.explain.verdicts import RuleVerdicts
from exover.model.event import Action, Event, Invalid, Killed, Launched, Observe, Rejected, Report, Violated, Waits
from exover.model.explanation import Account, Explanation, RuleVerdict
from exover.model.model import Location, Model
from exover.model.reads import Read, reads, rule_reads
from exover.model.semantics import Reference
from exover.model.wire_reading import is_blank, read_event


def explain(model: Model, written: Mapping[Location, str], lines: Iterable[str | bytes]) -> Explanation | None:
    """Return the explanation of the answer to the last line that is not blank; None if there is none.

    `written`: the text of each item in the spec, by location. Lines before are answered as in a simulation.
    """
    reference = Reference(model)
    state = before = reference.start()
    step, events, last = 0, 0, None
    for line in lines:
        if is_blank(line):
            continue
        step, before, last = step + 1, state, read_event(model, line)
        events += not (isinstance(last, Invalid) and last.is_unread)
        if not isinstance(last, Invalid):
            state, _ = reference.step(state, last)
    if last is None:
        return None
    if isinstance(last, Invalid):
        return Explanation(step, None, (last,), (_invalid(last),), events=events)
    fault = reference.validate(before, last)
    if fault:
        return Explanation(step, last, (fault,), (_invalid(fault),), events=events)
    watched = watch(reference, before, last)
    actions = tuple(action for action, _ in watched.actions)
    if actions and before.refused:
        watched = watch(reference, before.unrefused(), last)
    unanswered = tuple(action for action, _ in watched.actions if action not in actions)
    accounts = accounts_of(RuleVerdicts(reference, written), watched)
    spoken = {verdict.rule for account in accounts for verdict in account.deciding}
    spoken |= {verdict.rule for account in accounts for verdict in account.others if verdict.demand != "nothing"}
    found = search(reference, before, last, sorted(spoken))
    return Explanation(step, last, actions, accounts, found, unanswered, events)


def _invalid(fault: Invalid) -> Account:
    detail = f": {fault.detail}" if fault.detail else ""
    return Account(fault, f"the event cannot be taken{detail}; the state is as it was")


def accounts_of(verdicts: RuleVerdicts, watched: Watched) -> tuple[Account, ...]:
    """Return the account of each action of a step; of a step without actions, the account of why there are none."""
    if not watched.actions:
        return (_no_action(verdicts, watched),)
    return tuple(_account(verdicts, watched, action, cause) for action, cause in watched.actions)


def _account(verdicts: RuleVerdicts, watched: Watched, action: Action, cause: Cause | None) -> Account:
    match action, cause:
        case Invalid(_, detail), _:
            return Account(action, f"the reading is outside its domain and is {detail}, the poster's `else` value")
        case Violated(rule), _:
            return Account(
                action,
                "the rule is broken and no remedy restores it",
                verdicts.of_violation(watched.after, rule),
            )
        case Rejected(name, "busy"), Decided():
            return Account(action, f"every slot of {name} is taken, and it does not interrupt itself")
        case Rejected(name, "busy"), _:
            return Account(action, f"something stands in the waiting place of {name}, which does not interrupt itself")
        case Rejected(_, "superseded"), _:
            return Account(action, "a newer ask takes its waiting place")
        case Rejected() | Killed(), None:
            return Account(action, "the decisional level has given it up")
        case Killed(), Recovered():
            return Account(action, "a rule was broken, and this restores it", verdicts.of_recovery(cause))
        case ((Launched() | Waits() | Rejected() | Killed()), Decided()):
            return _decided(verdicts, action, cause)
        case _:
            raise AssertionError(f"{action} has no cause")


def _decided(verdicts: RuleVerdicts, action: Launched | Waits | Rejected | Killed, decided: Decided) -> Account:
    """Return the account of an action that follows from a decision."""
    found = verdicts.of_decision(decided)
    launch = (verdicts.of_launch(decided.required, decided.state),) if decided.required else ()
    place = ", decided again in its waiting place" if decided.again else ""
    newcomer = decided.request.name
    if isinstance(action, Launched):
        said = f"no guard, resource or rule in question objects to it{place}"
        return Account(action, said, launch, found)
    deciding = _deciding(found, action, decided)
    others = tuple(verdict for verdict in found if verdict not in deciding and verdict.demand != "nothing")
    match action:
        case Rejected(name) if name != newcomer:
            said = f"{newcomer} is launched over it{place}"
        case Rejected():
            said = f"what any guard, resource or rule rejects is rejected{place}"
        case Killed():
            said = f"it is in the way of {newcomer}{place}"
        case Waits() if decided.decision.verdict == "clear":
            said = "its way is being cleared"
        case Waits():
            said = "it has to wait"
    return Account(action, said, launch + deciding, others)


def _deciding(
    found: tuple[RuleVerdict, ...], action: Waits | Rejected | Killed, decided: Decided
) -> tuple[RuleVerdict, ...]:
    """Return the verdict that is the reason of an action; empty if none is."""
    if isinstance(action, Rejected):
        demand = "reject" if action.request == decided.request.name else "dismiss"
    else:
        demand = "clear" if isinstance(action, Killed) else decided.decision.verdict
    return tuple(verdict for verdict in found if verdict.rule == action.rule and verdict.demand == demand)[:1]


# ---- nothing was done ----


def _no_action(verdicts: RuleVerdicts, watched: Watched) -> Account:
    """Return why an event had no action: the verdicts of all that reads what it changed, waits, or was refused."""
    model, event = verdicts.reference.model, watched.event
    touched = _touched(event)
    rules = [rule.name for rule in model.rules if rule_reads(rule) & touched]
    launches = [launch for launch in model.launches if reads(launch.condition) & touched]
    others = verdicts.of_rules(watched.after, rules) + tuple(
        verdicts.of_launch(each, watched.after) for each in launches
    )
    waiting = [request for request in model.requests if watched.after.places[request.name]]
    for request in waiting:
        place = watched.after.places[request.name]
        if place:
            decision = verdicts.reference.decide(watched.after, request, place.args)
            found = verdicts.of_decision(Decided(watched.after, request, place.args, decision))
            others += tuple(verdict for verdict in found if verdict.demand != "nothing")
    refused = [launch for launch in model.launches if launch.name in watched.after.refused]
    for launch in refused:
        request = model.request[launch.request]
        decision = verdicts.reference.decide(watched.after, request, launch.args)
        found = verdicts.of_decision(Decided(watched.after, request, launch.args, decision, launch))
        others += tuple(verdict for verdict in found if verdict.demand != "nothing")
    said = "no rule that reads what has changed is broken"
    said += f"; {', '.join(request.name for request in waiting)} still cannot start" if waiting else ""
    said += f"; what {', '.join(launch.name for launch in refused)} requires is refused as before" if refused else ""
    return Account(None, said, (), others)


def _touched(event: Event) -> frozenset[Read]:
    """Return the reads of conditions that an event itself changes."""
    match event:
        case Observe(name):
            return frozenset({Read("reading", name), Read("level", name)})
        case Report(name):
            return frozenset({Read(kind, name) for kind in ("active", "past", "last")})
        case _:
            return frozenset()
