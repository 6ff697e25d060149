# SPDX-License-Identifier: Apache-2.0
"""pysoem, unmodified, on both ends of a ring: to OP, then a cable is pulled and plugged again.

    unshare -rn python -m sim.bus.redundant --slaves 3 --cycles 100 --cable 1

TAP device ec0 is at the first slave's port 0, ec1 at the last one's port 1. A third of the cycles
passes with the whole ring, one with that cable pulled, one with it plugged. Prints a report as
JSON. The slaves are those of `master_loop`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from contextlib import closing
from typing import Any

from asip_asm.command import command
from sim.bus.coe.dictionary import load
from sim.bus.gen import esc_regmap
from sim.bus.line import Line
from sim.bus.master_loop import cycle, prepare
from sim.bus.pysoem_master import Master
from sim.bus.tap import INTERFACE, command_line, open_tap

SECOND = "ec1"
PHASES = ("whole", "broken", "mended")


def run(line: Line, cycles: int, cables: Sequence[int]) -> dict[str, Any]:
    """What it came to. Raises RuntimeError with the state reached.

    wrong_counters: of each of PHASES; lost_links: of each slave's ports (0, 1).
    """
    taps = open_tap(INTERFACE), open_tap(SECOND)
    wrong, torn, echoes = {}, 0, 0
    with line.served(*taps), closing(Master(line.slaves, SECOND)) as master:
        master.to_op()
        for name in PHASES:
            line.pull(*(cables if name == "broken" else ()))
            part = cycles // 3 if name != "broken" else cycles - cycles // 3 * 2
            wrong[name], more_torn, more_echoes, _ = cycle(master, part, lambda _: None)
            torn += more_torn
            echoes += more_echoes
        state = "OP" if master.in_op() else "not OP"
        expected = master.expected_counter()
    counters = (esc_regmap.LOST_LINKS_0, esc_regmap.LOST_LINKS_1)
    return {
        "slaves": line.slaves,
        "cables": list(cables),
        "state": state,
        "expected_counter": expected,
        "cycles": cycles,
        "wrong_counters": wrong,
        "torn_inputs": torn,
        "echoes": echoes,
        "lost_links": [
            [line.read(register, slave=n) for register in counters] for n in range(line.slaves)
        ],
    }


@command("python -m sim.bus.redundant")
def main(argv: Sequence[str] | None = None) -> int:
    """Command line; exit 0 if the slaves stayed in OP and no counter was wrong, 1 if not."""
    parser = command_line(__doc__, "redundant --slaves 3 --cable 1")
    parser.add_argument("--slaves", type=int, default=3, help="slaves in the ring (default 3)")
    parser.add_argument("--cycles", type=int, default=90, help="cycles in OP (default 90)")
    parser.add_argument(
        "--cable",
        type=int,
        nargs="+",
        default=[1],
        help="pulled: that before this slave; the last one is back to the master (default 1)",
    )
    options = parser.parse_args(argv)
    if not all(0 <= cable <= options.slaves for cable in options.cable):
        parser.error(f"--cable {options.cable}: there are 0 to {options.slaves}")
    with Line([0.0] * options.slaves, closed=True) as line:
        prepare(line, load())
        report = run(line, options.cycles, options.cable)
    print(json.dumps(report))
    return 0 if report["state"] == "OP" and not any(report["wrong_counters"].values()) else 1


if __name__ == "__main__":
    sys.exit(main())
