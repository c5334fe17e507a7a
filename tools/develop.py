#!/usr/bin/env python3
"""Makes `import halfline` work in a virtual environment, from python/ and what cargo built.

    tools/develop.py TARGET/debug .venv

puts the compiled part beside the Python files, as maturin would, and python/ on the environment's
path. Cargo has built it together with everything else, which maturin could not use: alone it asks for
other features of shared crates, and so for one more build of them.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent

# What cargo calls the library, and what Python does.
NAMES = {
    "lib_native.so": "_native.abi3.so",
    "lib_native.dylib": "_native.abi3.so",
    "_native.dll": "_native.pyd",
}


def develop(built: Path, environment: Path) -> None:
    """Takes the library out of the folder `built` into the package, and that into `environment`."""
    name = next((name for name in NAMES if (built / name).is_file()), None)
    if name is None:
        raise SystemExit(f"no {' or '.join(NAMES)} in {built}: cargo build --workspace")
    package = ROOT / "python" / "halfline"
    # Beside and renamed: a process that has it loaded keeps the old one.
    beside = package / "_native.new"
    shutil.copy2(built / name, beside)
    beside.replace(package / NAMES[name])

    folder = "Scripts" if sys.platform == "win32" else "bin"
    ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
    site = subprocess.run(
        [environment / folder / "python", "-c", ask], capture_output=True, text=True, check=True
    ).stdout.strip()
    (Path(site) / "halfline.pth").write_text(f"{ROOT / 'python'}\n", encoding="utf-8")


if __name__ == "__main__":
    develop(Path(sys.argv[1]), Path(sys.argv[2]))
