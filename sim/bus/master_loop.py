# SPDX-License-Identifier: Apache-2.0
"""An unmodified master against Verilated slaves: to OP, then cycles; prints a report as JSON.

    unshare -rn python -m sim.bus.master_loop --slaves 3 --cycles 1000 --capture bus.pcap
    unshare -rn python -m sim.bus.master_loop --master kickcat

The slaves have no processor here: the controllers' device emulation answers for the state machine,
and what the master writes to the outputs goes back as inputs. Each cycle writes one value to all
outputs: inputs of two values would be a torn buffer.
"""

from __future__ import annotations

import importlib
import json
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path
from typing import Protocol

from asip_asm.command import command
from sim.bus.coe.dictionary import Device, load
from sim.bus.coe.sii import image
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from sim.bus.tap import command_line, open_tap, progress_of

MAILBOX = slice(0x30, 0x3A)  # bytes of the SII: areas and protocols
OUTPUT_MANAGER = 2
MASTERS = ("pysoem", "kickcat", "ethercrab")  # modules `<name>_master`


class Master(Protocol):
    """A master made for a number of slaves; `to_op` raises RuntimeError."""

    def to_op(self) -> None:
        """Bring all slaves to OP."""

    def exchange(self, value: int) -> bool:
        """A cycle with this value in all bytes of all outputs: whether the counter was right."""

    def inputs(self) -> list[bytes]:
        """Of each slave, as many bytes as it has outputs."""

    def in_op(self) -> bool:
        """Whether all slaves are."""

    def expected_counter(self) -> int | None:
        """What the master expects of a cycle, None: it keeps that to itself."""

    def close(self) -> None:
        """Give the interface back."""


def without_mailbox(device: Device) -> bytes:
    """The SII image as of a device without a mailbox: its PDOs are then taken from it."""
    whole = bytearray(image(device))
    whole[MAILBOX] = bytes(MAILBOX.stop - MAILBOX.start)
    return bytes(whole)


def prepare(line: Line, device: Device) -> None:
    """Every slave answers for itself and copies outputs to inputs."""
    areas = device.process_data
    for slave in range(line.slaves):
        line.load_sii(without_mailbox(device), slave=slave)
        line.write(esc_regmap.PDI_CONFIG, esc_regmap.PDI_CONFIG.word(emulation=1), slave=slave)
        events = esc_regmap.AL_EVENT.word(sm=1 << OUTPUT_MANAGER)
        line.write(esc_regmap.AL_EVENT_MASK, events, slave=slave)
        line.copy(
            (areas["outputs"], device.bytes("rx")),
            (areas["inputs"], device.bytes("tx")),
            slave=slave,
        )


def cycle(
    master: Master, cycles: int, progress: Callable[[int], None]
) -> tuple[int, int, int, list[float]]:
    """Cycles in OP: wrong counters, torn inputs, echoes, times [us]."""
    wrong = torn = echoes = 0
    times = []
    for n in range(cycles):
        began = time.perf_counter()
        wrong += not master.exchange(n % 255 + 1)
        times.append(1e6 * (time.perf_counter() - began))
        for data in master.inputs():
            seen = set(data)
            torn += len(seen) != 1
            echoes += bool(seen - {0})
        progress(n + 1)
    return wrong, torn, echoes, times


def run(
    line: Line, make: Callable[[int], Master], cycles: int, progress: Callable[[int], None]
) -> dict[str, object]:
    """Bring all slaves of the line to OP and run; what it came to, times by this machine's clock.

    expected_counter: None if the master does not report it; echoes: cycles whose inputs were
    outputs of an earlier cycle. Raises RuntimeError with the state reached.
    """
    with line.served(open_tap()):
        began = time.perf_counter()
        with closing(make(line.slaves)) as master:
            master.to_op()
            wrong, torn, echoes, times = cycle(master, cycles, progress)
            return {
                "slaves": line.slaves,
                "state": "OP" if master.in_op() else "not OP",
                "expected_counter": master.expected_counter(),
                "cycles": cycles,
                "wrong_counters": wrong,
                "torn_inputs": torn,
                "echoes": echoes,
                "seconds": round(time.perf_counter() - began, 3),
                "median_us": round(statistics.median(times), 1) if times else 0.0,
                "frames": line.carried[0],
            }


@command("python -m sim.bus.master_loop")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if the slaves came to OP and no counter was wrong, 1 if not."""
    parser = command_line(__doc__, "master_loop --slaves 1 --cycles 100")
    parser.add_argument(
        "--master", choices=MASTERS, default=MASTERS[0], help=f"default {MASTERS[0]}"
    )
    parser.add_argument("--slaves", type=int, default=1, help="slaves in the line (default 1)")
    parser.add_argument("--cycles", type=int, default=1000, help="cycles in OP (default 1000)")
    parser.add_argument("--capture", type=Path, help="pcap file of all frames")
    arguments = parser.parse_args(argv)
    device = load()
    with Line([0.0] * arguments.slaves) as line:
        if arguments.capture:
            line.capture(arguments.capture)
        prepare(line, device)
        progress = progress_of(arguments.cycles, max(1, arguments.cycles // 20))
        module = importlib.import_module(f"sim.bus.{arguments.master}_master")
        report = run(line, module.Master, arguments.cycles, progress)
    print(json.dumps(report))
    wrong = report["wrong_counters"] or report["torn_inputs"]
    return 0 if report["state"] == "OP" and not wrong else 1


if __name__ == "__main__":
    sys.exit(main())
