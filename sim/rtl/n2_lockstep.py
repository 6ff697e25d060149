# SPDX-License-Identifier: Apache-2.0
"""Nios II core and QEMU in lockstep: every instruction's address and all registers are compared.

QEMU (`qemu-system-nios2`, machine nios2-generic-nommu) runs a program once, one instruction per
translation block, and logs its registers before each; the core's trace of retired instructions
gives the same sequence. The program ends both with `break 1` (semihosting: r4 = 0, r5 = status).
Not comparable: custom instructions (QEMU has none) and the contents of I/O.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from asip_asm.command import command, script_parser
from asip_asm.files import write_bytes
from sim.rtl.n2_lockstep_isa import OP_CUSTOM, default_isa
from sim.rtl.n2_lockstep_rtl import DTCM, ITCM, N2Rtl
from sim.rtl.nios_image import ImageError, read_elf

# Order of QEMU's log: pc, r0..r31, then these.
LOG_CONTROL = (
    *("status", "estatus", "bstatus", "ienable", "ipending", "cpuid", "exception"),
    *("pteaddr", "tlbacc", "tlbmisc", "badaddr"),
)
LOG_COLUMNS = 33 + len(LOG_CONTROL)
VALUE = re.compile(rb"=([0-9a-f]{8})")
CHUNK = 1 << 22
EXIT = 0x003D_A07A  # break 1
SHOWN = 8


class LockstepError(RuntimeError):
    """The core and QEMU disagree, or QEMU could not run the program; the message says how."""


@dataclass(frozen=True)
class LockstepResult:
    """Instructions compared, the status the program left in r5, cycles of the core for them."""

    instructions: int
    status: int
    cycles: int


def find_qemu() -> str | None:
    """qemu-system-nios2 on PATH or next to this Python; None if there is none."""
    beside = str(Path(sys.executable).parent)
    return shutil.which("qemu-system-nios2") or shutil.which("qemu-system-nios2", path=beside)


def qemu_states(
    image: Sequence[tuple[int, bytes]], entry: int, timeout: float = 600
) -> Iterator[np.ndarray]:
    """States before each instruction as QEMU runs an image: arrays (n, LOG_COLUMNS) of words.

    image: (byte address, contents); `timeout` in seconds kills a program that never ends. Raises
    LockstepError if QEMU is missing or ends abnormally.
    """
    qemu = find_qemu()
    if qemu is None:
        raise LockstepError("error: no qemu-system-nios2 on PATH; `make tools T=qemu` gets it")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fifo = folder / "log"
        os.mkfifo(fifo)
        command = [qemu, "-M", "nios2-generic-nommu", "-display", "none", "-serial", "none"]
        command += ["-monitor", "none", "-semihosting", "-singlestep", "-d", "cpu,nochain"]
        command += ["-D", str(fifo)]
        for number, (address, data) in enumerate(image):
            write_bytes(folder / f"{number}.bin", data)
            command += ["-device", f"loader,file={folder}/{number}.bin,addr={address},force-raw=on"]
        command += ["-device", f"loader,addr={entry},cpu-num=0"]
        with subprocess.Popen(command, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL) as process:
            try:
                # Not blocking: QEMU may die before its first line.
                reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
                yield from _log_states(reader, process, time.monotonic() + timeout)
                assert process.stderr is not None
                error = process.stderr.read().decode(errors="replace").strip()
                code = process.wait()
            finally:
                process.kill()
        # The exit code is the program's own status: only the message shows a failure of QEMU.
        if code < 0 or "unhandled" in error:
            raise LockstepError(f"error: QEMU ended with {code}: {error or 'no message'}")


def _log_states(reader: int, process: subprocess.Popen, deadline: float) -> Iterator[np.ndarray]:
    rest = b""
    with os.fdopen(reader, "rb", buffering=0) as log:
        while True:
            if time.monotonic() > deadline:
                raise LockstepError("error: QEMU did not end in time")
            ended = process.poll() is not None
            data = log.read(CHUNK)
            if data:
                text = rest + data
                start = text.rfind(b"IN: PC=")
                if start <= 0:
                    rest = text
                    continue
                yield _parse(text[:start])
                rest = text[start:]
            elif ended:
                break
            else:
                try:
                    process.wait(0.002)
                except subprocess.TimeoutExpired:
                    pass
    if rest:
        yield _parse(rest)


def _parse(text: bytes) -> np.ndarray:
    digits = b"".join(VALUE.findall(text))
    words = np.frombuffer(bytes.fromhex(digits.decode()), ">u4").astype(np.uint32)
    if len(words) % LOG_COLUMNS:
        raise LockstepError("error: QEMU's log has another form; version 7.2 is known to fit")
    return words.reshape(-1, LOG_COLUMNS)


class Comparison:
    """Follows the core's records and compares them with QEMU's states, chunk by chunk."""

    def __init__(self) -> None:
        self.registers = np.zeros(32, np.uint32)
        self.done = 0

    def check(self, states: np.ndarray, records: np.ndarray) -> None:
        """States before each of `records`; raises LockstepError at the first difference."""
        count = min(len(states), len(records))
        expected, records = states[:count], records[:count]
        # Row i: registers before record i.
        found = np.empty((count + 1, 32), np.uint32)
        for register in range(32):
            changes = (records["write"] == 1) & (records["dst"] == register)
            last = np.where(changes, np.arange(1, count + 1), 0)
            last = np.maximum.accumulate(np.concatenate([[0], last]))
            values = np.concatenate([[self.registers[register]], records["value"]])
            found[:, register] = values[last]
        custom = np.flatnonzero(records["word"] & 63 == OP_CUSTOM)
        if len(custom):
            raise LockstepError(
                f"error: custom instruction at {records['pc'][custom[0]]:#010x}; QEMU has none, "
                "so compile without them"
            )
        wrong = (found[:count] != expected[:, 1:33]).any(axis=1)
        wrong |= records["pc"] != expected[:, 0]
        if wrong.any():
            self._refuse(int(wrong.argmax()), expected, records, found)
        if len(states) > len(records):
            raise LockstepError(
                f"error: the core stopped after {self.done + count} instructions, QEMU went on "
                f"at {states[count, 0]:#010x}"
            )
        self.registers = found[count]
        self.done += count

    def _refuse(
        self, at: int, expected: np.ndarray, records: np.ndarray, found: np.ndarray
    ) -> None:
        isa = default_isa()
        lines = [f"error: instruction {self.done + at} differs from QEMU"]
        for row in range(max(0, at - SHOWN), at + 1):
            record = records[row]
            text = f"  {record['pc']:08x}  {isa.disassemble(int(record['word'])):28}"
            if record["write"]:
                text += f" r{record['dst']} = {record['value']:08x}"
            if record["exception"]:
                text += f" exception {record['cause']}"
            lines.append(text)
        lines.append("before the last of these:")
        if records["pc"][at] != expected[at, 0]:
            lines.append(f"  pc  core {records['pc'][at]:08x}  QEMU {expected[at, 0]:08x}")
        for register in np.flatnonzero(found[at] != expected[at, 1:33]):
            want = expected[at, 1 + register]
            lines.append(f"  r{register}  core {found[at, register]:08x}  QEMU {want:08x}")
        raise LockstepError("\n".join(lines))


def lockstep(
    core: N2Rtl,
    image: Sequence[tuple[int, bytes]],
    most: int = 10_000_000,
    timeout: float = 600,
    waits: int = 0,
) -> LockstepResult:
    """Run an image from the reset vector on both sides until `break 1`; compare everything.

    Memories and registers are cleared, as QEMU begins so. most: instructions; waits: most wait
    states of an Avalon transfer. Raises LockstepError.
    """
    core.start(image)
    core.waits(waits, waits)
    comparison = Comparison()
    last = None
    for states in qemu_states(image, ITCM, timeout):
        upto = comparison.done + len(states)
        if upto > most:
            raise LockstepError(f"error: no end after {most} instructions")
        records = core.run(upto, 1000 + 400 * len(states))[comparison.done :]
        comparison.check(states, records)
        last = records[len(states) - 1]
        status = int(states[-1, 1 + 5])
    if last is None:
        raise LockstepError("error: QEMU executed nothing")
    if int(last["word"]) != EXIT:
        raise LockstepError("error: the program did not end with `break 1`")
    return LockstepResult(comparison.done, status, int(last["cycle"]))


@command("python -m sim.rtl.n2_lockstep")
def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; exit 0 equal, 1 for a difference or a file that does not fit."""
    prog = "python -m sim.rtl.n2_lockstep"
    purpose = "Run ELF programs on the Nios II core and QEMU in lockstep."
    parser = script_parser(purpose, f"{prog} build/nios_sw/tests/sieve.elf", prog)
    parser.add_argument("elf", type=Path, nargs="+", help="linked for the system's memory map")
    parser.add_argument(
        "--most", type=int, default=10_000_000, help="give up after this many instructions"
    )
    options = parser.parse_args(arguments)
    core = N2Rtl()
    failed = False
    for path in options.elf:
        try:
            program = read_elf(path)
            bases = {"itcm": ITCM, "dtcm": DTCM}
            image = [
                (bases[name], np.array(words, "<u4").tobytes())
                for name, words in program.memories.items()
                if words
            ]
            result = lockstep(core, image, options.most)
            print(
                f"{path}: {result.instructions} instructions equal, status {result.status:#x}, "
                f"{result.cycles / result.instructions:.3f} cycles per instruction"
            )
        except (ImageError, OSError, ValueError, LockstepError) as error:
            print(f"{path}: {error}", file=sys.stderr)
            failed = True
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
