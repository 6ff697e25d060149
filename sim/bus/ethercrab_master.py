# SPDX-License-Identifier: Apache-2.0
"""ethercrab (Rust), unmodified, as a master of `master_loop`: a third master, which shares no code
with the others. `build` compiles it with the locked versions of its packages.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from asip_asm.project import BUILD
from sim.bus.coe.dictionary import load
from sim.bus.tap import INTERFACE

SOURCE = Path(__file__).with_name("ethercrab")
TARGET = BUILD / "ethercrab"
PROGRAM = TARGET / "debug/ethercrab_master"
CURE = "install Rust 1.80 or later (rustup, or the system's packages rustc and cargo)"


def cargo() -> str | None:
    """Rust's package manager, also where rustup puts it."""
    own = Path.home() / ".cargo/bin/cargo"
    return shutil.which("cargo") or (str(own) if own.exists() else None)


def build() -> Path:
    """The program, made now if need be. Raises RuntimeError with the cure."""
    tool = cargo()
    if tool is None:
        raise RuntimeError(f"ethercrab needs cargo: {CURE}")
    command = [tool, "build", "--locked", "--quiet", "--target-dir", str(TARGET)]
    done = subprocess.run(command, cwd=SOURCE, capture_output=True, text=True, check=False)
    if done.returncode:
        reason = next((x for x in done.stderr.splitlines() if x.startswith("error")), "no reason")
        raise RuntimeError(f"ethercrab was not built, {reason}; {CURE}, with access to crates.io")
    return PROGRAM


class Master:
    """`master_loop.Master`. The program has to be built: here is no network."""

    def __init__(self, slaves: int) -> None:
        self._wanted, self._outputs = slaves, load().bytes("rx")
        self._first: int | None = None
        self._inputs: list[bytes] = []
        self._process = subprocess.Popen(
            [PROGRAM, INTERFACE],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def _line(self) -> list[str]:
        """Words of the next line. Raises RuntimeError with what the program printed."""
        assert self._process.stdout and self._process.stderr
        if not (line := self._process.stdout.readline()):
            raise RuntimeError(f"ethercrab: {self._process.stderr.read().strip()}")
        return line.split()

    def to_op(self) -> None:
        """Raises RuntimeError with the reason."""
        if (found := int(self._line()[0])) != self._wanted:
            raise RuntimeError(f"ethercrab found {found} slaves, there are {self._wanted}")

    def exchange(self, value: int) -> bool:
        """As `master_loop.Master` has it; the counter of the first cycle is the right one."""
        assert self._process.stdin
        self._process.stdin.write(f"{value}\n")
        self._process.stdin.flush()
        counter, *inputs = self._line()
        self._inputs = [bytes.fromhex(data)[: self._outputs] for data in inputs]
        self._first = self._first or int(counter)
        return int(counter) == self._first != 0

    def inputs(self) -> list[bytes]:
        """As `master_loop.Master` has it."""
        return self._inputs

    def in_op(self) -> bool:
        """The program goes on only while all slaves are."""
        return self._process.poll() is None

    def expected_counter(self) -> int | None:
        """That of the first cycle."""
        return self._first

    def close(self) -> None:
        """End the program."""
        assert self._process.stdin
        self._process.stdin.close()
        self._process.wait(timeout=60)
