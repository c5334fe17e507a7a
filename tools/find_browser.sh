#!/bin/sh
# Prints the path of a Chromium that runs: HALFLINE_BROWSER, if set, is tried alone; else the usual
# names on PATH. Where there is none, root installs it with apt-get. Says in one line what is
# missing if that cannot be.
set -eu

# Asks a candidate itself: a name on PATH may be a shim that leads nowhere.
first_that_runs() {
    for candidate in "$@"; do
        if "$candidate" --version >/dev/null 2>&1; then
            command -v "$candidate"
            return 0
        fi
    done
    return 1
}
names='chromium chromium-browser google-chrome google-chrome-stable'

if [ -n "${HALFLINE_BROWSER:-}" ]; then
    first_that_runs "$HALFLINE_BROWSER" && exit 0
    echo "missing: HALFLINE_BROWSER=$HALFLINE_BROWSER is no browser that runs" >&2
    exit 1
fi
# shellcheck disable=SC2086
first_that_runs $names && exit 0
if [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
    echo "installing chromium for the tests of pages" >&2
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    # Another apt-get may hold the lock: wait for it.
    if { apt-get update &&
        DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 \
            install --yes --no-install-recommends chromium; } >"$log" 2>&1; then
        # shellcheck disable=SC2086
        first_that_runs $names && exit 0
    fi
    tail -n 5 "$log" >&2
fi
echo "missing: Chromium (on Debian: apt install chromium), or HALFLINE_BROWSER with its path" >&2
exit 1
