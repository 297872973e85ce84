"""`exover swap`: prove that the tables of one spec may take over from those of another, and write the map."""

import argparse

from exover.cli.check import STATUS
from exover.cli.files import read_spec, refuse_unwritable, shown, write_one
from exover.cli.status import ExitStatus
from exover.cli.streams import ProgressLine, complain, out
from exover.escaping import visible_lines
from exover.limits import Limits, TimeUp, interrupted, limits_from
from exover.loop.claim import Verdict
from exover.model.property import Properties, Property
from exover.pipeline import Build, build, property_findings, swap
from exover.swap.prove import SwapAnswer


def run(arguments: argparse.Namespace) -> int:
    """Print what was proved, write the map if NEW may take over, and return the status of the verdict."""
    refuse_unwritable(arguments.out)
    limits = limits_from(arguments.started, arguments.jobs, arguments.timeout, arguments.memory)
    try:
        with ProgressLine() as progress:
            with interrupted(limits, of_memory=True):
                old, new = (build(read_spec(path)) for path in (arguments.old, arguments.new))
            progress("rules")
            content, answer = swap(old, new, lambda asked: _verdicts(old, asked, limits, progress))
    except TimeUp:
        complain(f"exover: error: {limits.reason}: nothing is written")
        return ExitStatus.UNKNOWN
    out(_told(answer, shown(arguments.old), shown(arguments.new)))
    if answer.verdict != "holds":
        complain("exover: error: no map is written")
        return STATUS[answer.verdict]
    out("".join(f"{path}\n" for path in write_one(arguments.out, content)))
    return ExitStatus.OK


def _verdicts(old: Build, asked: tuple[Property, ...], limits: Limits, progress: ProgressLine) -> dict[str, Verdict]:
    if limits.left <= 0:
        raise TimeUp
    findings = property_findings(old, Properties(asked), progress, limits)
    return {finding.subject: finding.verdict for finding in findings}


def _told(answer: SwapAnswer, old: str, new: str) -> str:
    """Return the answer in words."""
    others = "" if answer.asked == answer.rules else "; what NEW starts with breaks no other"
    lines = [f"{old} -> {new}: {answer.asked} of {answer.rules} rules of NEW asked of every state{others}"]
    for name, rules in answer.ended.items():
        why = f"for {', '.join(rules)}" if rules else "it is another there, or not there"
        lines.append(f"has to end first: {name} ({why})")
    lines += [f"starts anew: {name}" for name in answer.forgotten]
    lines += [f"may be broken, whatever has ended: {name}" for name in answer.open]
    if answer.verdict == "holds":
        when = "once these requests have ended" if answer.ended else "at any time"
        lines.append(f"{new} may take over {when}")
    return visible_lines(lines)
