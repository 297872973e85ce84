"""The part of `exover gate ros2` that imports `cyclonedds` and `rosbags`, which are extras."""

import argparse
import os
from time import time_ns
from uuid import uuid4

from cyclonedds.core import DDSException

from exover.cli.status import CliError
from exover.cli.values import domain
from exover.dataclass import dataclass
from exover.gate.binding import Binding
from exover.gate.gate import Gate, Tell
from exover.gate.journal import Take
from exover.gate.ros2.cdr import Stamp
from exover.gate.ros2.checking import mistakes, unmade
from exover.gate.ros2.files import finder
from exover.gate.ros2.interfaces import Interfaces
from exover.gate.ros2.names import absolute, is_name
from exover.gate.ros2.proxy import Ros2Proxy
from exover.gate.ros2.session import Ros2Session
from exover.model.model import Model


@dataclass(frozen=True, slots=True)
class Offered:
    """A session with open ports, its interface types, and the publisher of decisions if a topic is given."""

    session: Ros2Session
    interfaces: Interfaces
    publish: Take | None


def offered(arguments: argparse.Namespace, model: Model, binding: Binding, tell: Tell) -> Offered:
    """Return a session with open ports, which does not answer yet; raises `CliError` if the binding or DDS fails."""
    for folder in arguments.interfaces:
        if not os.path.isdir(folder):
            raise CliError(f"--interfaces: {folder} is no folder")
    interfaces = Interfaces(finder(arguments.interfaces, os.environ))
    outer = _domain() if arguments.domain is None else arguments.domain
    inner = outer if arguments.inner_domain is None else arguments.inner_domain
    wrong = list(mistakes(binding, interfaces, apart=inner != outer)) or list(unmade(model, binding, interfaces))
    if arguments.decisions and not is_name(absolute(arguments.decisions)):
        wrong.append(f"--decisions: `{arguments.decisions}` is no name of ROS 2")
    if wrong:
        raise CliError("\n".join(wrong))
    try:
        session = Ros2Session(binding, interfaces, outer, inner, tell)
        publish = session.publish_decisions(arguments.decisions) if arguments.decisions else None
    except DDSException as error:
        raise CliError(
            f"DDS does not start: {error.msg}; CYCLONEDDS_URI may name a network that is not there"
        ) from error
    return Offered(session, interfaces, publish)


def serve(gate: Gate, offered: Offered, tell: Tell) -> None:
    """Serve until a signal raises an exception."""
    session = offered.session
    proxy = Ros2Proxy(gate, offered.interfaces, session.send, tell, now, lambda: uuid4().bytes, os.urandom(8))
    tell("ready")
    session.run(proxy)


def now() -> Stamp:
    """Return the time since 1970."""
    return Stamp(*divmod(time_ns(), 10**9))


def _domain() -> int:
    """Return the domain that ROS 2 would take, of ROS_DOMAIN_ID; raises `CliError` if it is none."""
    text = os.environ.get("ROS_DOMAIN_ID", "") or "0"
    try:
        return domain(text)
    except argparse.ArgumentTypeError as error:
        raise CliError(f"ROS_DOMAIN_ID is {text!r}, and no DDS domain") from error
