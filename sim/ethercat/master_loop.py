# SPDX-License-Identifier: Apache-2.0
"""pysoem, unmodified, against Verilated slaves: to OP, then cycles; prints a report as JSON.

    unshare -rn python -m sim.ethercat.master_loop --slaves 3 --cycles 1000 --capture bus.pcap

The slaves have no processor here: the controllers' device emulation answers for the state machine,
and what the master writes to the outputs goes back as inputs. Each cycle writes one value to all
outputs: inputs of two values would be a torn buffer.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import pysoem

from sim.coe.dictionary import Device, load
from sim.coe.sii import image
from sim.ethercat.gen import esc_regmap
from sim.ethercat.line import Line
from sim.ethercat.tap import INTERFACE, open_tap

MAILBOX = slice(0x30, 0x3A)  # bytes of the SII: areas and protocols
STATE_TIMEOUT_US = 60_000_000
FRAME_TIMEOUT_US = 2_000_000
OUTPUT_MANAGER = 2


@dataclass(frozen=True)
class Report:
    """What a run came to. Times are this machine's; those of the bus are counted in clocks."""

    slaves: int
    state: str
    expected_counter: int
    cycles: int
    wrong_counters: int
    torn_inputs: int
    echoes: int  # cycles whose inputs were outputs of an earlier cycle
    seconds: float
    median_us: float
    frames: int


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


def to_state(master: pysoem.Master, state: int) -> int:
    """Ask for the state; returns the lowest one reached."""
    master.state = state
    master.write_state()
    return master.state_check(state, STATE_TIMEOUT_US)


def cycle(
    master: pysoem.Master, cycles: int, progress: Callable[[int], None]
) -> tuple[int, int, int, list[float]]:
    """Cycles in OP: wrong counters, torn inputs, echoes, times [us]."""
    wrong = torn = echoes = 0
    times = []
    for n in range(cycles):
        value = n % 255 + 1
        for slave in master.slaves:
            slave.output = bytes([value]) * len(slave.output)
        began = time.perf_counter()
        master.send_processdata()
        counter = master.receive_processdata(FRAME_TIMEOUT_US)
        times.append(1e6 * (time.perf_counter() - began))
        wrong += counter != master.expected_wkc
        for slave in master.slaves:
            seen = set(slave.input[: len(slave.output)])
            torn += len(seen) != 1
            echoes += bool(seen - {0})
        progress(n + 1)
    return wrong, torn, echoes, times


def run(line: Line, cycles: int, progress: Callable[[int], None]) -> Report:
    """Bring all slaves of the line to OP and run. Raises RuntimeError with the state reached."""
    tap = open_tap()
    service = threading.Thread(target=line.serve, args=(tap,), daemon=True)
    service.start()
    for name in ("ret", "safe", "eeprom", "state"):  # simulated wires are slow
        setattr(pysoem.settings.timeouts, name, FRAME_TIMEOUT_US)
    master = pysoem.Master()
    began = time.perf_counter()
    try:
        master.open(INTERFACE)
        if (found := master.config_init()) != line.slaves:
            raise RuntimeError(f"pysoem found {found} slaves, there are {line.slaves}")
        master.config_map()
        if (
            state := master.state_check(pysoem.SAFEOP_STATE, STATE_TIMEOUT_US)
        ) != pysoem.SAFEOP_STATE:
            raise RuntimeError(f"the slaves are in state {state}, not in SAFEOP")
        master.send_processdata()
        master.receive_processdata(FRAME_TIMEOUT_US)
        if (state := to_state(master, pysoem.OP_STATE)) != pysoem.OP_STATE:
            raise RuntimeError(f"the slaves are in state {state}, not in OP")
        wrong, torn, echoes, times = cycle(master, cycles, progress)
        master.read_state()
        in_op = all(slave.state == pysoem.OP_STATE for slave in master.slaves)
        return Report(
            slaves=line.slaves,
            state="OP" if in_op else "not OP",
            expected_counter=master.expected_wkc,
            cycles=cycles,
            wrong_counters=wrong,
            torn_inputs=torn,
            echoes=echoes,
            seconds=round(time.perf_counter() - began, 3),
            median_us=round(statistics.median(times), 1) if times else 0.0,
            frames=line.carried[0],
        )
    finally:
        master.close()
        line.stop()
        service.join()


def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if the slaves came to OP and no counter was wrong, 1 if not."""
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0],
        epilog="example: unshare -rn python -m sim.ethercat.master_loop --slaves 1 --cycles 100",
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
        every = max(1, arguments.cycles // 20)
        began = time.monotonic()

        def progress(n: int) -> None:
            if n % every == 0 and sys.stderr.isatty():
                left = (time.monotonic() - began) / n * (arguments.cycles - n)
                print(
                    f"\r{n} of {arguments.cycles} cycles, {left:.0f} s left",
                    end="",
                    file=sys.stderr,
                )

        report = run(line, arguments.cycles, progress)
    print(json.dumps(asdict(report)))
    return 0 if report.state == "OP" and not report.wrong_counters and not report.torn_inputs else 1


if __name__ == "__main__":
    sys.exit(main())
