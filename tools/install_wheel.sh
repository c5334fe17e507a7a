#!/usr/bin/env bash
# tools/install_wheel.sh ENVIRONMENT FOLDER: makes a virtual environment of NumPy and the newest wheel
# in FOLDER, for the benchmarks.
set -euo pipefail
cd "$(dirname "$0")/.."
environment=$1
wheel=$(ls -t "$2"/halfline-*.whl | head -n 1)
python=$(tools/find_python.sh)
[ -x "$environment/bin/python" ] || "$python" -m venv "$environment"
"$environment/bin/python" -m pip install --quiet --disable-pip-version-check numpy
"$environment/bin/python" -m pip install --quiet --disable-pip-version-check --force-reinstall \
	--no-deps "$wheel"
