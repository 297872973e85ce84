"""The arguments of the command `exover`, verb by verb."""

import argparse
import os

from exover import __version__
from exover.cli.options import (
    AUDIT_FORMATS,
    DIFF_FORMATS,
    EDGES,
    GRAPH_FORMATS,
    RUN_ENGINES,
    SHELLS,
    TARGETS,
    TRACE_FORMATS,
    choice_of_checks,
    judging,
    limits,
    resources,
    which_finding,
)
from exover.cli.parsing import Parser, Verbs
from exover.cli.values import REPORT_FORMATS, USUAL_JOBS, cores, domain, jobs, limit, output, renaming, seconds

WITHOUT_OPTIONS = {
    "certificate": None,
    "count": False,
    "bounds": False,
    "max_tests": None,
    "max_rom": None,
    "max_ram": None,
    "no_cache": True,
}
"""The options of `check` that `report` lacks, with the values that it has for them."""


def parser() -> argparse.ArgumentParser:
    """Return the parser of all verbs; `verb` is the one that is called."""
    found = Parser(prog="exover", description="Formal verification of robot safety rules.")
    found.add_argument("-V", "--version", action="version", version=f"exover {__version__}")
    verbs: Verbs = found.add_subparsers(dest="verb", metavar="VERB", required=True)
    for add in (
        _init,
        _import,
        _check,
        _report,
        _verify,
        _simulate,
        _serve,
        _replay,
        _trace,
        _explain,
        _graph,
        _emit,
        _diff,
        _swap,
        _gate,
        _audit,
        _fmt,
        _lsp,
        _doctor,
        _docs,
        _completion,
        _help,
    ):
        add(verbs)
    return found


def _init(verbs: Verbs) -> None:
    init = verbs.add_parser("init", help="begin a project: a spec that checks, properties, events")
    init.add_argument(
        "folder", metavar="DIR", nargs="?", default=".", help="the folder to write to (default: this one)"
    )


def _check(verbs: Verbs) -> None:
    check = verbs.add_parser("check", help="decide whether a spec is safe, complete and live")
    check.add_argument("specs", metavar="SPEC", nargs="+", help="specs, .exo files; folders of them; or -")
    check.add_argument(
        "--changed", action="store_true", help="SPEC are changed files: a part stands for the specs that include it"
    )
    check.add_argument(
        "--format", choices=REPORT_FORMATS, default="text", help="how findings are printed (default: text)"
    )
    check.add_argument(
        "--output",
        metavar="FORMAT=FILE",
        type=output,
        action="append",
        default=[],
        help="write the findings to a file as well; may be given several times",
    )
    check.add_argument("--certificate", metavar="FILE", help="write proofs of the findings, which verify checks anew")
    choice_of_checks(check)
    judging(check)
    check.add_argument("--count", action="store_true", help="count the reachable states")
    check.add_argument("--bounds", action="store_true", help="print what events and calls cost at most")
    for option, what in (("tests", "tests for one event"), ("rom", "bytes of tables"), ("ram", "bytes of memory")):
        metavar = "N" if option == "tests" else "B"
        check.add_argument(f"--max-{option}", metavar=metavar, type=limit, help=f"status 1 if it takes more {what}")
    check.add_argument("--timings", action="store_true", help="print the seconds that each check took")
    check.add_argument("--watch", action="store_true", help="check again whenever a file changes, until Ctrl-C")
    check.add_argument("--no-cache", action="store_true", help="neither use nor keep former reports and answers")
    check.set_defaults(module="recall", watched=False)
    limits(check)


def _report(verbs: Verbs) -> None:
    report = verbs.add_parser("report", help="check a spec and write a page: findings, diagrams, a simulator")
    report.add_argument("spec", metavar="SPEC", help="the spec, an .exo file; or -")
    report.add_argument("--out", metavar="FILE", required=True, help="the file to write to, as report.html")
    report.add_argument("--audit", metavar="FILE", help="an audit of missions as JSON, shown in the page; or -")
    choice_of_checks(report)
    judging(report)
    limits(report)
    report.set_defaults(**WITHOUT_OPTIONS)


def _verify(verbs: Verbs) -> None:
    verify = verbs.add_parser("verify", help="check proofs anew, or that tables are rules")
    verify.add_argument("file", metavar="FILE", help="a certificate; or tables, as bytes or as C or Rust source")
    verify.add_argument(
        "--table", metavar="TABLE", help="the tables that the certificate is about, as bytes or C or Rust source"
    )
    verify.add_argument("--spec", metavar="SPEC", help="the spec that the tables were made of, an .exo file")
    verify.add_argument("--properties", metavar="FILE", help="the properties (default: as for check)")
    verify.add_argument(
        "--timeout", metavar="SECONDS", type=seconds, default=60.0, help="for one implication (default: 60)"
    )
    verify.add_argument("--strict", action="store_true", help="status 1 if the proof that something is safe is missing")


def _simulate(verbs: Verbs) -> None:
    simulate = verbs.add_parser("simulate", help="answer events, one JSON object a line")
    simulate.add_argument("spec", metavar="SPEC", help="the spec, an .exo file; or -")
    simulate.add_argument("--events", metavar="FILE", default="-", help="the events; - is standard input, the default")
    simulate.events = "--events"
    simulate.add_argument("--engine", choices=RUN_ENGINES, default="reference", help="who answers (default: reference)")


def _replay(verbs: Verbs) -> None:
    replay = verbs.add_parser("replay", help="tell what a black box holds, and answer it again")
    replay.add_argument("box", metavar="BOX", help="a copy of the memory of the box; or -")
    replay.add_argument(
        "spec", metavar="SPEC", nargs="?", help="its spec (default: that of its sha256 at or below here)"
    )
    replay.add_argument("--events", metavar="FILE", help="write the events of its last run to a file")
    replay.add_argument("--after", metavar="FILE", help="the events from loading on, if the box begins later; or -")


def _trace(verbs: Verbs) -> None:
    trace = verbs.add_parser("trace", help="tell the run that a finding shows")
    trace.add_argument(
        "finding", metavar="FINDING", help="what check --format json printed, or one finding of it; or -"
    )
    trace.add_argument("--format", choices=TRACE_FORMATS, default="text", help="how the run is told (default: text)")
    which_finding(trace)
    trace.add_argument("--spec", metavar="SPEC", help="the spec, if it is no longer where the report says")
    trace.add_argument("--out", metavar="FILE", help="the file to write to (default: standard output)")


def _explain(verbs: Verbs) -> None:
    explain = verbs.add_parser("explain", help="say why an event was answered so, or what a check or error code means")
    explain.add_argument(
        "spec",
        metavar="SPEC",
        nargs="?",
        help="the spec, an .exo file; or -; of a report, its own; or a check or code, as E307",
    )
    explain.add_argument("--events", metavar="FILE", help="the events; - is standard input, the default")
    explain.events = "--events"
    explain.add_argument(
        "--finding", metavar="REPORT", help="a step of a counterexample in what check --format json printed; or -"
    )
    which_finding(explain)
    explain.add_argument("--step", metavar="N", type=limit, help="this step of it (default: the last)")
    explain.add_argument("--format", choices=("text", "json"), default="text", help="how it is said (default: text)")


def _graph(verbs: Verbs) -> None:
    graph = verbs.add_parser("graph", help="draw who excludes whom, launches whom and wakes whom")
    graph.add_argument("spec", metavar="SPEC", help="the spec, an .exo file; or -")
    graph.add_argument("--format", choices=GRAPH_FORMATS, default="dot", help="svg is drawn by Graphviz (default: dot)")
    graph.add_argument(
        "--only",
        metavar="EDGE[,…]",
        choices=EDGES,
        action="append",
        default=[],
        help=f"draw these edges alone: {', '.join(EDGES)}",
    )
    graph.add_argument("--out", metavar="FILE", help="the file to write to (default: standard output)")


def _diff(verbs: Verbs) -> None:
    diff = verbs.add_parser("diff", help="say which answers a change of a spec changes")
    diff.add_argument("old", metavar="OLD", help="the spec as it was, an .exo file; or -")
    diff.add_argument("new", metavar="NEW", nargs="?", help="the spec as it is, or - (with --against: default OLD)")
    diff.add_argument("--against", metavar="REV", help="take OLD, and its properties, from this git revision")
    diff.add_argument("--properties", metavar="FILE", help="the properties of both, with --against of NEW alone")
    diff.add_argument("--old-properties", metavar="FILE", help="the properties of OLD")
    diff.add_argument(
        "--rename",
        metavar="OLD=NEW",
        type=renaming,
        action="append",
        default=[],
        help="a request of OLD is called otherwise in NEW; may be given several times",
    )
    diff.add_argument(
        "--deny-weaker", action="store_true", help="status 1 if NEW launches what OLD refuses or lets wait"
    )
    diff.add_argument("--format", choices=DIFF_FORMATS, default="text", help="how it is printed (default: text)")
    diff.add_argument("--out", metavar="FILE", help="the file to write to (default: standard output)")
    diff.add_argument("--abc", metavar="PATH", help="Berkeley ABC; none: the embedded solver (default: looked for)")
    resources(diff)


def _swap(verbs: Verbs) -> None:
    swap = verbs.add_parser("swap", help="prove that a spec may take over from another while requests run")
    swap.add_argument("old", metavar="OLD", help="the spec whose tables run, an .exo file")
    swap.add_argument("new", metavar="NEW", help="the spec whose tables shall run, an .exo file")
    swap.add_argument("--out", metavar="MAP", required=True, help="the file to write the map to, for exover_swap")
    resources(swap)


def _emit(verbs: Verbs) -> None:
    emit = verbs.add_parser("emit", help="check a spec and write its tables")
    emit.add_argument("spec", metavar="SPEC", help="the spec, an .exo file; or -")
    emit.add_argument(
        "--target",
        metavar="TARGET[,…]",
        choices=TARGETS,
        action="append",
        required=True,
        help="C sources (c), a Rust crate (rust), the bytes alone (bin), json, a drawing (dot); or what is asked, for "
        "Z3 (smt2), NuSMV (smv) or ABC (aiger)",
    )
    emit.add_argument(
        "--out",
        metavar="DIR",
        required=True,
        help="the folder to write to",
    )
    emit.add_argument("--unchecked", action="store_true", help="emit even what is not safe; the tables will say so")
    limits(emit)


def _gate(verbs: Verbs) -> None:
    gate = verbs.add_parser("gate", help="stand between clients and the modules of a robot")
    sides: Verbs = gate.add_subparsers(dest="side", metavar="PROTOCOL", required=True)
    check = sides.add_parser("check", help="say what is wrong with a binding")
    mcp = sides.add_parser("mcp", help="stand between an MCP client and an MCP server")
    ros2 = sides.add_parser("ros2", help="stand between clients and servers of ROS 2 (extra exover[ros2])")
    for side in (check, mcp, ros2):
        stdin = "" if side is mcp else "; or -"
        side.add_argument("spec", metavar="SPEC", help=f"the spec, an .exo file{stdin}")
        side.add_argument("--bind", metavar="BINDING", required=True, help=f"the binding, NAME.bind.toml{stdin}")
    for side in (mcp, ros2):
        side.add_argument("--log", metavar="FILE", help="append what is decided to a file, one JSON object a line")
        side.add_argument(
            "--otel", action="store_true", help="tell OpenTelemetry what is decided, as spans and counters"
        )
        side.add_argument("--unchecked", action="store_true", help="run even what is not safe")
    ros2.add_argument(
        "--interfaces",
        metavar="DIR",
        action="append",
        default=[],
        help="a folder of packages with their .action, .srv and .msg files; may be given several times",
    )
    ros2.add_argument("--domain", metavar="N", type=domain, help="the DDS domain (default: $ROS_DOMAIN_ID, else 0)")
    ros2.add_argument(
        "--inner-domain", metavar="N", type=domain, help="the domain of the servers (default: that of the clients)"
    )
    ros2.add_argument(
        "--decisions",
        metavar="TOPIC",
        type=str,  # as it is, even empty
        default="/exover/decisions",
        help="the topic of decisions, '' for none (default: %(default)s)",
    )
    mcp.add_argument(
        "server", metavar="SERVER", nargs="+", type=str, help="the command that starts the server, behind --"
    )


def _audit(verbs: Verbs) -> None:
    audit = verbs.add_parser("audit", help="ask what a spec would have said to recorded missions")
    audit.add_argument("spec", metavar="SPEC", help="the spec, an .exo file; or -")
    audit.add_argument("missions", metavar="MISSION", nargs="+", help="recorded missions, or folders of them; or -")
    audit.add_argument("--bind", metavar="BINDING", help="which topics of a bag are which requests, NAME.bind.toml")
    audit.add_argument("--format", choices=AUDIT_FORMATS, default="text", help="how it is printed (default: text)")
    audit.add_argument("--out", metavar="FILE", help="write each ask and divergence as Parquet (extra exover[audit])")
    audit.add_argument(
        "--jobs",
        metavar="N",
        type=jobs,
        default=cores(),
        help=f"audit N missions at once (default: the cores, at most {USUAL_JOBS})",
    )
    audit.add_argument(
        "--cluster", metavar="ADDRESS", help="spread them over a cluster of dask.distributed (extra exover[cluster])"
    )
    audit.add_argument(
        "--engine",
        choices=("auto", "c", "tables", "reference"),
        default="auto",
        help="who answers (default: auto, the emitted C if there is a compiler, else tables)",
    )


def _fmt(verbs: Verbs) -> None:
    fmt = verbs.add_parser("fmt", help="give specs and properties files the one canonical layout")
    fmt.add_argument("--check", action="store_true", help="write nothing; status 1 if a file would change")
    fmt.add_argument(
        "files",
        metavar="FILE",
        nargs="*",
        default=[os.curdir],
        help="files, folders with .exo and .prop files in them (default: this folder), or - for standard input",
    )


def _import(verbs: Verbs) -> None:
    found = verbs.add_parser("import", help="make a part of a spec of a GenoM3 description, or of files of ROS 2")
    found.set_defaults(verb="imports")
    found.add_argument("files", metavar="FILE", nargs="+", help="a .gen file; with --ros .action, .srv and .msg files")
    found.add_argument("--ros", action="store_true", help="the files are definitions of ROS 2 (extra exover[ros])")
    found.add_argument("--out", metavar="PART", help="the file to write to (default: standard output)")
    found.add_argument("--name", metavar="NAME", help="the name of the part (default: that of PART, else of FILE)")
    found.add_argument("--spec", action="store_true", help="a spec instead of a part")
    found.add_argument(
        "-I",
        metavar="DIR",
        dest="folders",
        action="append",
        default=[],
        help="where a .gen file finds what it includes",
    )


def _serve(verbs: Verbs) -> None:
    serve = verbs.add_parser("serve", help="answer programs in any language at a Unix socket")
    serve.add_argument("spec", metavar="SPEC", help="the spec, or - for standard input")
    serve.add_argument(
        "--socket",
        metavar="PATH",
        required=True,
        help="where to listen; the socket is made",
    )
    serve.add_argument(
        "--engine",
        choices=("auto", *RUN_ENGINES),
        default="auto",
        help="what decides (default: auto, the emitted C if there is a compiler, else tables)",
    )


def _lsp(verbs: Verbs) -> None:
    lsp = verbs.add_parser("lsp", help="answer an editor: the language server, on standard input and output")
    lsp.add_argument("--stdio", action="store_true", help="what is done anyway; many editors say it")


def _doctor(verbs: Verbs) -> None:
    verbs.add_parser("doctor", help="say what is installed, what is slow, and what to do")


def _docs(verbs: Verbs) -> None:
    docs = verbs.add_parser("docs", help="print or open the documentation")
    docs.add_argument("page", metavar="PAGE", nargs="?", default="index", help="the page (default: the list of pages)")
    docs.add_argument("--open", action="store_true", help="open it with the program that the system has for it")


def _completion(verbs: Verbs) -> None:
    completion = verbs.add_parser("completion", help="print what completes commands in a shell")
    completion.add_argument("shell", metavar="SHELL", choices=SHELLS, help=f"one of {', '.join(SHELLS)}")


def _help(verbs: Verbs) -> None:
    found = verbs.add_parser("help", help="say how a verb is used")
    found.add_argument("about", metavar="VERB", nargs="?", choices=list(verbs.choices), help="default: all of them")
