#!/bin/sh
# test_arm.sh [FILTER ...]: the tests of the libraries on 64-bit ARM, by NEON and by plain Rust, or those whose
# names contain a filter. On other machines they are cross-compiled and run by QEMU. What that needs is
# installed where it can be: the target by rustup, the rest as root by apt-get. Says in one line what is
# missing else.
set -eu

target=aarch64-unknown-linux-gnu
packages='--package halfline --package halfline-io --package halfline-check'

missing() {
    echo "missing: $1" >&2
    exit 1
}

# shellcheck disable=SC2086
case "$(uname -m)" in
aarch64 | arm64) exec cargo test --locked $packages -- "$@" ;;
esac

# Rust's own library, compiled for the target.
has_target() {
    [ -n "$(find "$(rustc --print target-libdir --target $target)" -name 'libstd-*.rlib' 2>/dev/null)" ]
}
has_target || rustup target add $target >/dev/null 2>&1 || :
has_target || missing "Rust's library for $target (rustup target add $target)"

# A linker with its C library, and an emulator.
linker=aarch64-linux-gnu-gcc
has_tools() {
    command -v $linker >/dev/null && command -v qemu-aarch64 >/dev/null &&
        [ -e "$($linker -print-file-name=libc.a)" ]
}
debian='gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user'
if ! has_tools && [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
    echo "installing $debian for the tests on ARM" >&2
    log=$(mktemp)
    trap 'rm -f "$log"' EXIT
    # Another apt-get may hold the lock: wait for it.
    # shellcheck disable=SC2086
    { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 \
        install --yes --no-install-recommends $debian; } >"$log" 2>&1 || tail -n 5 "$log" >&2
fi
has_tools || missing "$linker with a static C library, or qemu-aarch64 (on Debian: apt install $debian)"

# Linked statically: else the emulator would need a loader and a C library that fit each other.
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=$linker
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=qemu-aarch64
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUSTFLAGS='-C target-feature=+crt-static'
# An emulator is some twenty times slower: send fewer rays, and leave out the building of twelve trees of a million
# triangles each, which asks for time and memory and not for answers.
export HALFLINE_TEST_RAYS="${HALFLINE_TEST_RAYS:-20000}"
# shellcheck disable=SC2086
cargo test --locked --target $target $packages -- \
    --skip a_million_degenerate_triangles_neither_hang_nor_explode "$@"
