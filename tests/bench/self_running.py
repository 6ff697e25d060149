# SPDX-License-Identifier: Apache-2.0
"""Benches of SystemVerilog with a clock of their own, Verilated into a program."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence
from pathlib import Path

from sim.rtl import waves
from sim.rtl.build import verilator_driver
from sim.rtl.linked import linked
from sim.rtl.plain import plain, workshop

RUNTIME = ("verilated", "verilated_threads", "verilated_timing")
OPTIONS = "--binary --timing --assert -O3 -Wno-fatal --x-initial unique --x-assign unique"


class Program:
    """Bench `top` as a program in `folder`, or with WAVES=1 in a folder next to it.

    `options` are further ones of Verilator, `optimisation` is the compiler's. Raises RuntimeError
    with the end of the log.
    """

    def __init__(
        self,
        top: str,
        sources: Sequence[Path],
        folder: Path,
        *options: str,
        optimisation: str = "-O1",
    ) -> None:
        self.top = top
        self.folder = folder.with_name(f"{folder.name}_waves") if waves.wanted() else folder
        self.folder.mkdir(parents=True, exist_ok=True)
        work = workshop(self.folder)
        objects, variables = linked(*RUNTIME, optimisation=optimisation)
        command = [verilator_driver(), *OPTIONS.split(), "-CFLAGS", "-std=c++20", *options]
        command += ["-MAKEFLAGS", variables, *objects, *waves.flags(), "--top-module", top]
        command += ["--Mdir", work, *(plain(path) for path in sources)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"building {top} failed:\n{(done.stdout + done.stderr)[-3000:]}")
        self.program = work / f"V{top}"

    def run(self, *arguments: str, seed: int = 1) -> subprocess.CompletedProcess[str]:
        """Run it with `+name=value` arguments; what is not set at the start is random."""
        words = [*arguments, "+verilator+rand+reset+2", f"+verilator+seed+{seed}"]
        words += [f"+waves={waves.new_file(self.top)}"] if waves.wanted() else []
        return subprocess.run([str(self.program), *words], capture_output=True, text=True)
