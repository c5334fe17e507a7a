#!/bin/sh
# make_venv.sh VENV LOCK: makes the virtual environment VENV hold exactly the packages of LOCK.
# The lock that was installed is kept in the environment, so that nothing is done when it is
# the same, and everything is made anew when it changed or the interpreter went away.
set -eu
venv=$1
lock=$2
if "$venv/bin/python" -c '' 2>/dev/null && cmp -s "$lock" "$venv/installed.txt"; then
    exit 0
fi
python=$(tools/find_python.sh)
echo "making $venv from $lock"
rm -rf "$venv"
"$python" -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --require-hashes \
    --requirement "$lock"
cp "$lock" "$venv/installed.txt"
