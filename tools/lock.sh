#!/bin/sh
# Makes every requirements/*.txt anew from its .in: exact versions with hashes, for every
# platform and every Python from 3.10 on.
set -eu
venv=.venv-lock
python=$(tools/find_python.sh)
"$python" -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --upgrade uv
for input in requirements/*.in; do
    output="${input%.in}.txt"
    "$venv/bin/uv" pip compile --quiet --upgrade --universal --python-version 3.10 \
        --generate-hashes --no-header --no-annotate --output-file "$output" "$input"
    echo "$output"
done
