# SPDX-License-Identifier: Apache-2.0
"""pysoem with frames that are lost, damaged before the slaves, or lost on their way back.

    unshare -rn python -m sim.bus.disturbed_run --frames 5

Three slaves of `master_loop` in OP; `frames` cycles in a row are disturbed in each way, then so
many are lost that the watchdog of the process data, set to WATCHDOG_MS, runs out.
Prints a report as JSON.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from contextlib import closing

from asip_asm.command import command
from sim.bus.coe.dictionary import load
from sim.bus.gen import esc_regmap
from sim.bus.line import DISTURBANCES, Line
from sim.bus.master_loop import prepare
from sim.bus.pysoem_master import Master, read
from sim.bus.tap import command_line, open_tap

SLAVES = 3
WATCHDOG_MS = 4
WAIT_US = 50_000  # of this machine's clock, for an answer that does not come
ANSWER_US = 2_000_000
GOOD = 10  # cycles after each disturbance
SETTLED = 100  # cycles in which inputs must show the last outputs
LONG = 150  # frames, each at least 50 us of simulated time
COUNTERS = {
    "invalid": esc_regmap.INVALID_FRAMES_0,
    "forwarded": esc_regmap.FORWARDED_ERRORS_0,
    "rx": esc_regmap.RX_ERRORS_0,
    "watchdog": esc_regmap.WATCHDOG_DATA_COUNT,
}


class Trial:
    """The master's cycles."""

    def __init__(self, line: Line, master: Master) -> None:
        self.line, self.master, self.value = line, master, 0

    def cycles(self, count: int, wait_us: int = ANSWER_US) -> int:
        """Each with the next value in all outputs; how many counters were missing or wrong."""
        wrong = 0
        for _ in range(count):
            self.value = self.value % 255 + 1
            wrong += not self.master.exchange(self.value, wait_us)
        return wrong

    def counted(self) -> dict[str, list[int]]:
        """By the master, of each slave."""
        slaves = self.master.pysoem.slaves
        return {
            name: [read(slave, register, ANSWER_US) for slave in slaves]
            for name, register in COUNTERS.items()
        }

    def seen(self) -> list[int]:
        """How far the inputs are behind the last value, of each slave."""
        return [self.value - data[0] for data in self.master.inputs()]

    def settle(self) -> None:
        """The last outputs again until all inputs show them. Raises RuntimeError.

        A slave's program is some cycles late, how many depends on the load of this machine.
        """
        for _ in range(SETTLED):
            if not any(self.seen()):
                return
            self.master.pysoem.send_processdata()
            self.master.pysoem.receive_processdata(ANSWER_US)
        raise RuntimeError(f"inputs do not show the last outputs in {SETTLED} cycles")

    def phase(self, kind: str, frames: int) -> dict[str, object]:
        """Frames of that kind in a row, then good cycles; what they came to.

        wrong, wrong_behind: counters that were missing or wrong while it lasted and after it;
        in_op: all slaves; inputs: `seen` before, in its course and after; counted: what counters
        of each slave rose by.
        """
        self.settle()
        before, inputs = self.counted(), [self.seen()]
        self.line.disturb(kind, frames)
        wrong = self.cycles(frames, WAIT_US)
        if self.line.disturbed(kind):
            raise RuntimeError(f"{self.line.disturbed(kind)} frames were not {kind}")
        behind = self.cycles(1)
        inputs.append(self.seen())
        behind += self.cycles(GOOD - 1)
        inputs.append(self.seen())
        after = self.counted()
        rises = {
            name: [b - a for a, b in zip(before[name], after[name], strict=True)] for name in after
        }
        return {
            "wrong": wrong,
            "wrong_behind": behind,
            "in_op": self.master.in_op(),
            "inputs": inputs,
            "counted": rises,
        }


def run(frames: int) -> dict[str, dict]:
    """By kind, and `long` for those lost until the watchdog ran out. Raises RuntimeError."""
    with Line([0.0] * SLAVES) as line:
        prepare(line, load())
        watchdog = (10 * WATCHDOG_MS).to_bytes(2, "little")  # of 100 us
        with line.served(open_tap()), closing(Master(line.slaves)) as master:
            master.to_safeop()
            for slave in master.pysoem.slaves:
                slave._fpwr(esc_regmap.WATCHDOG_DATA.address, watchdog, ANSWER_US)
            master.from_safeop()
            trial = Trial(line, master)
            trial.cycles(GOOD)
            found = {kind: trial.phase(kind, frames) for kind in DISTURBANCES}
            found["long"] = trial.phase("lost", LONG)
            return found


@command("python -m sim.bus.disturbed_run")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 when it ran."""
    parser = command_line(__doc__, "disturbed_run --frames 5")
    parser.add_argument("--frames", type=int, default=5, help="disturbed in a row (default 5)")
    print(json.dumps(run(parser.parse_args(argv).frames)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
