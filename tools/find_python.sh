#!/bin/sh
# Prints the first Python >= 3.10 that can make virtual environments; PYTHON, if set, is tried
# alone. Says in one line what is missing if there is none.
set -eu

# Asks a candidate itself: a name on PATH may be an old version or a shim that leads nowhere.
probe='
import sys
if sys.version_info < (3, 10):
    sys.exit(3)
try:
    import ensurepip, venv
except ImportError:
    sys.exit(4)
'
without_venv=
for candidate in ${PYTHON:-python3 python3.14 python3.13 python3.12 python3.11 python3.10 python}; do
    status=0
    "$candidate" -c "$probe" >/dev/null 2>&1 || status=$?
    if [ "$status" -eq 0 ]; then
        command -v "$candidate"
        exit 0
    elif [ "$status" -eq 4 ]; then
        without_venv=${without_venv:-$candidate}
    fi
done
if [ -n "$without_venv" ]; then
    echo "missing: Python's venv module for $without_venv (on Debian: apt install python3-venv)" >&2
elif [ -n "${PYTHON:-}" ]; then
    echo "missing: PYTHON=$PYTHON is not a Python 3.10 or newer" >&2
else
    echo "missing: Python 3.10 or newer (https://www.python.org/downloads/)" >&2
fi
exit 1
