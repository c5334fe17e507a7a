#!/usr/bin/env python3
"""Installs a wheel into a fresh virtual environment, and does there what the README shows.

    tools/try_wheel.py target/wheels/halfline-*.whl

The README's Python example runs as it stands, and the command that came with the wheel draws a
picture from the tree that the example saved. Nothing but the wheel and what it asks for is there.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MOST_BYTES = 15_000_000


def example() -> str:
    """The README's Python example."""
    found = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)
    if len(found) != 1:
        raise SystemExit(f"README.md has {len(found)} Python examples, and should have one")
    return str(found[0])


def main() -> None:
    """Tries the newest of the wheels that are named."""
    wheel = max((Path(name) for name in sys.argv[1:]), key=lambda path: path.stat().st_mtime)
    size = wheel.stat().st_size
    print(f"{wheel.name}: {size / 1e6:.1f} MB")
    if size > MOST_BYTES:
        raise SystemExit(f"the wheel has {size} bytes, more than {MOST_BYTES}")
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        venv.create(place / "venv", with_pip=True)
        programs = place / "venv" / ("Scripts" if sys.platform == "win32" else "bin")
        python = programs / "python"
        subprocess.run(
            [str(python), "-m", "pip", "install", "--quiet", str(wheel.resolve())], check=True
        )
        listed = [str(python), "-m", "pip", "list", "--format", "freeze"]
        print(subprocess.run(listed, capture_output=True, text=True, check=True).stdout.strip())
        subprocess.run([str(python), "-c", example()], cwd=place, check=True)
        command = str(programs / "halfline")
        subprocess.run([command, "--version"], check=True)
        options = ["--up", "+Z", "--resolution", "800,600", "--quiet"]
        subprocess.run(
            [command, "render", "scan.hlt", "-o", "again.png", *options], cwd=place, check=True
        )
        pictures = [(place / name).read_bytes() for name in ("scan.png", "again.png")]
        if pictures[0] != pictures[1]:
            raise SystemExit("the command draws another picture than the package")
    print("the README's example runs, and the command draws the same picture")


if __name__ == "__main__":
    main()
