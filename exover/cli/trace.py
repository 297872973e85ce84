"""`exover trace`: print the run of a finding."""

import argparse

from exover.cli.files import print_or_write, read_spec, shown
from exover.cli.findings import chosen
from exover.cli.overwriting import refuse_over
from exover.cli.status import CliError, ExitStatus
from exover.rendering import picture
from exover.report.json import UnreadableReport
from exover.report.recorded import retell


def run(arguments: argparse.Namespace) -> int:
    """Print or write the run of the chosen finding; `CliError` if the spec does not answer it as recorded."""
    recorded, spec = chosen(arguments)
    if arguments.out is not None:
        refuse_over(spec, arguments.out)
    try:
        story = retell(read_spec(spec), recorded)
    except UnreadableReport as reason:
        raise CliError(f"cannot use {shown(arguments.finding)}: {reason}") from reason
    print_or_write(arguments.out, picture(recorded, story, arguments.format))
    return ExitStatus.OK
