"""The `halfline` command of the wheel: the same program as the one that cargo builds."""

from __future__ import annotations

import signal
import sys

from halfline import _native

# What type checkers take for true. To import it from typing would be half of the command's start.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from halfline._cluster import Cluster


def main() -> None:
    """Runs the command with the arguments of the process, and ends the process."""
    # The command listens to Ctrl-C by itself; Python would only note it until the call is over.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_native.main(["halfline", *sys.argv[1:]], _connect))


def _connect(address: str) -> Cluster:
    """Called when the command is asked to let a cluster work."""
    from halfline._cluster import connect

    return connect(address)
