# SPDX-License-Identifier: Apache-2.0
"""pysoem's own set-up of distributed clocks, with slaves whose clocks and cables differ.

    unshare -rn python -m sim.bus.dc_run --cycles 300

pysoem measures the delays, writes delays and offsets, sets SYNC0 of every slave and goes to OP,
where it sends the reference's time in each cycle. The report, JSON, has what it wrote next to what
the simulation knows. Times are ns.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from contextlib import closing

from asip_asm.command import command
from sim.bus.coe.dictionary import load
from sim.bus.datagram import ARMW, BWR, single
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from sim.bus.master_loop import cycle, prepare
from sim.bus.pysoem_master import Master
from sim.bus.tap import command_line, open_tap

PPM = (0.0, 100.0, -100.0)
CABLES_PS = (25_000, 500_000, 1_200_000)
SYNC0_NS, SHIFT_NS = 1_000_000, 200_000
SHARE_NS = 31_250  # between frames with the reference's time, once pysoem has ended
PULSES = 3
STEP_NS = CLOCK_NS = 10


def set_up(line: Line, cycles: int) -> tuple[bool, str, int, list[int]]:
    """By pysoem: whether it found such clocks, the state, wrong counters; of each slave what its
    system time had more than offset and clock, before the reference's time was sent."""
    with closing(Master(line.slaves)) as master:
        tap = open_tap()
        with line.served(tap):
            master.to_safeop()
            found = master.pysoem.config_dc()
            for slave in master.pysoem.slaves:
                slave.dc_sync(True, SYNC0_NS, SHIFT_NS)
        rests = [
            line.time(n) - line.read(esc_regmap.TIME_OFFSET, slave=n) - CLOCK_NS * line.clocks(n)
            for n in range(line.slaves)
        ]
        with line.served(tap):
            master.from_safeop()
            wrong, _, _, _ = cycle(master, cycles, lambda _: None)
            return found, "OP" if master.in_op() else "not OP", wrong, rests


def true_delays(line: Line) -> list[float]:
    """Mean over some frames."""
    sums = [0.0] * line.slaves
    for _ in range(frames := 8):
        line.exchange(single(BWR, 0, esc_regmap.RECEIVE_TIME_0.address, bytes(4)))
        for n in range(line.slaves):
            sums[n] += (line.arrived(n) - line.arrived(0)) / 1000
    return [total / frames for total in sums]


def pulses(line: Line, start: int) -> tuple[list[list[int]], list[int]]:
    """Rises of SYNC0 of each slave from that system time on, and those of the first slave by its
    own clock after `start` and whole cycles."""
    share = single(ARMW, 0, esc_regmap.SYSTEM_TIME.address, bytes(8))
    while line.time() < start - SHARE_NS:
        line.pass_by(share, SHARE_NS)
    seen: list[list[int]] = [[] for _ in range(line.slaves)]
    late: list[int] = []
    before = [1] * line.slaves
    steps = 0
    while min(map(len, seen)) < PULSES:
        if steps % (SHARE_NS // STEP_NS) == 0:
            line.send(share)
        steps += 1
        line.run(STEP_NS)
        for n in range(line.slaves):
            level = line.sync(n) & 1
            if level and not before[n]:
                seen[n].append(line.now // 1000)
                if n == 0:
                    late.append(line.time() - start - SYNC0_NS * len(late))
            before[n] = level
    first = min(times[0] for times in seen)
    return [[time - first for time in times[:PULSES]] for times in seen], late[:PULSES]


def run(cycles: int) -> dict[str, object]:
    """The report. Raises RuntimeError with the state reached.

    delays: written (0928); true_delays: of a frame, from the first slave's port 0 to each one's;
    offsets: written (0920), less the first one's; true_offsets: of the local clocks when the master
    latched them, the first one's less each one's; rests: of system times, less offsets and local
    clocks, and the first one's. pulses: rises of SYNC0 of each slave, by the
    simulation's clock, after the first one of all; starts: set (0990), cycles: set (09A0);
    late: the first slave's rises after its start time and cycles. wrong_counters: in OP.
    """
    with Line(PPM) as line:
        for place, length in enumerate(CABLES_PS):
            line.length(place, length)
        prepare(line, load())
        found, state, wrong, rests = set_up(line, cycles)
        slaves = range(line.slaves)
        offsets = [line.read(esc_regmap.TIME_OFFSET, slave=n) for n in slaves]
        local = [line.read(esc_regmap.RECEIVE_TIME_UNIT, slave=n) for n in slaves]
        starts = [line.read(esc_regmap.START_TIME, slave=n) for n in slaves]
        delays = [line.read(esc_regmap.TIME_DELAY, slave=n) for n in slaves]
        truth = true_delays(line)
        rises, late = pulses(line, starts[0])
        return {
            "found": found,
            "state": state,
            "wrong_counters": wrong,
            "delays": delays,
            "true_delays": truth,
            "offsets": [value - offsets[0] for value in offsets],
            "true_offsets": [local[0] - value for value in local],
            "rests": [rest - rests[0] for rest in rests],
            "starts": starts,
            "cycles": [line.read(esc_regmap.SYNC0_CYCLE, slave=n) for n in slaves],
            "pulses": rises,
            "late": late,
        }


@command("python -m sim.bus.dc_run")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if the slaves came to OP, 1 if not."""
    parser = command_line(__doc__, "dc_run --cycles 300")
    parser.add_argument("--cycles", type=int, default=300, help="cycles in OP (default 300)")
    report = run(parser.parse_args(argv).cycles)
    print(json.dumps(report))
    return 0 if report["state"] == "OP" else 1


if __name__ == "__main__":
    sys.exit(main())
