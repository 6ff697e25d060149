# SPDX-License-Identifier: Apache-2.0
"""Environments in which people start the commands, and what the set-up and the jobs do there.

The set-up is that of the Makefile, on a small project with one package in place of the real ones.
The jobs write files, which must be the same as in the plain environment.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
import subprocess
import venv
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import distribution
from pathlib import Path

from asip_asm.project import ROOT
from sim.rtl.processes import run_group

DEADLINE = 1800.0  # s, against a hang
NOWHERE = "http://127.0.0.1:9/simple"
PROBE = """\
include Makefile
.PHONY: probe
probe: $(READY)
	@$(PY) -m asip_asm.cli_as "$(OUTPUT)/square.s" -o "$(OUTPUT)/square.json"
	@$(PY) -m sim.debug.asip_run --iss "$(OUTPUT)/square.json" --set x=3 > "$(OUTPUT)/run.txt"
	@$(PY) -m sim.bench.run "$(GCODE)" --robot "$(ROBOT)" --plan-only > "$(OUTPUT)/plan.txt"
"""
OF_PIP = ("PIP_INDEX_URL", "PIP_FIND_LINKS", "PIP_CERT", "PIP_PROXY", "HTTPS_PROXY")
"""Where packages come from."""
TEST = ("test", "-o", "checks", "JOBS=0", "PYTEST_ADDOPTS=tests/asm/test_cli.py")
"""The test command with one file of tests, without the checks of sources before it."""
OF_THE_PLACE = ("checksum", "sources", "simulation")
SQUARE = '.program "µ"\n.input x\n.output F, safe = 0.0\n fmul y, x, x\n mov F, y\n halt\n'
# In place of the real project: one package, and a build tool of its own.
SMALL = """\
[build-system]
requires = []
build-backend = "backend"
backend-path = ["."]
[project]
name = "small"
version = "1"
"""
BACKEND = """\
import zipfile
METADATA = "Metadata-Version: 2.1\\nName: small\\nVersion: 1\\n"
WHEEL = "Wheel-Version: 1.0\\nRoot-Is-Purelib: true\\nTag: py3-none-any\\n"
def build_editable(folder, config_settings=None, metadata_directory=None):
    with zipfile.ZipFile(f"{folder}/small-1-py3-none-any.whl", "w") as wheel:
        wheel.writestr("small.py", "")
        wheel.writestr("small-1.dist-info/METADATA", METADATA)
        wheel.writestr("small-1.dist-info/WHEEL", WHEEL)
        wheel.writestr("small-1.dist-info/RECORD", "")
    return "small-1-py3-none-any.whl"
"""


@dataclass(frozen=True)
class Place:
    """Folders of one environment: `home` and `spare` are there, `checkout` is its name only."""

    home: Path
    spare: Path


def no_change(place: Place) -> dict[str, str]:
    """Variables that need no file."""
    return {}


@dataclass(frozen=True)
class Environment:
    """One environment.

    variables: changes, None removes. files: makes files, and says the variables that name them.
    folder: name of the checkout's folder, "" for the checkout itself. before: shell commands.
    confined: read-only folders ("checkout", "home"), "network" for none. set_up, job: a text of
    the cure that the command must say; "" if it must work. whole_job: the same of the main job.
    new_venv: the set-up makes the virtual environment also in the quick form, and the main job runs
    in one with every package of the lock, which needs the network.
    """

    name: str
    variables: dict[str, str | None] = field(default_factory=dict)
    files: Callable[[Place], dict[str, str]] = no_change
    folder: str = ""
    before: str = ""
    confined: tuple[str, ...] = ()
    set_up: str = ""
    job: str = ""
    whole_job: str = ""
    new_venv: bool = False

    def cure(self, whole: bool) -> str:
        """The cure that a job must say, the main job if `whole`."""
        return self.whole_job if whole else self.job


def foreign_packages(place: Place) -> dict[str, str]:
    """Packages of another installation, as those of ROS, that end whoever imports them."""
    for name in ("numpy", "pip", "pinocchio", "casadi", "matplotlib"):
        (place.spare / name).mkdir()
        (place.spare / name / "__init__.py").write_text("raise SystemExit('foreign package')\n")
    return {"PYTHONPATH": str(place.spare)}


def startup(place: Place) -> dict[str, str]:
    """A start-up file that ends Python."""
    (place.spare / "startup.py").write_text("raise SystemExit('foreign start-up file')\n")
    return {"PYTHONSTARTUP": str(place.spare / "startup.py")}


def pip_configuration(text: str) -> Callable[[Place], dict[str, str]]:
    """pip's configuration in a file that PIP_CONFIG_FILE names."""

    def files(place: Place) -> dict[str, str]:
        file = place.spare / "pip.conf"
        file.write_text(text.format(spare=place.spare))
        return {"PIP_CONFIG_FILE": str(file)}

    return files


def user_configuration(place: Place) -> dict[str, str]:
    """pip's configuration of the user."""
    file = place.home / ".config/pip/pip.conf"
    file.parent.mkdir(parents=True)
    file.write_text(f"[install]\nprefix = {place.spare}/prefix\n")
    return {"HOME": str(place.home)}


def in_spare(variable: str, name: str = "other") -> Callable[[Place], dict[str, str]]:
    """A variable that names a path which is not there."""
    return lambda place: {variable: str(place.spare / name)}


def own_home(place: Place) -> dict[str, str]:
    """A home of this environment alone."""
    return {"HOME": str(place.home)}


def own_cache(place: Place) -> dict[str, str]:
    """A cache in the folder that `confined` makes read-only."""
    return {"XDG_CACHE_HOME": str(place.home)}


def other_pythons() -> dict[str, str]:
    """Version -> interpreter of those on PATH, or of pyenv."""
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    found = {}
    for version in ("3.12", "3.13"):
        places = [shutil.which(f"python{version}"), *root.glob(f"versions/{version}.*/bin/python3")]
        works = [str(each) for each in places if each and runs(Path(each), version)]
        if works:
            found[version] = works[0]
    return found


def runs(python: Path, version: str) -> bool:
    """Whether an interpreter is of this version: a shim of pyenv may lead nowhere."""
    text = "import sys; print('%d.%d' % sys.version_info[:2])"
    done = subprocess.run([python, "-I", "-c", text], capture_output=True, text=True)
    return done.stdout.strip() == version


# Without an index, nothing but the package of the small project can be found.
ONLINE = {"PIP_NO_INDEX": None, "PIP_FIND_LINKS": None, "PIP_RETRIES": "0", "PIP_TIMEOUT": "1"}
TABLE = [
    Environment("plain"),
    Environment("PIP_TARGET", files=in_spare("PIP_TARGET")),
    Environment("PIP_PREFIX", files=in_spare("PIP_PREFIX")),
    Environment("PIP_ROOT", files=in_spare("PIP_ROOT")),
    Environment("PIP_USER", {"PIP_USER": "1"}),
    Environment("PIP_PYTHON", {"PIP_PYTHON": "/usr/bin/python3"}),
    Environment("PIP_DRY_RUN", {"PIP_DRY_RUN": "1"}),
    Environment("PIP_NO_BINARY", {"PIP_NO_BINARY": ":all:"}),
    Environment("PIP_REQUIRE_VIRTUALENV", {"PIP_REQUIRE_VIRTUALENV": "1"}),
    Environment("PIP_CONSTRAINT", files=in_spare("PIP_CONSTRAINT")),
    Environment("PIP_INDEX_URL bogus", ONLINE | {"PIP_INDEX_URL": NOWHERE}, set_up="PIP_INDEX_URL"),
    Environment("PIP_CONFIG_FILE", files=pip_configuration("[install]\ntarget = {spare}/other\n")),
    Environment(
        "PIP_CONFIG_FILE damaged", files=pip_configuration("target\n"), set_up="PIP_CONFIG_FILE",
    ),
    Environment(
        "PIP_CONFIG_FILE with a bogus index", ONLINE,
        pip_configuration(f"[global]\nindex-url = {NOWHERE}\n"), set_up="PIP_INDEX_URL",
    ),
    Environment("pip.conf of the user", files=user_configuration),
    Environment("PYTHONPATH with a foreign numpy", files=foreign_packages),
    Environment("PYTHONHOME", {"PYTHONHOME": "/nonexistent"}),
    Environment("PYTHONSTARTUP", files=startup),
    Environment("PYTHONOPTIMIZE", {"PYTHONOPTIMIZE": "2"}),
    Environment("PYTHONDONTWRITEBYTECODE", {"PYTHONDONTWRITEBYTECODE": "1"}),
    Environment("PYTHONWARNINGS", {"PYTHONWARNINGS": "error"}),
    Environment("PYTHONIOENCODING", {"PYTHONIOENCODING": "ascii"}),
    Environment("PYTHONINSPECT", {"PYTHONINSPECT": "1"}),
    Environment("PYTHONSAFEPATH", {"PYTHONSAFEPATH": "1"}),
    Environment("PYTHONVERBOSE", {"PYTHONVERBOSE": "1"}),
    Environment("PYTHONHASHSEED", {"PYTHONHASHSEED": "7"}),
    Environment("PYTHONUTF8=0 with LC_ALL=C", {"PYTHONUTF8": "0", "LC_ALL": "C"}),
    Environment("LC_ALL=POSIX", {"LC_ALL": "POSIX"}),
    Environment("LANG=tr_TR", {"LANG": "tr_TR.UTF-8"}),
    Environment("LC_ALL unknown", {"LC_ALL": "xx_YY.ISO8859-9"}),
    Environment("umask 077", before="umask 077"),
    Environment("umask 000", before="umask 000"),
    Environment("HOME unset", {"HOME": None}),
    Environment("HOME that is not there", {"HOME": "/nonexistent"}),
    Environment("HOME read-only", files=own_home, confined=("home",)),
    Environment("XDG_CACHE_HOME read-only", files=own_cache, confined=("home",)),
    Environment("TMPDIR missing", files=in_spare("TMPDIR")),
    Environment("foreign VIRTUAL_ENV", {"VIRTUAL_ENV": "/nonexistent/venv"}),
    Environment("CDPATH", {"CDPATH": "/:/tmp"}),
    Environment("MAKEFLAGS=-j4", {"MAKEFLAGS": "-j4"}),
    Environment("MAKEFLAGS=-k -w", {"MAKEFLAGS": "kw"}),
    Environment("GREP_OPTIONS", {"GREP_OPTIONS": "--color=always"}),
    Environment("SHELL", {"SHELL": "/bin/false"}),
    Environment("TERM and COLUMNS", {"TERM": "dumb", "COLUMNS": "20"}),
    Environment("MPLBACKEND", {"MPLBACKEND": "TkAgg", "DISPLAY": ":77"}),
    Environment("folder with spaces", folder="my own checkout"),
    Environment("folder with a non-ASCII name", folder="Прüfstand µ"),
    Environment("folder with quotes", folder="it's $HOME \"x\""),
    Environment(
        "read-only checkout", folder="checkout", confined=("checkout",), set_up="make it writable",
        whole_job="make it writable",
    ),
    Environment("no network after set-up", confined=("network",)),
    *(
        Environment(f"Python {version}", {"PYTHON": python}, new_venv=True)
        for version, python in other_pythons().items()
    ),
]  # fmt: skip
PLAIN = TABLE[0]


def shell(
    what: Environment,
    changes: dict[str, str],
    command: list[str],
    cwd: Path,
    home: Path,
    base: dict[str, str],
) -> subprocess.CompletedProcess[str]:
    """Run a command in an environment."""
    lines = [what.before] if what.before else []
    for each in what.confined:
        if each == "network":
            continue
        place = shlex.quote(str(cwd if each == "checkout" else home))
        lines += [f"mount --bind {place} {place}", f"mount -o remount,ro,bind {place}"]
    # The folder is entered again: the first one is not what is mounted over it.
    script = "\n".join(["set -e", *lines, f"cd {shlex.quote(str(cwd))}", 'exec "$@"'])
    whole = ["sh", "-c", script, "sh", *command]
    if what.confined:
        whole = ["unshare", "-rmn" if "network" in what.confined else "-rm", *whole]
    variables = base | {k: v for k, v in what.variables.items() if v is not None} | changes
    for name in [name for name, value in what.variables.items() if value is None]:
        variables.pop(name, None)
    return run_group(
        whole, DEADLINE, cwd="/", env=variables, stdin=subprocess.DEVNULL,
        stderr=subprocess.STDOUT, errors="replace",
    )  # fmt: skip


def start(folder: Path, what: Environment) -> tuple[Place, dict[str, str], dict[str, str]]:
    """Folders of an environment, the variables that name them, and those of every environment."""
    place = Place(folder / "home", folder / "spare")
    place.home.mkdir()
    place.spare.mkdir()
    # The plain home is shared: matplotlib looks for its fonts only once.
    home = folder.parent / "plain home"
    home.mkdir(exist_ok=True)
    base = {"PATH": os.environ["PATH"], "HOME": str(home), "LANG": "C.UTF-8"}
    return place, what.files(place), base


def verdict(done: subprocess.CompletedProcess[str], cure: str) -> str:
    """What is wrong with how a command ended, "" if nothing is."""
    said = done.stdout.strip().splitlines()[-12:]
    if cure:
        fine = done.returncode != 0 and cure in done.stdout and "Traceback" not in done.stdout
        return "" if fine else f"status {done.returncode}, without the cure '{cure}': {said}"
    return "" if done.returncode == 0 else f"status {done.returncode}: {said}"


def set_up(folder: Path, what: Environment, fresh: bool) -> str:
    """Set a small project up in an environment. What is wrong, "" if nothing is.

    fresh: the set-up makes the virtual environment too, else one with pip alone is there.
    """
    place, changes, base = start(folder, what)
    checkout = folder / (what.folder or "checkout")
    (checkout / "scripts").mkdir(parents=True)
    if not (fresh or what.new_venv):
        empty = folder.parent / "empty"
        if not empty.exists():
            venv.create(empty, symlinks=True)
            (packages,) = empty.glob("lib/python*/site-packages")
            pip = distribution("pip")
            for name in {each.parts[0] for each in pip.files or ()} - {".."}:
                shutil.copytree(str(pip.locate_file(name)), packages / name)
            (empty / "bin/pip").touch(0o755)
        shutil.copytree(empty, checkout / ".venv", symlinks=True)
    shutil.copy(ROOT / "Makefile", checkout)
    shutil.copy(ROOT / "scripts/bootstrap.sh", checkout / "scripts")
    (checkout / "pyproject.toml").write_text(SMALL)
    (checkout / "backend.py").write_text(BACKEND)
    links = folder / "links"
    links.mkdir()
    wheel = links / "speck-1-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as content:
        content.writestr("speck.py", "")
        for name, text in {
            "METADATA": "Metadata-Version: 2.1\nName: speck\nVersion: 1\n",
            "WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
            "RECORD": "",
        }.items():
            content.writestr(f"speck-1.dist-info/{name}", text)
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()
    (checkout / "requirements.lock").write_text(f"speck==1 --hash=sha256:{digest}\n")
    base |= {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": links.as_uri()}
    done = shell(what, changes, ["make", "setup"], checkout, place.home, base)
    wrong = verdict(done, what.set_up)
    python = checkout / ".venv/bin/python"
    if wrong or what.set_up:
        return wrong or ("a stamp is left" if (checkout / ".venv/.ready").exists() else "")
    for name, home in (("speck", checkout / ".venv"), ("small", checkout / ".venv")):
        found = subprocess.run(
            [python, "-I", "-c", f"import {name}; print({name}.__file__)"],
            capture_output=True, text=True, env={"PYTHONUTF8": "1"},
        )  # fmt: skip
        if not found.stdout.startswith(str(home)):
            return f"{name} is not in the environment: {found.stdout}{found.stderr}"
    return "" if list(place.spare.glob("other*")) == [] else "something was installed elsewhere"


@cache
def tracked() -> list[str]:
    """Files of the checkout."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    return [name for name in os.fsdecode(listed.stdout).split("\0") if name]


def copied(target: Path, link: bool = True) -> Path:
    """A copy of the checkout, with a link to its environment or without one."""
    for name in tracked():
        if (ROOT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)
    if link:
        (target / ".venv").symlink_to(ROOT / ".venv")
    return target


def job(folder: Path, what: Environment, whole: bool) -> tuple[str, dict[str, str]]:
    """Run the commands in an environment: what is wrong, and digests of what they wrote.

    whole: five ticks of the main job, then `TEST`; else programs and a plan.
    """
    place, changes, base = start(folder, what)
    checkout = copied(folder / what.folder) if what.folder else ROOT
    if whole and what.new_venv:
        checkout = copied(folder / "checkout", link=False)
        base |= {name: text for name, text in os.environ.items() if name in OF_PIP}
    output = folder.parent / "the outputs"  # images name the files that they are made of
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir()
    (output / "square.s").write_text(SQUARE, encoding="utf-8")
    makefile = folder / "probe.mk"
    makefile.write_text(PROBE)
    order = ["run", "TICKS=5", "PLATFORMS=fpga3"] if whole else ["-f", str(makefile), "probe"]
    done = shell(what, changes, ["make", *order, f"OUTPUT={output}"], checkout, place.home, base)
    wrong = verdict(done, what.cure(whole))
    if whole and not wrong:
        done = shell(what, changes, ["make", *TEST], checkout, place.home, base)
        wrong = verdict(done, what.cure(whole))
        wrong = f"make test: {wrong}" if wrong else ""
    return wrong, {} if wrong else digests(output)


def digests(output: Path) -> dict[str, str]:
    """Name -> digest of each file, without times of day, commits, and where it is."""
    found = {}
    for file in sorted(output.iterdir()):
        content = file.read_bytes().replace(os.fsencode(output), b"")
        if file.name in ("index.html", "plan.txt"):
            content = b"there" if content else b""
        elif file.suffix == ".json":
            whole = json.loads(content)
            for name in OF_THE_PLACE:
                whole.pop(name, None)
            content = json.dumps(whole).encode()
        if not file.name.endswith(".map.json"):  # it is all about sources
            found[file.name] = hashlib.sha256(content).hexdigest()
    return found
