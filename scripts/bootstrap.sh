#!/bin/sh
# Create the project-local Python environment from a locked requirements file.
# Usage: scripts/bootstrap.sh LOCKFILE STAMP   (called by the Makefile; STAMP is touched on success)
set -eu
lock=$1
stamp=$2
venv=.venv
# Only what says where packages come from and how to reach them, in PIP_ variables and in pip's own
# configuration: a target, a prefix or --user would install elsewhere, foreign Python paths would be
# seen as installed.
python=${PYTHON:-python3}
unset VIRTUAL_ENV
taken() { # NAME: whether the set-up takes this PIP_ variable
  case $1 in
    PIP_INDEX_URL | PIP_EXTRA_INDEX_URL | PIP_FIND_LINKS | PIP_NO_INDEX | PIP_TRUSTED_HOST) ;;
    PIP_CERT | PIP_CLIENT_CERT | PIP_PROXY | PIP_TIMEOUT | PIP_DEFAULT_TIMEOUT | PIP_RETRIES) ;;
    PIP_CACHE_DIR | PIP_NO_CACHE_DIR | PIP_CONFIG_FILE) ;;
    *) return 1 ;;
  esac
}
for name in $(env | sed -n 's/^\(PIP_[A-Z_]*\)=.*/\1/p; s/^\(PYTHON[A-Z]*\)=.*/\1/p'); do
  taken "$name" || unset "$name"
done

missing=""
for tool in g++ make perl; do
  command -v "$tool" >/dev/null 2>&1 || missing="$missing $tool"
done
if [ -n "$missing" ]; then
  echo "error: required program(s) not found:$missing" >&2
  echo "help:  on Debian or Ubuntu: sudo apt-get install$missing" >&2
  exit 1
fi

if ! [ -w . ]; then
  echo "error: $(pwd) cannot be written: the environment is made in it" >&2
  echo "help:  copy the checkout to a folder of your own, or make it writable" >&2
  exit 1
fi

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
  if ! said=$("$python" -I -m venv "$venv" 2>&1); then
    rm -rf "$venv"
    echo "$said" >&2
    echo "error: '$python -m venv' failed" >&2
    case $said in
      *ensurepip*) echo "help:  on Debian or Ubuntu: sudo apt-get install python3-venv" >&2 ;;
      *"No space"*) echo "help:  the disk is full: the environment takes 2.5 GB" >&2 ;;
    esac
    exit 1
  fi
fi

run_pip() { "$venv/bin/python" -I -m pip --disable-pip-version-check "$@"; }
if ! configured=$(run_pip config list); then
  echo "error: pip cannot read its configuration; its own message is above" >&2
  echo "help:  mend the file, or set PIP_CONFIG_FILE to another one, or to /dev/null for none" >&2
  exit 1
fi
# Lines of the list: global.index-url='https://...'. A variable comes before the files, as with pip.
while IFS='=' read -r key value; do
  name=PIP_$(echo "${key#*.}" | tr a-z- A-Z_)
  case $key in
    global.* | install.*)
      value=${value#?}
      if taken "$name" && ! printenv "$name" >/dev/null; then
        export "$name=$(printf %b "${value%?}")"
      fi
      ;;
  esac
done <<END
$configured
END
export PIP_CONFIG_FILE=/dev/null

echo "[setup] installing the packages of $lock into $venv (once; a minute or two)"
# Built packages only: to build one would run tools that no lock names.
if ! { run_pip install -q --only-binary :all: --require-hashes -r "$lock" &&
  run_pip install -q --no-deps --no-build-isolation -e .; }; then
  echo "error: the packages of $lock could not be installed; pip's own message is above" >&2
  echo "help:  the first call needs the network or a PIP_FIND_LINKS folder, and 2.5 GB of disk" >&2
  in_use=$(env | sed -n '/^PIP_CONFIG_FILE=/d; s/^\(PIP_[A-Z_]*\)=.*/\1/p' | sort | tr '\n' ' ')
  [ -z "$in_use" ] || echo "help:  settings of pip in use, from the environment or its files: $in_use" >&2
  exit 1
fi
touch "$stamp"
echo "[setup] done"
