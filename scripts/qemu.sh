#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Get qemu-system-nios2, the reference of the Nios II core's tests, where it is missing (Debian 12's
# QEMU 7.2; releases from 9.1 on have no Nios II). As root it is installed with apt-get, otherwise
# it is unpacked into .venv/qemu with the libraries it needs.
# Usage: scripts/qemu.sh              get it        (QEMU_UNPACK=1: unpack even as root)
#        scripts/qemu.sh --for-tests  install it as root, else say what the tests do without it
#        scripts/qemu.sh --path       print where it is; exit 1 if it is nowhere
set -eu
cd "$(dirname "$0")/.."
folder=.venv/qemu
wrapper=.venv/bin/qemu-system-nios2
package=qemu-system-misc

installed() {
  command -v qemu-system-nios2 2>/dev/null || { test -x "$wrapper" && echo "$wrapper"; }
}

case ${1:-} in
  --path) installed || { echo "error: no qemu-system-nios2; scripts/qemu.sh gets it" >&2; exit 1; }
          exit 0 ;;
  "") ;;
  --for-tests)
    if installed >/dev/null; then exit 0; fi
    if [ "$(id -u)" = 0 ] && "$0"; then exit 0; fi
    echo "[qemu] no qemu-system-nios2: the tests that compare the Nios II core with it are skipped" >&2
    echo "[qemu] (tests/nios/test_n2_lockstep.py and others, by name); make tools T=qemu gets it, also without root" >&2
    [ "${CI:-}" != true ]
    exit ;;
  *) echo "error: unknown argument '$1'" >&2
     echo "help:  scripts/qemu.sh [--for-tests | --path]" >&2
     exit 2 ;;
esac

if [ -z "${QEMU_UNPACK:-}" ] && installed >/dev/null; then
  echo "[qemu] there already: $(installed)"
  exit 0
fi
if ! command -v apt-get >/dev/null 2>&1; then
  echo "error: no qemu-system-nios2, and no apt-get to get it with" >&2
  echo "help:  install QEMU 7.2 to 9.0 with its nios2-softmmu target" >&2
  exit 1
fi

if [ -z "${QEMU_UNPACK:-}" ] && [ "$(id -u)" = 0 ]; then
  echo "[qemu] installing Debian's $package (with apt-get, as root)"
  export DEBIAN_FRONTEND=noninteractive
  apt-get update -q
  apt-get install -q -y --no-install-recommends $package
else
  echo "[qemu] unpacking Debian's $package and what it needs into $folder"
  # What apt would install on top of this machine, or all of it if the package is there already.
  mkdir -p "$folder/packages" "$folder/root" .venv/bin
  needed=$(apt-get -s --no-install-recommends install $package | awk '/^Inst/{print $2}')
  (cd "$folder/packages" && apt-get download ${needed:-$package})
  for file in "$folder"/packages/*.deb; do
    dpkg-deb -x "$file" "$folder/root"
  done
  rm -r "$folder/packages"
  root=$PWD/$folder/root
  libraries=$(find "$root" -name '*.so*' -exec dirname {} + | sort -u | tr '\n' ':')
  cat >"$wrapper" <<END
#!/bin/sh
LD_LIBRARY_PATH=$libraries\${LD_LIBRARY_PATH:-} exec $root/usr/bin/qemu-system-nios2 -L $root/usr/share/qemu "\$@"
END
  chmod +x "$wrapper"
  "$wrapper" --version >/dev/null
fi
installed >/dev/null || { echo "error: $package has no qemu-system-nios2 here" >&2; exit 1; }
echo "[qemu] ready: $(installed)"
