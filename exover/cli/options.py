"""Options that several verbs share, each set added to a parser, and the words that options may have as values."""

import argparse

from exover.cli.parsing import Lists
from exover.cli.values import USUAL_JOBS, cores, jobs, mebibytes, names, seconds

RUN_ENGINES = ("reference", "tables", "c", "rust")
CHECK_ENGINES = ("auto", "aig", "bdd", "z3", "nusmv", "all")
TRACE_FORMATS = ("text", "json", "svg", "vcd")
DIFF_FORMATS = ("text", "json", "sarif", "markdown")
AUDIT_FORMATS = ("text", "json", "sarif")
GRAPH_FORMATS = ("dot", "svg", "mermaid")
EDGES = Lists(("excludes", "interrupts", "shares", "constrains", "launches", "wakes", "sets"))
SHELLS = ("bash", "zsh", "fish")
TARGETS = Lists(("c", "rust", "bin", "json", "dot", "smt2", "smv", "aiger"))


def choice_of_checks(verb: argparse.ArgumentParser) -> None:
    """Add the options that choose the checks to ask."""
    for option, what in (("only", "ask these checks alone"), ("skip", "do not ask these checks")):
        verb.add_argument(
            f"--{option}", metavar="CHECK[,…]", type=names, action="extend", default=[], help=f"{what}, or severities"
        )
    verb.add_argument("--errors-only", action="store_true", help="ask only checks whose violation is an error")


def judging(verb: argparse.ArgumentParser) -> None:
    """Add the options for engines, and for which findings count."""
    verb.add_argument("--deny", choices=("warnings",), help="let warnings decide the verdict and the exit status, too")
    verb.add_argument("--baseline", metavar="FILE", help="a former JSON report: warnings and notes in it do not count")
    verb.add_argument("--config", metavar="FILE", help="the waivers (default: exover.toml beside or above the spec)")
    verb.add_argument(
        "--engine", choices=CHECK_ENGINES, default="auto", help="who answers; all: every one, compared (default: auto)"
    )
    verb.add_argument(
        "--abc",
        metavar="PATH",
        help="Berkeley ABC, several times faster on large specs; none: the embedded solver (default: looked for)",
    )
    verb.add_argument("--nusmv", metavar="PATH", help="the program for --engine nusmv and all (default: looked for)")


def which_finding(verb: argparse.ArgumentParser) -> None:
    """Add the options that choose a finding of a report."""
    verb.add_argument("--check", metavar="CHECK", help="a finding of this check")
    verb.add_argument("--subject", metavar="SUBJECT", help="a finding about this request, rule or property")


def limits(verb: argparse.ArgumentParser) -> None:
    """Add the options of every verb that checks: the properties file, and the resources."""
    verb.add_argument(
        "--properties",
        metavar="FILE",
        help="the properties (default: the .prop file of the spec, beside it, in properties/ or in ../properties/)",
    )
    resources(verb)


def resources(verb: argparse.ArgumentParser) -> None:
    """Add the limits of a verb: time, processes, memory."""
    verb.add_argument("--timeout", metavar="SECONDS", type=seconds, help="what is not answered by then is unknown")
    verb.add_argument(
        "--jobs",
        metavar="N",
        type=jobs,
        default=cores(),
        help=f"look for answers in N processes (default: one for each core, at most {USUAL_JOBS})",
    )
    verb.add_argument("--memory", metavar="MIB", type=mebibytes, help="memory that each of them may take (Linux)")
