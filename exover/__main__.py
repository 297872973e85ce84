"""`python -m exover` is the command `exover`."""

import signal
import sys


def main() -> int:
    """Run the command and return its exit status; Ctrl-C ends the process at once while nothing else heeds it."""
    _end_at_once()
    from exover.cli.main import main as run

    status = run()
    _end_at_once()
    return status


def _end_at_once() -> None:
    """Let Ctrl-C end this process without a word, unless it is ignored: Python would print where it was."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


if __name__ == "__main__":
    sys.exit(main())
