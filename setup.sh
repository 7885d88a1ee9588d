#!/bin/sh
# Installs what is missing of the system packages, as root; otherwise names them in one line.
#   setup.sh run    what building and running needs
#   setup.sh test   that, and what the tests need
set -eu
needed="gcc libc6-dev"
useful="lammps lammps-data" # a second MD engine to compare with: nothing needs it to run
[ "${1:-run}" = test ] && needed="$needed pkg-config libhdf5-dev python3-venv slurm-wlm munge"

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
[ -z "$lacking$wished" ] && exit 0
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
