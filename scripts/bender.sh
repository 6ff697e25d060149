#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Get Bender, which reads rtl/Bender.yml in a test, where it is missing: cargo builds it from its
# crate and installs it where cargo installs everything (a minute or two, once).
# Usage: scripts/bender.sh              get it
#        scripts/bender.sh --for-tests  get it under CI=true, else say what the tests do without it
#        scripts/bender.sh --path       print where it is; exit 1 if it is nowhere
set -eu
version=0.32.1
PATH=$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin

case ${1:-} in
  --path) command -v bender; exit ;;
  "" | --for-tests) ;;
  *) echo "error: unknown argument '$1'" >&2
     echo "help:  scripts/bender.sh [--for-tests | --path]" >&2
     exit 2 ;;
esac

if command -v bender >/dev/null; then exit 0; fi
if [ "${1:-}" = --for-tests ] && [ "${CI:-}" != true ]; then
  echo "[bender] missing: the test of rtl/Bender.yml is skipped; scripts/bender.sh gets it" >&2
  exit 0
fi
if ! command -v cargo >/dev/null; then
  echo "error: no cargo to build bender $version with" >&2
  echo "help:  install Rust 1.89 or newer, or bender itself" >&2
  exit 1
fi
echo "[bender] building bender $version with cargo (a minute or two, once)"
# Its SystemVerilog parser is a large C++ library that a list of files does not need.
CARGO_PROFILE_DEV_DEBUG=false \
  cargo install -q --version $version --locked --no-default-features --debug bender
