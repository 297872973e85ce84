"""`python -m exover` is the command `exover`."""

import sys

from exover.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
