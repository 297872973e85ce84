"""Decodes the bytes of a file."""

from codecs import BOM_UTF8

from exover.diagnostics import Diagnostic
from exover.source import Source

MAX_BYTES = 16 * 1024 * 1024
"""The size of the largest file that is read."""


def decode(name: str, data: bytes) -> Source | Diagnostic:
    """Return the UTF-8 text of a file, without a byte order mark at its beginning, or a diagnostic why it is none."""
    if len(data) > MAX_BYTES:
        return Diagnostic("E003", f"the file is too large: more than {MAX_BYTES // (1024 * 1024)} MiB", None)
    try:
        return Source(name, data.removeprefix(BOM_UTF8).decode())
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        message = f"the file is no UTF-8 text: byte 0x{error.object[error.start]:02x} on line {line}"
        return Diagnostic("E002", message, None, help="save it as UTF-8")


def unread(error: OSError) -> Diagnostic:
    """Return the diagnostic of a file that the system cannot read."""
    return Diagnostic("E001", f"the file cannot be read: {error.strerror or error}", None)
