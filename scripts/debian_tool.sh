#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Get a tool of the tests that Debian has a package for, where it is missing.
# Usage: scripts/debian_tool.sh NAME              get it (as root)
#        scripts/debian_tool.sh NAME --for-tests  get it as root, else say what the tests do without it
#        scripts/debian_tool.sh NAME --have       exit status 0 if it is there
# NAME: chromium (looks at the result pages), tclsh (runs the scripts of Quartus),
#       fst (headers with which Verilator writes waves), iverilog (parses plain Verilog),
#       linuxcnc (drives the simulated machine; with headers and halcompile), tshark (decodes captures of the bus), dejagnu (runs the tests of GCC and GDB),
#       verilator (Debian's own version lints the file lists)
set -eu

name=${1:-}
case $name in
  chromium) packages=chromium without="tests/page is skipped in part" ;;
  tclsh) packages=tcl without="the tests of the scripts of Quartus and Platform Designer are skipped" ;;
  iverilog) packages=iverilog without="the test of the plain Verilog by Icarus is skipped" ;;
  verilator) packages=verilator without="the file lists are not linted by Debian's Verilator" ;;
  linuxcnc) packages="linuxcnc-uspace linuxcnc-uspace-dev" without="the tests in which LinuxCNC drives the machine are skipped" ;;
  tshark) packages=tshark without="the test of the captures of the bus is skipped" ;;
  dejagnu) packages=dejagnu without="the tests of GCC and GDB are skipped" ;;
  fst) packages="liblz4-dev zlib1g-dev" without="WAVES=1 cannot build, its tests are skipped" ;;
  *)
    echo "error: unknown tool '$name'" >&2
    echo "help:  scripts/debian_tool.sh chromium|dejagnu|tclsh|fst|iverilog|linuxcnc|tshark|verilator [--for-tests | --have]" >&2
    exit 2
    ;;
esac

installed() {
  case $name in
    fst) printf '#include <lz4.h>\n#include <zlib.h>\n' | ${CXX:-g++} -E -x c++ - >/dev/null 2>&1 ;;
    verilator) [ -x /usr/bin/verilator ] ;; # PATH has the one of the environment
    linuxcnc) command -v linuxcnc >/dev/null 2>&1 && command -v halcompile >/dev/null 2>&1 ;;
    dejagnu) command -v runtest >/dev/null 2>&1 ;;
    *) command -v "$name" >/dev/null 2>&1 ;;
  esac
}

if installed; then exit 0; fi
case ${2:-} in
  "") ;;
  --have) exit 1 ;;
  --for-tests)
    if [ "$(id -u)" = 0 ] && "$0" "$name"; then exit 0; fi
    echo "[$name] missing: $without; sudo apt-get install $packages gets it" >&2
    [ "${CI:-}" != true ]
    exit
    ;;
  *)
    echo "error: unknown argument '$2'" >&2
    echo "help:  scripts/debian_tool.sh chromium|dejagnu|tclsh|fst|iverilog|linuxcnc|tshark|verilator [--for-tests | --have]" >&2
    exit 2
    ;;
esac

if [ "$(id -u)" != 0 ] || ! command -v apt-get >/dev/null 2>&1; then
  echo "error: no $name, and it cannot be installed here: apt-get as root is needed" >&2
  echo "help:  sudo apt-get install $packages" >&2
  exit 1
fi
echo "[$name] installing Debian's $packages (with apt-get, as root)"
export DEBIAN_FRONTEND=noninteractive
apt-get update -q
# shellcheck disable=SC2086  # several packages
apt-get install -q -y --no-install-recommends $packages
