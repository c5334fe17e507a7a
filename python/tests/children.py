"""Processes that tests start: the signals that they inherit, and how their ends are measured.

No test may depend on how busy the machine is. What a process promises to do within a second is
measured in the CPU time that it takes, and what would never end ends after minutes.
"""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from inspect import getsource, isfunction
from pathlib import Path

import psutil

# Longer than anything takes, however busy the machine is: a hang ends here.
PATIENCE_SECONDS = 600.0


def set_signals() -> None:
    """Gives this process and those that it starts the signals as a terminal has them.

    A process inherits what another ignores or blocks: `nohup` has hang-ups ignored, and a shell
    that starts a job in the background Ctrl-C. What has a handler gets its default in a child.
    """
    for number in (signal.SIGHUP, signal.SIGQUIT, signal.SIGTERM):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, lambda *_: None)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.pthread_sigmask(signal.SIG_SETMASK, [])


def wait_until(condition: Callable[[], object]) -> None:
    """Waits for something that is bound to happen."""
    end = time.monotonic() + PATIENCE_SECONDS
    while not condition():
        assert time.monotonic() < end, f"it never happened: {described(condition)}"
        time.sleep(0.02)


def described(condition: Callable[[], object]) -> str:
    """The line of a test that has this condition."""
    return getsource(condition).strip() if isfunction(condition) else repr(condition)


def wait_until_it_listens(process: subprocess.Popen[str]) -> None:
    """Waits until the command in this process listens to signals by itself."""
    tasks = Path(f"/proc/{process.pid}/task")
    if not tasks.is_dir():
        time.sleep(2.0)
        return

    def name(task: Path) -> str:
        # A thread may end while it is looked at.
        with suppress(OSError):
            return (task / "comm").read_text().strip()
        return ""

    wait_until(lambda: "signals" in map(name, tasks.iterdir()) or process.poll() is not None)


def cpu_seconds(process: subprocess.Popen[str]) -> float:
    """CPU seconds of all threads of a running process so far."""
    times = psutil.Process(process.pid).cpu_times()
    return float(times.user + times.system)


def interrupt(process: subprocess.Popen[str]) -> tuple[str, str]:
    """Sends Ctrl-C, and returns what was said on stdout and stderr.

    Demands that all threads work on for a second at most.
    """
    assert process.poll() is None, "it ended before it could be interrupted"
    before = cpu_seconds(process) + ended_cpu_seconds()
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=PATIENCE_SECONDS)
    assert ended_cpu_seconds() - before < 1.0 * (os.cpu_count() or 1)
    return stdout, without_progress(stderr)


def ended_cpu_seconds() -> float:
    """CPU seconds of all children that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def without_progress(stderr: str) -> str:
    """Less how far a stage is, which the command tells after ten seconds."""
    return re.sub(r"^halfline: (?!error: )[^:\n]+: .*\n", "", stderr, flags=re.MULTILINE)
