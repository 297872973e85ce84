"""`exover verify`: check the proofs of a certificate, and prove that tables decide as the rules of a spec."""

import argparse
import json
import os
from typing import TYPE_CHECKING, Any

from exover.checks.questions import SEVERITY
from exover.cli.files import read_bytes, read_properties, read_spec, shown
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain, out
from exover.escaping import visible_lines
from exover.model.model import Model
from exover.pipeline import claimed, different, embedded

if TYPE_CHECKING:
    from exover.certificate.verify import Verified


def run(arguments: argparse.Namespace) -> int:
    """Print what was verified and return 0; 1 if something is refused, 3 if something is not decided."""
    if arguments.table is None and arguments.spec is None:
        raise CliError(
            "a certificate needs the tables that it is about: add --table TABLE; "
            "tables need the spec whose rules they should be: add --spec SPEC"
        )
    table = _table(arguments.table or arguments.file)
    if arguments.table is None and _is_certificate(table):
        raise CliError(
            f"{shown(arguments.file)} is a certificate, which needs the tables that it is about: add --table TABLE"
        )
    model = None if arguments.spec is None else read_spec(arguments.spec)
    status = ExitStatus.OK if model is None else _rules(arguments, model, table)
    if status != ExitStatus.OK or arguments.table is None:
        return status
    return _certificate(arguments, model, table)


def _is_certificate(content: bytes) -> bool:
    """Return whether the bytes are a certificate, of any format."""
    try:
        found = json.loads(content)
    except (ValueError, RecursionError):
        return False
    return isinstance(found, dict) and "certificate" in found


def _rules(arguments: argparse.Namespace, model: Model, table: bytes) -> ExitStatus:
    from exover.proofs.bytes import UndecidedBytes

    file, spec = shown(arguments.table or arguments.file), shown(arguments.spec)
    try:
        found = different(model, table)
    except UndecidedBytes as reason:
        complain(f"exover: error: it is not known whether the tables are the rules of {spec}: {reason}")
        return ExitStatus.UNKNOWN
    if found:
        out(visible_lines(f"{file}: {what}" for what in found))
        complain(f"exover: error: {file} is not what {spec} says")
        return ExitStatus.VIOLATED
    out(visible_lines([f"{file}: in every state and for all arguments it decides as {spec} says"]))
    return ExitStatus.OK


def _certificate(arguments: argparse.Namespace, model: Model | None, table: bytes) -> ExitStatus:
    from exover.certificate.check import SolverGaveUp
    from exover.certificate.table import Refused as NotSo
    from exover.certificate.verify import Unreadable, read, verify

    file = shown(arguments.file)
    try:
        certificate = read(read_bytes(arguments.file))
    except Unreadable as reason:
        raise CliError(f"{file} cannot be read as a certificate: {reason}") from reason
    expected = None
    if model is not None:
        expected = claimed(model, read_properties(arguments.spec, arguments.properties, model))
    try:
        found = verify(table, certificate, expected, arguments.timeout)
    except NotSo as reason:
        complain(f"exover: error: {file} is refused: {reason}")
        return ExitStatus.VIOLATED
    except SolverGaveUp as reason:
        complain(f"exover: error: {file} could not be checked: {reason}")
        return ExitStatus.UNKNOWN
    return _told(arguments, found)


def _told(arguments: argparse.Namespace, found: "Verified") -> ExitStatus:
    """Print what is proved and what has no proof; with a spec `tables` is proved, by `_rules` before."""
    file = shown(arguments.file)
    tables = [each for each, _ in found.unproved if each["check"] == "tables" and arguments.spec is not None]
    for each in tables:
        if each["verdict"] == "violated":
            what = f"tables {each['subject']}: it says violated, and it is proved that it holds"
            complain(f"exover: error: {file} is refused: {what}")
            return ExitStatus.VIOLATED
    proved_above = [each for each in tables if each["verdict"] == "holds"]
    unproved = [(each, reason) for each, reason in found.unproved if each not in proved_above]
    lines = [f"{each['check']} {each['subject']}: no proof: {reason}" for each, reason in unproved]
    whose = (
        "--spec tells whether its claims are those of it"
        if arguments.spec is None
        else "its claims are those of the spec"
    )
    proved = len(found.proved) + len(proved_above)
    lines.append(f"{file}: {proved} findings proved, {len(unproved)} without proof; {whose}")
    out(visible_lines(lines))
    wanted = [each for each, _ in unproved if arguments.strict and _is_wanted(each)]
    if wanted:
        names = ", ".join(f"{each['check']} {each['subject']}" for each in wanted)
        complain(f"exover: error: {file} says without proof that these hold: {names}")
    return ExitStatus.VIOLATED if wanted else ExitStatus.OK


def _is_wanted(finding: dict[str, Any]) -> bool:
    """Return whether a finding holds and its check has severity error, as one that is not known is taken to have."""
    return finding["verdict"] == "holds" and SEVERITY.get(finding["check"], "error") == "error"


def _table(path: str) -> bytes:
    """Return the bytes of tables; a C or Rust source is compiled and run to get them."""
    if not path.endswith((".c", ".rs")):
        return read_bytes(path)
    from exover.engines.compiler import NativeUnavailable

    if not os.path.isfile(path):
        raise CliError(f"cannot read {path}: it is no file")
    try:
        return embedded(path)
    except NativeUnavailable as reason:
        raise CliError(f"cannot compile {path}: {reason}") from reason
