"""`python bench STUDY [OPTION ...]` runs a study of bench/studies.

Run by `make bench-STUDY`. Another module with a `main` is named with its folder: the studies so
start the tools that they measure, `python bench tools.numpy.open3d`, each in its own environment,
and `python bench charts.growth` draws a chart anew. Modules are called as their subjects are,
numpy.py or open3d.py, and so are never run by their paths: such a file would import itself.
"""

from __future__ import annotations

import ast
import importlib
import sys
from pathlib import Path

BENCH = Path(__file__).resolve().parent


def studies() -> dict[str, str]:
    """What each study measures, in the first line of its text; none is imported."""
    found = {}
    for path in sorted((BENCH / "studies").glob("[!_]*.py")):
        words = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or ""
        found[path.stem] = words.split("\n", 1)[0]
    return found


def main() -> int:
    """Runs what the first argument names with the others, or lists the studies."""
    known = studies()
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print("usage: python bench STUDY [OPTION ...]\n")
        for name, words in known.items():
            print(f"{name:12}{words}")
        return 0
    name = sys.argv[1]
    if name not in known and "." not in name:
        print(f"bench: no study {name}, but {', '.join(known)}", file=sys.stderr)
        return 2
    sys.argv = [f"bench {name}", *sys.argv[2:]]
    # Processes that are started from here get it as well, wherever they work.
    sys.path[0] = str(BENCH)
    module = importlib.import_module(name if "." in name else f"studies.{name}")
    return int(module.main() or 0)


if __name__ == "__main__":
    sys.exit(main())
