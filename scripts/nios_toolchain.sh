#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Build the cross compiler for Nios II (binutils, GCC, newlib) and its GDB from Debian's own source packages.
# No root needed: packages are fetched with a private apt state and unpacked below the cache folder.
# Finished stages leave a stamp, so an interrupted build goes on where it stopped.
# Usage: scripts/nios_toolchain.sh            JOBS=n  parallel compilations (default: all processors)
#        scripts/nios_toolchain.sh --gdb      GDB alone, in minutes
#        scripts/nios_toolchain.sh --prefix   print the folder whose bin/ holds nios2-elf-gcc
#        scripts/nios_toolchain.sh --tests    the test suites of GCC and GDB, from the same source packages; prints their folder
# NIOS2_TOOLCHAIN=FOLDER moves the cache (default: ${XDG_CACHE_HOME:-$HOME/.cache}/microtick/nios2-elf).
set -eu

cache=${NIOS2_TOOLCHAIN:-${XDG_CACHE_HOME:-$HOME/.cache}/microtick/nios2-elf}
prefix=$cache/install
jobs=${JOBS:-$(nproc)}
binutils=2.40
gcc=12.2.0
newlib=3.3.0
gdb=13.1
stages=10
stage=0
gdb_alone=false
tests_alone=false

case ${1:-} in
  "") ;;
  --gdb)
    gdb_alone=true
    stages=3
    ;;
  --prefix) echo "$prefix"; exit 0 ;;
  --tests)
    tests_alone=true
    stages=1
    ;;
  -h | --help) sed -n '3,10s/^# //p' "$0"; exit 0 ;;
  *)
    echo "error: unknown argument '$1'" >&2
    echo "help:  scripts/nios_toolchain.sh [--gdb | --tests | --prefix | --help]" >&2
    exit 2
    ;;
esac

# With --tests the standard output is the folder alone.
say() { echo "[nios-toolchain $stage/$stages] $*" >&2; }

die() {
  echo "error: $1" >&2
  echo "help:  $2" >&2
  exit 1
}

ready() {
  if $gdb_alone; then
    echo "[nios-toolchain] ready: $prefix/bin/nios2-elf-gdb"
  else
    echo "[nios-toolchain] ready: $prefix/bin/nios2-elf-gcc"
  fi
}

# begin NAME: true when the stage still has to be done
begin() {
  stage=$((stage + 1))
  if [ -e "$cache/stamps/$1" ]; then
    say "$1: done before"
    return 1
  fi
  say "$1 ..."
}

finish() { touch "$cache/stamps/$1"; }

# logged NAME COMMAND...: run with output in a log; a line every 30 s; the log's end on failure
logged() {
  log=$cache/log/$1
  shift
  started=$(date +%s)
  "$@" >"$log" 2>&1 &
  job=$!
  waited=0
  while kill -0 "$job" 2>/dev/null; do
    sleep 1
    waited=$((waited + 1))
    if [ $((waited % 30)) -eq 0 ]; then
      say "  $(($(date +%s) - started)) s, $(wc -l <"$log") lines in $log"
    fi
  done
  if ! wait "$job"; then
    tail -n 20 "$log" >&2
    die "a step failed; its whole output is in $log" "run the command again after curing the cause: it goes on here"
  fi
}

if $tests_alone && [ -e "$cache/tests/complete" ]; then
  echo "$cache/tests"
  exit 0
fi
if $gdb_alone && "$prefix/bin/nios2-elf-gdb" --version >/dev/null 2>&1; then
  ready
  exit 0
fi
if ! $tests_alone && [ -e "$cache/stamps/gdb" ] && [ -e "$cache/stamps/newlib-c99" ] && "$prefix/bin/nios2-elf-gcc" --version >/dev/null 2>&1; then
  ready
  exit 0
fi
# GDB alone has a folder of its own: a build of the compiler that was interrupted keeps its sources.
if $gdb_alone; then cache=$cache/gdb; fi
if $tests_alone; then cache=$cache/tests; fi

missing=""
for tool in apt-get dpkg-deb gcc g++ make m4 tar xz; do
  command -v "$tool" >/dev/null 2>&1 || missing="$missing $tool"
done
# m4 may come from the packages below; every other one has to be there
missing=$(echo "$missing" | sed 's/ m4//')
[ -z "$missing" ] || die "required program(s) not found:$missing" \
  "this script needs Debian 12 (or a relative) with build-essential and xz-utils"

mkdir -p "$cache/stamps" "$cache/log" "$prefix/bin"
PATH=$prefix/bin:$cache/host/usr/bin:$PATH
export PATH
export M4="$cache/host/usr/bin/m4" BISON_PKGDATADIR="$cache/host/usr/share/bison"

# fetch PACKAGE...: packages of Debian into $cache/deb
fetch() {
  state=$cache/apt
  mkdir -p "$cache/deb" "$state/lists/partial" "$state/archives/partial"
  private="-o Dir::State=$state -o Dir::State::Lists=$state/lists -o Dir::Cache=$state \
    -o Dir::State::status=/var/lib/dpkg/status -o APT::Sandbox::User="
  # shellcheck disable=SC2086
  logged apt-update apt-get $private update
  cd "$cache/deb"
  for package in "$@"; do
    # shellcheck disable=SC2086
    ls "$package"_*.deb >/dev/null 2>&1 || logged "fetch-$package" apt-get $private download "$package"
  done
}

# unpack SOURCE...: all packages into $cache/host, and archives of their sources (SOURCE begins their path) into $cache/src
unpack() {
  mkdir -p "$cache/host" "$cache/src"
  for package in "$cache"/deb/*.deb; do dpkg-deb -x "$package" "$cache/host"; done
  # static libraries only: what is built must not lean on this folder at run time
  find "$cache/host/usr/lib" -name '*.so*' -delete
  for source in "$@"; do
    archive=$(ls "$cache/host/usr/src/$source"*.tar.xz 2>/dev/null | head -n 1)
    [ -n "$archive" ] || die "the archive has no $source (found: $(cd "$cache/host/usr/src" && ls -d ./*.tar.* ./*/*.tar.* | tr '\n' ' '))" \
      "use Debian 12's package lists: binutils $binutils, GCC $gcc, newlib $newlib, GDB $gdb"
    # of the tests only gcc/testsuite/selftests is needed: the build of GCC runs them
    say "  $(basename "$archive")"
    tar -C "$cache/src" --exclude='*/gcc/testsuite/[!s]*' --exclude='*/libstdc++-v3/testsuite/*' -xf "$archive"
  done
}

# host_libraries: where the unpacked libraries are, and the flags of programs for this machine
host_libraries() {
  host_lib=$(dirname "$(find "$cache/host/usr/lib" -name libgmp.a | head -n 1)")
  gmp_include=$(dirname "$(find "$cache/host/usr/include" -name gmp.h | head -n 1)")
  # mpfr.h and mpc.h include gmp.h, which Debian keeps in the folder of the architecture
  [ "$gmp_include" = "$cache/host/usr/include" ] || cp "$gmp_include"/*.h "$cache/host/usr/include/"
  host_flags="CFLAGS=-O1 -g0 -I$cache/host/usr/include"
  hostxx_flags="CXXFLAGS=-O1 -g0 -I$cache/host/usr/include"
}

tidy() { rm -rf "$cache/build" "$cache/src" "$cache/host" "$cache/deb"; }

# the libraries keep names of their sources (assertions): without the folder, for the same bytes everywhere
target_flags="CFLAGS_FOR_TARGET=-O2 -g0 -ffunction-sections -fdata-sections -ffile-prefix-map=$cache/src/="

# configured FOLDER SOURCE FLAGS...: configure once, out of the source tree
configured() {
  folder=$cache/build/$1
  source=$2
  shift 2
  mkdir -p "$folder"
  cd "$folder"
  [ -e Makefile ] || logged "configure-$(basename "$folder")" "$source/configure" --quiet \
    --target=nios2-elf --prefix="$prefix" --disable-nls "$@"
}

build_compiler() {
  # A C library of an earlier version of this script is built again: it needs its sources.
  if [ ! -e "$cache/stamps/newlib-c99" ] && [ ! -e "$cache/src" ]; then
    rm -f "$cache/stamps/fetch" "$cache/stamps/unpack" "$cache/stamps/smoke"
  fi

  if begin fetch; then
    fetch binutils-source gcc-12-source newlib-source libgmp-dev libmpfr-dev libmpc-dev bison flex libfl-dev m4
    finish fetch
  fi

  if begin unpack; then
    unpack "binutils/binutils-$binutils" "gcc-12/gcc-$gcc-dfsg" "newlib/newlib-$newlib"
    finish unpack
  fi

  if begin binutils; then
    host_libraries
    configured binutils "$cache/src/binutils-$binutils" --disable-gdb --disable-sim --disable-gprofng \
      --disable-gprof --disable-werror --disable-plugins --without-zstd "$host_flags" "$hostxx_flags"
    logged binutils make MAKEINFO=true -j"$jobs"
    logged binutils-install make MAKEINFO=true install
    finish binutils
  fi

  if begin gcc; then
    host_libraries
    configured gcc "$(ls -d "$cache/src/gcc-$gcc"* | head -n 1)" --enable-languages=c --with-newlib --without-headers --disable-shared \
      --disable-threads --disable-libssp --disable-libquadmath --disable-libgomp --disable-libatomic \
      --disable-lto --disable-multilib --disable-plugin --disable-gcov --disable-analyzer \
      --enable-checking=release \
      --without-zstd --without-isl \
      --with-gmp-include="$cache/host/usr/include" --with-gmp-lib="$host_lib" \
      --with-mpfr-include="$cache/host/usr/include" --with-mpfr-lib="$host_lib" \
      --with-mpc-include="$cache/host/usr/include" --with-mpc-lib="$host_lib" \
      "$host_flags" "$hostxx_flags" "$target_flags"
    logged gcc make MAKEINFO=true -j"$jobs" all-gcc
    # Debian's source comes without its manuals; this stamp keeps install-gcc from checking them
    touch gcc/s-tm-texi
    logged gcc-install make MAKEINFO=true install-gcc
    finish gcc
  fi

  if begin libgcc; then
    cd "$cache/build/gcc"
    logged libgcc make MAKEINFO=true -j"$jobs" all-target-libgcc
    logged libgcc-install make MAKEINFO=true install-target-libgcc
    finish libgcc
  fi

  if begin newlib-c99; then
    configured newlib "$(ls -d "$cache"/src/newlib-* | head -n 1)" --disable-newlib-supplied-syscalls --disable-multilib \
      --enable-newlib-io-c99-formats "$target_flags"
    logged newlib make MAKEINFO=true -j"$jobs"
    logged newlib-install make MAKEINFO=true install
    finish newlib-c99
  fi

  if begin smoke; then
    printf '#include <math.h>\n#include <stdio.h>\nint main(void) { printf("%%g", sqrt(2.0)); return 0; }\n' \
      >"$cache/smoke.c"
    logged smoke "$prefix/bin/nios2-elf-gcc" -O2 -o "$cache/smoke.elf" "$cache/smoke.c" -T qemu-hosted.ld -lm
    tidy
    finish smoke
  fi
}

# Of GCC the programs that its tests execute, with what runs them; of GDB all of its tests.
unpack_tests() {
  fetch gcc-12-source gdb-source
  mkdir -p "$cache/host"
  for package in "$cache"/deb/*.deb; do dpkg-deb -x "$package" "$cache/host"; done
  tar -C "$cache" --strip-components=1 -xf "$cache/host/usr/src/gcc-12/gcc-$gcc-dfsg.tar.xz" \
    --wildcards "gcc-$gcc/gcc/testsuite/lib/*" "gcc-$gcc/gcc/testsuite/config/*" \
    "gcc-$gcc/gcc/testsuite/gcc.c-torture/*" "gcc-$gcc/gcc/testsuite/gcc.dg/builtins-config.h"
  tar -C "$cache" --strip-components=1 -xf "$cache/host/usr/src/gdb.tar.xz" \
    --wildcards '*/gdb/testsuite/*'
  tidy
  touch "$cache/complete"
}

if $tests_alone; then
  stage=1
  say "tests of GCC and GDB ..."
  unpack_tests
  echo "$cache"
  exit 0
fi
if ! $gdb_alone; then build_compiler; fi

if begin fetch-gdb; then
  fetch gdb-source libgmp-dev libmpfr-dev libexpat1-dev libncurses-dev bison flex libfl-dev m4
  finish fetch-gdb
fi

if begin unpack-gdb; then
  unpack gdb
  finish unpack-gdb
fi

if begin gdb; then
  host_libraries
  configured gdb "$(ls -d "$cache"/src/gdb* | head -n 1)" \
    --disable-binutils --disable-ld --disable-gas --disable-gold --disable-gprof --disable-gprofng --disable-sim \
    --disable-gdbserver --disable-werror --disable-source-highlight \
    --with-expat --with-python=no --without-guile --without-debuginfod --without-lzma --without-zstd \
    --with-gmp-include="$cache/host/usr/include" --with-gmp-lib="$host_lib" \
    --with-mpfr-include="$cache/host/usr/include" --with-mpfr-lib="$host_lib" \
    "LDFLAGS=-L$host_lib" "$host_flags" "$hostxx_flags"
  logged gdb make MAKEINFO=true -j"$jobs" all-gdb
  # the program alone: it needs none of its data files without Python
  install -s gdb/gdb "$prefix/bin/nios2-elf-gdb"
  logged gdb-smoke "$prefix/bin/nios2-elf-gdb" -nx -batch -ex "set architecture nios2" -ex "show architecture"
  tidy
  finish gdb
fi
ready
