"""A server of `/gated/drive` in a process of its own, which accepts everything and ends nothing, until it is killed."""

import os
import sys
import time

from tests.gate.ros_peers import DRIVE, Node, Server


def main() -> None:
    """Serve as long as the process that has started this one is there."""
    parent, server = os.getppid(), Server(Node(int(sys.argv[1])), "/gated/drive", DRIVE)
    while os.getppid() == parent:
        server.poll()
        time.sleep(0.01)


if __name__ == "__main__":
    main()
