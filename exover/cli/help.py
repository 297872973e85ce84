"""`exover help`: print the usage of a verb."""

import argparse

from exover.cli.arguments import parser
from exover.cli.status import ExitStatus


def run(arguments: argparse.Namespace) -> int:
    """Print what `exover VERB --help` prints, or without a verb `exover --help`."""
    parser().parse_args([arguments.about, "--help"] if arguments.about else ["--help"])
    return ExitStatus.OK
