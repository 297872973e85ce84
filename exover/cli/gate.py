"""`exover gate`: validate a binding, or run the gate between clients and modules."""

import argparse
import gc
import os
import sys
from contextlib import ExitStack, closing
from importlib.util import find_spec
from time import monotonic

from exover.checks.questions import SEVERITY
from exover.checks.schedule.plan import CheckPlan
from exover.cli.files import read_source, read_spec, shown, standard_input, whole
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, out, unwaited_complaints
from exover.escaping import visible
from exover.gate.binding import Binding
from exover.gate.gate import Gate, Journal, checker_of
from exover.gate.journal import JournalFile, Take, no_journal, stamped
from exover.gate.mcp.proxy import McpProxy
from exover.gate.mcp.session import McpSession
from exover.gate.reading import read_binding
from exover.model.model import Model
from exover.model.wording import counted
from exover.pipeline import Build, build, check
from exover.run.simulate import Engine


def run(arguments: argparse.Namespace) -> int:
    """Run `exover gate check`, `exover gate mcp` or `exover gate ros2`, and return the exit status."""
    if arguments.side == "mcp" and "-" in (arguments.spec, arguments.bind):
        raise CliError("standard input is the client's: name the spec and the binding")
    model = read_spec(arguments.spec)
    binding = binding_of(arguments.bind, model)
    if arguments.side == "mcp":
        return _mcp(arguments, model, binding)
    if arguments.side == "ros2":
        return _ros2(arguments, model, binding)
    out(visible(f"{shown(arguments.bind)}: {_figures(binding, model)}") + "\n")
    return ExitStatus.OK


def _mcp(arguments: argparse.Namespace, model: Model, binding: Binding) -> int:
    for bound in binding.requests:
        if bound.kind != "tool":
            raise CliError(f"{bound.request} is bound to a ROS 2 {bound.kind}, and this gate serves MCP tools")
    checker = _checker(arguments, model)
    if checker is None:
        return ExitStatus.VIOLATED
    with ExitStack() as stack:
        stack.enter_context(unwaited_complaints())
        journal = _journal(arguments, stack)
        gate = Gate(model, binding, checker, monotonic, journal)
        try:
            session = McpSession(arguments.server, _client())
        except OSError as error:
            raise CliError(f"cannot start {arguments.server[0]}: {error.strerror}") from error
        proxy = McpProxy(gate, session.to_client, session.to_server, _tell)
        gc.freeze()  # these objects stay: to collect them again and again takes longer than many decisions
        well = session.run(proxy, binding.gate.max_line)
    return ExitStatus.OK if well else ExitStatus.VIOLATED


def _ros2(arguments: argparse.Namespace, model: Model, binding: Binding) -> int:
    if find_spec("cyclonedds") is None or find_spec("rosbags") is None:
        raise CliError("exover gate ros2 needs cyclonedds and rosbags: pip install 'exover[ros2]'")
    from exover.cli.gate_ros2 import offered, serve

    session = offered(arguments, model, binding, _tell)
    checker = _checker(arguments, model)
    if checker is None:
        return ExitStatus.VIOLATED
    with ExitStack() as stack:
        stack.enter_context(unwaited_complaints())
        journal = _journal(arguments, stack, session.publish)
        gate = Gate(model, binding, checker, monotonic, journal)
        gc.freeze()  # as above
        serve(gate, session, _tell)
    return ExitStatus.OK


def _checker(arguments: argparse.Namespace, model: Model) -> Engine | None:
    """Return the checker that decides; None if the spec is not safe and `--unchecked` is not given."""
    built = build(model, arguments.unchecked)
    if not arguments.unchecked and not _safe(built, arguments.spec):
        return None
    checker, reason = checker_of(model, built.tables)
    if reason:
        complain(f"exover gate: the tables are walked in Python: {reason.splitlines()[0]}")
    return checker


def _client() -> tuple[int, int]:
    """Return the descriptors from which the client is read and to which it is written; `CliError` if one is closed."""
    if sys.stdout is None:
        raise CliError("cannot write to the client: standard output is closed")
    return standard_input().fileno(), os.dup(sys.stdout.fileno())


def _safe(built: Build, spec: str) -> bool:
    """Return whether the checks whose violation is an error, but `property`, hold; complain of those that do not."""
    errors = [name for name, severity in SEVERITY.items() if severity == "error" and name != "property"]
    outcome = check(built, lambda _: None, CheckPlan(errors))
    wrong = [found for found in outcome.findings if found.verdict != "holds" and found.severity == "error"]
    for found in wrong:
        complain(f"exover gate: {found.check} {found.subject}: {found.verdict}")
    if wrong:
        complain(f"exover gate: {spec} is not safe: `exover check` tells more, and --unchecked runs it all the same")
    return not wrong


def _journal(arguments: argparse.Namespace, stack: ExitStack, publish: Take | None = None) -> Journal:
    """Return the journal of decisions: it goes to a topic, the file of `--log`, and OpenTelemetry, as options say."""
    takers = [] if publish is None else [publish]
    if arguments.log is not None:
        takers.append(stack.enter_context(closing(_log(arguments.log))))
    journal = stamped(*takers) if takers else no_journal
    return _observed(journal) if arguments.otel else journal


def _log(path: str) -> JournalFile:
    try:
        return JournalFile(path, _tell)
    except OSError as error:
        raise CliError(f"cannot write {path}: {error.strerror}") from error


def _observed(journal: Journal) -> Journal:
    """Return the journal, which also goes to OpenTelemetry."""
    try:
        from exover.gate.telemetry import with_telemetry
    except ModuleNotFoundError as error:
        raise CliError("--otel needs OpenTelemetry: pip install 'exover[otel]'") from error
    return with_telemetry(journal)


def _tell(text: str) -> None:
    complain(f"exover gate: {text}")


def binding_of(path: str, model: Model) -> Binding:
    """Return the binding in a file; mistakes go to standard error, and `CliError` is raised."""
    source = read_source(path)
    return whole(*read_binding(source, model), source)


def _figures(binding: Binding, model: Model) -> str:
    parts = [
        f"{len(binding.requests)} of {counted(len(model.requests), 'request')}",
        f"{len(binding.posters)} of {counted(len(model.observable), 'poster')}",
        counted(len(binding.watches), "watch", "watches"),
    ]
    return ", ".join(parts)
