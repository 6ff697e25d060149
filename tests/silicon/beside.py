# SPDX-License-Identifier: Apache-2.0
"""A module at work next to its netlist or its plain Verilog: every output in every clock.

Random inputs are no frame, no program and no path, and they keep the gates of a drive off. Here a
checker is bound to the module inside the model of an existing test, which gives it its work
(work.py). A difference ends the process, so `run` starts one:

python -m tests.silicon.beside ethercat_slave 100
python -m tests.silicon.beside --plain biss_port 1
"""

from __future__ import annotations

import argparse
import functools
import operator
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from sim.rtl import build
from tests.bench.faults import write_if_changed
from tests.silicon.lockstep import Outcome, output_bits, still_bits
from tests.silicon.netlist import (
    BUILD,
    MODEL_FLAGS,
    ROOT,
    Netlist,
    NetlistError,
    literal,
    make_netlist,
    make_plain,
)
from tests.silicon.work import PLAIN_WORK, WORK, Work

DIFFERS, MOVED = "differs from its netlist at clock", "outputs that have changed:"


def checker(work: Work, netlist: Netlist) -> str:
    """SystemVerilog text: the netlist with the module's ports as inputs, bound to the module.

    An instance with other parameters than those of the netlist ends the build.
    """
    top = work.top
    given = {key: literal(value) for key, value in work.parameters.items()}
    shape = ", ".join(f"parameter logic [255:0] {key} = 0" for key in given)
    same = "".join(
        f'  if ({key} != {value}) $error("{top}: {key} is not its netlist\'s");\n'
        for key, value in given.items()
    )
    values = ", ".join(f".{key}({key})" for key in given)
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
        f"module {top}_beside {f'#({shape}) ' if given else ''}({', '.join(ports)});\n{same}"
        f"  logic [{high}:0] rtl, netlist, before_q, moved_q, moved;\n"
        "  logic begun_q;\n"
        "  logic [63:0] clocks_q = 0;\n"
        f"  assign rtl = {{{', '.join(reversed(outputs))}}};\n"
        "  assign moved = begun_q ? moved_q | rtl ^ before_q : '0;\n"
        f"  {netlist.module} u_netlist ({', '.join(pins)});\n"
        f"  always @(posedge {work.clock}) begin\n"
        "    clocks_q <= clocks_q + 1;\n"
        "    before_q <= rtl;\n"
        "    moved_q <= moved;\n"
        f"    begun_q <= {work.reset};\n"
        f'    if (moved != moved_q) $display("{MOVED} %h", moved);\n'
        f"    if ({work.reset} && rtl != netlist)\n"
        f'      $fatal(1, "{top} {DIFFERS} %0d: %h", clocks_q, rtl ^ netlist);\n'
        "  end\n"
        "endmodule\n"
        f"bind {top} {top}_beside {f'#({values}) ' if given else ''}u_beside (.*);\n"
    )


def netlist_of(work: Work, folders: Sequence[Path], plain: bool = False) -> Netlist:
    """Netlist, or plain Verilog, of the module as the work has it. Raises NetlistError."""
    make = make_plain if plain else make_netlist
    return make(work.top, work.parameters, f"{work.top}_netlist", folders)


@contextmanager
def bound(
    work: Work, folders: Sequence[Path] = (ROOT / "rtl",), plain: bool = False
) -> Iterator[None]:
    """Models built meanwhile have assertions, and the netlist next to the module of `work`.

    Raises NetlistError.
    """
    netlist = netlist_of(work, folders, plain)
    text = BUILD / f"beside_{netlist.verilog.parent.name}.sv"
    write_if_changed(text, checker(work, netlist))
    files = (*netlist.sources, text)
    with patch.multiple(
        build, beside=files, beside_flags=MODEL_FLAGS, optimisation="-O1", assertions=True
    ):
        yield


def run(
    name: str, count: int, folders: Sequence[Path] = (ROOT / "rtl",), plain: bool = False
) -> Outcome:
    """Compare a module with its netlist, made from `folders`, at the work `name`, so much of it.

    plain: with its plain Verilog instead, at work of PLAIN_WORK. first: a clock of the instance.
    Raises NetlistError, also where the work itself fails.
    """
    netlist = netlist_of((PLAIN_WORK if plain else WORK)[name], folders, plain)
    command = [sys.executable, "-m", __spec__.name, name, count, "--folders", *folders]
    command += ["--plain"] if plain else []
    done = subprocess.run([*map(str, command)], cwd=ROOT, capture_output=True, text=True)
    said = done.stdout + done.stderr
    moved = functools.reduce(
        operator.or_, (int(word, 16) for word in re.findall(rf"{MOVED} (\w+)", said)), 0
    )
    first = re.search(rf"{DIFFERS} (\d+)", said)
    if done.returncode and not first:
        raise NetlistError(f"{name} at work: {said.strip().splitlines()[-1]}\n{said}")
    bits, still = len(output_bits(netlist)), still_bits(netlist, moved)
    return Outcome(int(first[1]) if first else None, bits, still)


def main() -> None:
    """Command line: which module, and how much work."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("work", choices=WORK | PLAIN_WORK)
    parser.add_argument("count", type=int)
    parser.add_argument("--folders", nargs="+", type=Path, default=[ROOT / "rtl"])
    parser.add_argument("--plain", action="store_true", help="plain Verilog, not the netlist")
    options = parser.parse_args()
    table = PLAIN_WORK if options.plain else WORK
    if options.work not in table:
        parser.error(f"no work {options.work} here; there are {', '.join(table)}")
    work = table[options.work]
    with bound(work, options.folders, options.plain):
        work.do(options.count)


if __name__ == "__main__":
    main()
