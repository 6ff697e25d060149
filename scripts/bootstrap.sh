#!/bin/sh
# Create the project-local Python environment from a locked requirements file.
# Usage: scripts/bootstrap.sh LOCKFILE STAMP   (called by the Makefile; STAMP is touched on success)
set -eu
lock=$1
stamp=$2
venv=.venv
unset VIRTUAL_ENV PYTHONHOME PYTHONPATH 2>/dev/null || true

missing=""
for tool in g++ make perl; do
  command -v "$tool" >/dev/null 2>&1 || missing="$missing $tool"
done
if [ -n "$missing" ]; then
  echo "error: required program(s) not found:$missing" >&2
  echo "help:  on Debian or Ubuntu: sudo apt-get install$missing" >&2
  exit 1
fi

python=${PYTHON:-python3}
if ! command -v "$python" >/dev/null 2>&1; then
  echo "error: no '$python' on PATH; Python 3.11 or newer is needed" >&2
  echo "help:  on Debian or Ubuntu: sudo apt-get install python3 python3-venv, or set PYTHON=/path/to/python3" >&2
  exit 1
fi
if ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
  echo "error: $("$python" --version) is too old; Python 3.11 or newer is needed" >&2
  echo "help:  set PYTHON=/path/to/python3.11 (or newer)" >&2
  exit 1
fi

if [ ! -x "$venv/bin/pip" ]; then
  echo "[setup] creating $venv with $("$python" --version)"
  if ! "$python" -m venv "$venv"; then
    rm -rf "$venv"
    echo "error: '$python -m venv' failed" >&2
    echo "help:  on Debian or Ubuntu: sudo apt-get install python3-venv" >&2
    exit 1
  fi
fi

echo "[setup] installing the packages of $lock into $venv (once; a minute or two)"
"$venv/bin/pip" install --disable-pip-version-check -q --require-hashes -r "$lock"
"$venv/bin/pip" install --disable-pip-version-check -q --no-deps --no-build-isolation -e .
touch "$stamp"
echo "[setup] done"
