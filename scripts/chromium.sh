#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Get chromium, in which the tests look at the result pages, where it is missing (Debian's package).
# Usage: scripts/chromium.sh              get it (as root)
#        scripts/chromium.sh --for-tests  get it as root, else say what the tests do without it
set -eu

installed() {
  command -v chromium >/dev/null 2>&1
}

case ${1:-} in
  "") ;;
  --for-tests)
    if installed; then exit 0; fi
    if [ "$(id -u)" = 0 ] && "$0"; then exit 0; fi
    echo "[chromium] no chromium: the tests that look at pages in it are skipped" >&2
    echo "[chromium] (tests/page/test_pages.py, by name); sudo apt-get install chromium gets it" >&2
    [ "${CI:-}" != true ]
    exit ;;
  *) echo "error: unknown argument '$1'" >&2
     echo "help:  scripts/chromium.sh [--for-tests]" >&2
     exit 2 ;;
esac

if installed; then
  echo "[chromium] there already: $(command -v chromium)"
  exit 0
fi
if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null 2>&1; then
  echo "error: no chromium, and it cannot be installed here: apt-get as root is needed" >&2
  echo "help:  sudo apt-get install chromium" >&2
  exit 1
fi
echo "[chromium] installing Debian's package (with apt-get, as root)"
export DEBIAN_FRONTEND=noninteractive
apt-get update -q
apt-get install -q -y --no-install-recommends chromium
