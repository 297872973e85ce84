"""A file that is written whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress


@contextmanager
def replacing(path: str, private: bool = False) -> Iterator[str]:
    """Yield the path of a new empty file, which replaces `path` after the body; it is removed if the body raises.

    It is in the same folder under a random name, so that it is no file of another process. `private`: only its owner
    may read it.
    """
    temporary = os.path.join(os.path.dirname(path), f".{os.urandom(8).hex()}.tmp")
    try:
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600 if private else 0o666))
        yield temporary
        os.replace(temporary, path)
    except BaseException:
        with suppress(OSError):  # it was never made
            os.unlink(temporary)
        raise
