# SPDX-License-Identifier: Apache-2.0
"""LinuxCNC, unmodified, drives the step and direction front-end: a program from begin to end.

    python -m sim.bus.linuxcnc.steps part.ngc     prints a report as JSON

Component microtick_steps writes the registers of motion_front_end in RTL, each access through the
host port. The edges on the lines, counted here, are compared with LinuxCNC's targets.
"""

from __future__ import annotations

import argparse
import json
import struct
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from asip_asm.command import run_command
from sim.bus.linuxcnc.config import STEPS, LinuxcncError, missing, prepare, started
from sim.bus.linuxcnc.link import AXES, FROM_MASTER, TO_MASTER, receive
from sim.robot.parameters import Robot
from sim.rtl.gen.motion_regmap import REGMAP
from sim.rtl.motion_rtl import CLOCK_HZ, MotionRtl

PROG = "python -m sim.bus.linuxcnc.steps"
READ, WRITE, PERIOD = range(3)  # kinds of an access
ACCESS = struct.Struct("=3I")
PERIOD_CLOCKS = CLOCK_HZ // 1000
WORD = REGMAP.address("PATH_WORD")


class Port:
    """The host port of the front-end.

    wanted: steps that the commands have requested by axis (5,); history: the same at the end of
    each period, with its clock.
    """

    def __init__(self) -> None:
        self.rtl = MotionRtl()
        self.wanted = np.zeros(AXES, np.int64)
        self.line = np.zeros(AXES, np.int64)
        self.next_period = PERIOD_CLOCKS
        self.history: list[tuple[int, ...]] = []

    def access(self, kind: int, address: int, data: int) -> int:
        """One access; the word that is read."""
        if kind == READ:
            return self.rtl.load(address)
        if kind == PERIOD:
            self.rtl.clock(self.next_period - self.rtl.now)
            self.next_period += PERIOD_CLOCKS
            self.history.append((self.rtl.now, *self.wanted))
            return 0
        self.rtl.store(address, data)
        if WORD <= address < WORD + AXES:
            self.line[address - WORD] = data - (data >> 31 << 32)
        if address == REGMAP.address("PATH_COMMAND"):
            self.wanted += self.line
        return 0

    def counted(self) -> NDArray[np.int64]:
        """Steps on the lines (periods, 5) up to the end of each period, by their edges."""
        edges = self.rtl.edges()
        ends = np.array(self.history)[:, 0]
        columns = []
        for axis in range(AXES):
            at = edges.pulses(axis)
            negative = edges.direction[np.searchsorted(edges.clock, at)] >> axis & 1
            sums = np.concatenate(([0], np.cumsum(1 - 2 * negative.astype(np.int64))))
            columns.append(sums[np.searchsorted(at, ends, side="right")])
        return np.stack(columns, axis=1)


def serve(port: Port, folder: Path) -> None:
    """Answer the component until LinuxCNC goes away."""
    with (
        (folder / TO_MASTER).open("rb", buffering=0) as to_port,
        (folder / FROM_MASTER).open("wb", buffering=0) as from_port,
    ):
        while len(head := receive(to_port, 4)) == 4:
            data = receive(to_port, ACCESS.size * int.from_bytes(head, sys.byteorder))
            done = [(k, a, port.access(k, a, d)) for k, a, d in ACCESS.iter_unpack(data)]
            from_port.write(b"".join(ACCESS.pack(*one) for one in done))


def play(folder: Path, program: Path) -> dict[str, Any]:
    """The whole run in an empty folder. Raises LinuxcncError.

    steps: counted on the lines by axis; apart: most steps between lines and commands at the end of
    a period; at_rest: the same when all is over; end: LinuxCNC's position [mm, degrees].
    """
    prepare(folder, Robot.load(None), program, component=STEPS)
    port = Port()
    with (folder / "linuxcnc.log").open("w") as log, started(folder, log) as cnc:
        serve(port, folder)
        cnc.wait()
    lines = (folder / "screen.jsonl").read_text(encoding="utf-8").splitlines()
    events = [json.loads(line) for line in lines]
    rest = next((line for line in events if line["event"] == "rest"), None)
    texts = [line["text"] for line in events if line["event"] in ("message", "failed")]
    if rest is None:
        raise LinuxcncError(f"LinuxCNC has run no program: {'; '.join(texts)}")
    counted = port.counted()
    apart = np.abs(counted - np.array(port.history)[:, 1:]).max(axis=1)
    return {
        "periods": len(apart),
        "lost": rest["lost"],
        "steps": counted[-1].tolist(),
        "apart": int(apart.max()),
        "at_rest": int(apart[-1]),
        "faults": sorted(port.rtl.path_faults()),
        "end": rest["position"],
        "messages": texts,
    }


def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if LinuxCNC had nothing to complain of."""
    parser = argparse.ArgumentParser(prog=PROG, description=(__doc__ or "").splitlines()[0])
    parser.add_argument("program", type=Path, help="G-code")
    options = parser.parse_args(argv)

    def run() -> int:
        if lack := missing():
            raise LinuxcncError(lack)
        with tempfile.TemporaryDirectory() as name:
            report = play(Path(name), options.program)
        print(json.dumps(report))
        return int(bool(report["messages"] or report["lost"] or report["faults"]))

    return run_command(PROG, run, LinuxcncError)


if __name__ == "__main__":
    sys.exit(main())
