#!/bin/sh
# check_rust.sh [COMPONENT ...]: says in one line what is missing to build: cargo, rustc as new as
# Cargo.toml's rust-version, a C linker, or one of the named cargo components.
set -eu

missing() {
    echo "missing: $1" >&2
    exit 1
}

needed=$(sed -n 's/^rust-version = "\(.*\)"$/\1/p' Cargo.toml)
command -v cargo >/dev/null 2>&1 || missing "cargo $needed or newer (https://rustup.rs)"
found=$(rustc --version 2>/dev/null | sed -n 's/^rustc \([0-9][0-9.]*\).*/\1/p')
[ -n "$found" ] || missing "a rustc that runs (rustup default stable)"
older=$(printf '%s\n%s\n' "$needed" "$found" | sort -t. -k1,1n -k2,2n -k3,3n | head -n 1)
[ "$older" = "$needed" ] || missing "rustc $needed or newer, this is $found (rustup update stable)"
case "$(uname -s)" in
Linux | Darwin)
    command -v cc >/dev/null 2>&1 ||
        missing "a C linker called cc (on Debian: apt install build-essential; on macOS: xcode-select --install)"
    ;;
esac
for component in "$@"; do
    cargo "$component" --version >/dev/null 2>&1 ||
        missing "cargo $component (rustup component add $component)"
done
