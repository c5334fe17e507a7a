"""The `halfline` command of the wheel: the same program as the one that cargo builds."""

from __future__ import annotations

import signal
import sys

from halfline import _native


def main() -> None:
    """Runs the command with the arguments of the process, and ends the process."""
    # The command listens to Ctrl-C by itself; Python would only note it until the call is over.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_native.main(["halfline", *sys.argv[1:]]))
