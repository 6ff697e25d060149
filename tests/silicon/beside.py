# SPDX-License-Identifier: Apache-2.0
"""A module at work with its netlist beside it: the same inputs, every output in every clock.

Random inputs are no frame, and they keep the gates of a drive off. Here a checker is bound to the
module inside the model of an existing test. A difference ends the process, so `run` starts one:

python -m tests.silicon.beside ethercat_slave 100
"""

from __future__ import annotations

import argparse
import functools
import operator
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

from sim.ethercat.datagram import APWR, single
from sim.ethercat.gen import esc_regmap
from sim.ethercat.line import Line
from sim.harness import build
from tests.bench.faults import write_if_changed
from tests.ethercat.test_frames import SEED, run_chains
from tests.servo.test_chain import chain
from tests.silicon.lockstep import CLOCK, RESET, Outcome, output_bits, still_bits
from tests.silicon.netlist import BUILD, ROOT, Netlist, NetlistError, make_netlist

DIFFERS, MOVED = "differs from its netlist at clock", "outputs that have changed:"


def frames(count: int) -> None:
    """Tests of frames, disturbances and clocks, an interrupt, then so many chains of datagrams.

    Raises AssertionError.
    """
    files = [str(ROOT / f"tests/ethercat/test_{n}.py") for n in ("frames", "disturbed", "clocks")]
    options = ["-q", "-s", "-x", "-n0", "-m", "not full", "-p", "no:cacheprovider"]
    assert pytest.main([*options, *files]) == pytest.ExitCode.OK, "a test fails"
    interrupt()
    run_chains(count, SEED)


def interrupt() -> None:
    """The master asks for a state, and the application is told."""
    with Line() as line:
        line.write(esc_regmap.AL_EVENT_MASK, esc_regmap.AL_EVENT.word(al_control=1))
        asked = esc_regmap.AL_CONTROL.word(state=1).to_bytes(2, "little")
        line.exchange(single(APWR, 0, esc_regmap.AL_CONTROL.address, asked))


def control_periods(count: int) -> None:
    """Start-up of five drives and so many control periods of 12 500 clocks on a path."""
    machine, _ = chain(True, "tracking_optimised")
    machine.advance(count)
    machine.system.close()


WORK: dict[str, Callable[[int], None]] = {
    "ethercat_slave": frames,
    "drive_front_end": control_periods,
}


def checker(top: str, netlist: Netlist) -> str:
    """SystemVerilog text: the netlist with the module's ports as inputs, bound to the module."""
    ports = [
        f"input logic [{bits - 1}:0] {name}" if bits > 1 else f"input logic {name}"
        for name, (_, bits) in netlist.ports.items()
    ]
    outputs = [name for name, (direction, _) in netlist.ports.items() if direction == "output"]
    high = len(output_bits(netlist)) - 1
    pins, at = [], 0
    for name, (direction, bits) in netlist.ports.items():
        pins.append(f".{name}({name if direction == 'input' else f'netlist[{at}+:{bits}]'})")
        at += bits if direction == "output" else 0
    return (
        f"module {top}_beside ({', '.join(ports)});\n"
        f"  logic [{high}:0] rtl, netlist, before_q, moved_q, moved;\n"
        "  logic begun_q;\n"
        "  logic [63:0] clocks_q = 0;\n"
        f"  assign rtl = {{{', '.join(reversed(outputs))}}};\n"
        "  assign moved = begun_q ? moved_q | rtl ^ before_q : '0;\n"
        f"  {netlist.module} u_netlist ({', '.join(pins)});\n"
        f"  always @(posedge {CLOCK}) begin\n"
        "    clocks_q <= clocks_q + 1;\n"
        "    before_q <= rtl;\n"
        "    moved_q <= moved;\n"
        f"    begun_q <= {RESET};\n"
        f'    if (moved != moved_q) $display("{MOVED} %h", moved);\n'
        f"    if ({RESET} && rtl != netlist)\n"
        f'      $fatal(1, "{top} {DIFFERS} %0d: %h", clocks_q, rtl ^ netlist);\n'
        "  end\n"
        "endmodule\n"
        f"bind {top} {top}_beside u_beside (.*);\n"
    )


@contextmanager
def bound(top: str, folders: Sequence[Path] = (ROOT / "rtl",)) -> Iterator[None]:
    """Models built meanwhile have the netlist beside `top`. Raises NetlistError."""
    netlist = make_netlist(top, None, f"{top}_netlist", folders)
    text = BUILD / f"beside_{netlist.verilog.parent.name}.sv"
    write_if_changed(text, checker(top, netlist))
    before = build.beside, build.optimisation
    build.beside, build.optimisation = (*netlist.sources, text), "-O1"
    try:
        yield
    finally:
        build.beside, build.optimisation = before


def run(top: str, count: int, folders: Sequence[Path] = (ROOT / "rtl",)) -> Outcome:
    """Compare `top` with its netlist, made from `folders`, at work.

    first: a clock of the instance. Raises NetlistError, also where the work itself fails.
    """
    netlist = make_netlist(top, None, f"{top}_netlist", folders)
    command = [sys.executable, "-m", __spec__.name, top, count, "--folders", *folders]
    done = subprocess.run([*map(str, command)], cwd=ROOT, capture_output=True, text=True)
    said = done.stdout + done.stderr
    moved = functools.reduce(
        operator.or_, (int(word, 16) for word in re.findall(rf"{MOVED} (\w+)", said)), 0
    )
    first = re.search(rf"{DIFFERS} (\d+)", said)
    if done.returncode and not first:
        raise NetlistError(f"{top} at work: {said.strip().splitlines()[-1]}\n{said}")
    bits, still = len(output_bits(netlist)), still_bits(netlist, moved)
    return Outcome(int(first[1]) if first else None, bits, still)


def main() -> None:
    """Command line: which module, and how much work."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("top", choices=WORK)
    parser.add_argument("count", type=int)
    parser.add_argument("--folders", nargs="+", type=Path, default=[ROOT / "rtl"])
    options = parser.parse_args()
    with bound(options.top, options.folders):
        WORK[options.top](options.count)


if __name__ == "__main__":
    main()
