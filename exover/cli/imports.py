"""`exover import`: translate descriptions of modules in other languages to a part of a spec."""

import argparse
import os
import re
from collections.abc import Sequence

from exover.cli.files import print_or_write, read_source
from exover.cli.named_files import outputs_of
from exover.cli.overwriting import refuse_over
from exover.cli.status import CliError, ExitStatus
from exover.cli.streams import complain
from exover.escaping import visible
from exover.imports.part import Imported, UnreadableDescription
from exover.source import Source
from exover.syntax.lex import RESERVED

GENOM = ".gen"


def run(arguments: argparse.Namespace) -> int:
    """Print or write the part; what it leaves open is printed as warnings, and is in its comments."""
    if "-" in arguments.files:
        raise CliError("name the file: what it is, and where its own files are, is told by its name")
    sources = [read_source(file) for file in arguments.files]
    try:
        imported = (_ros if arguments.ros else _genom)(arguments, sources)
    except UnreadableDescription as reason:
        raise CliError(str(reason)) from reason
    for remark in imported.remarks:
        complain(f"exover: warning: {remark}")
    print_or_write(arguments.out, imported.text)
    return ExitStatus.OK


def _genom(arguments: argparse.Namespace, sources: Sequence[Source]) -> Imported:
    from exover.imports.genom import import_genom
    from exover.imports.preprocess import NotPreprocessed, preprocess

    if len(sources) != 1 or not arguments.files[0].endswith(GENOM):
        raise CliError(f"name one {GENOM} file; with --ros any number of .action, .srv and .msg files")
    (source,) = sources
    try:
        given = preprocess(source.name, source.text, arguments.folders)
    except NotPreprocessed as reason:
        raise CliError(f"{source.name}: {reason}") from reason
    for file in given.files:
        refuse_over(file, *outputs_of(arguments))
    return import_genom(given, _head(arguments))


def _ros(arguments: argparse.Namespace, sources: Sequence[Source]) -> Imported:
    try:
        from exover.imports.ros import import_ros
    except ImportError as reason:
        raise CliError("rosbags is not installed: python -m pip install 'exover[ros]'") from reason
    return import_ros(sources, _head(arguments))


def _head(arguments: argparse.Namespace) -> str:
    """Return the first lines: a comment that names the files, and the declaration of the part or spec."""
    stem = os.path.splitext(os.path.basename(arguments.out or arguments.files[0]))[0]
    name = arguments.name or re.sub(r"\W", "_", stem, flags=re.ASCII)
    if not re.fullmatch(r"[A-Za-z_]\w*", name, re.ASCII) or name in RESERVED:
        raise CliError(f"{name} is no name: letters, digits and `_`; say with --name how it is called")
    files = visible(", ".join(map(os.path.basename, arguments.files)))
    word = "spec" if arguments.spec else "part"
    return f"// Made by `exover import` of {files}; what it leaves open stands in comments.\n{word} {name};"
