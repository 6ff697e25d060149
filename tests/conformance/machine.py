# SPDX-License-Identifier: Apache-2.0
"""Runs programs for DejaGnu: `python -m tests.conformance.machine fpga1|fpga2|qemu`.

Reads the path of an ELF file per line from standard input, executes it from a reset, and answers
with a line: `pass` for the exit status 0, else `fail` and the reason.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

from sim.rtl.n2_lockstep import find_qemu
from sim.rtl.nios_image import ImageError, read_elf
from sim.rtl.nios_rtl import NiosRtl

MACHINES = ("fpga1", "fpga2", "qemu")
CYCLES = 400_000_000  # of the RTL, a few minutes
SECONDS = 60  # of QEMU
QEMU = "-M nios2-generic-nommu -display none -monitor none -serial none -semihosting".split()


def on_rtl(system: str) -> Callable[[Path], str]:
    """What executes a program on one model of a system; an empty answer is exit status 0."""
    core = NiosRtl(system)

    def execute(elf: Path) -> str:
        try:
            core.load(read_elf(elf))
        except ImageError as error:
            return str(error)
        core.guard()
        core.start()
        status = core.advance(CYCLES)
        if core.stray is not None:
            return f"access to 0x{core.stray:08x} at 0x{core.pc:08x}"
        if status is None:
            return f"no end within {CYCLES} cycles"
        return f"exit status {status}" if status else ""

    return execute


def on_qemu(elf: Path) -> str:
    """Execute a program under QEMU; an empty answer is exit status 0."""
    command = [find_qemu() or "qemu-system-nios2", *QEMU, "-kernel", elf]
    try:
        done = subprocess.run(command, stdin=subprocess.DEVNULL, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return f"no end within {SECONDS} s"
    return f"exit status {done.returncode}" if done.returncode else ""


def main(arguments: list[str]) -> int:
    """Serve until standard input ends."""
    if len(arguments) != 1 or arguments[0] not in MACHINES:
        print(f"error: one of {', '.join(MACHINES)}", file=sys.stderr)
        return 2
    execute = on_qemu if arguments[0] == "qemu" else on_rtl(arguments[0])
    for line in sys.stdin:
        reason = execute(Path(line.rstrip("\n")))
        print(f"fail {reason}" if reason else "pass", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
