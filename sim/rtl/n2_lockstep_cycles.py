# SPDX-License-Identifier: Apache-2.0
"""Cycle table of the Nios II core, measured on the RTL and written into docs/nios_core.md.

A row's cost is the time from the instruction before to the instruction after it, minus one cycle;
its late cycles are what a consumer right after it costs more. Vendor values: Nios II Processor
Reference Guide, instruction performance of Nios II/f.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from sim.report.marks import between_marks
from sim.rtl.n2_lockstep_program import BT, EA, ISA, RA, LabelledWords, prologue
from sim.rtl.n2_lockstep_rtl import DTCM, N2Rtl

DOCUMENT = Path(__file__).resolve().parents[2] / "docs/nios_core.md"
AVALON = 0x1100_0000
COMBINATIONAL_N = 224
CONSUMER = ("add", 9, 2, 2)


@dataclass(frozen=True)
class Row:
    """One class: `emit` puts the instruction at label X (its result in r2) into a program.

    vendor: (cycles, late cycles), None where the guide has no number; differs: why ours is another.
    occurrence: which execution of X counts; result: X has a register result.
    """

    name: str
    emit: Callable[[LabelledWords], None]
    vendor: tuple[int, int] | None
    differs: str = ""
    result: bool = False
    occurrence: int = -1


def of_row(emit: Callable[..., None]) -> Callable[..., Callable[[LabelledWords], None]]:
    """A row names what to emit first; the program to emit it into comes when it is measured."""
    return lambda *values: lambda program: emit(program, *values)


@of_row
def instruction(program: LabelledWords, name: str, *values: int) -> None:
    program.label("X")
    program.emit(name, *values)


def custom(number: int) -> Callable[[LabelledWords], None]:
    return instruction("custom", number, 2, 3, 4)


@of_row
def word(program: LabelledWords, value: int) -> None:
    program.label("X")
    program.word(value)


@of_row
def to_label(program: LabelledWords, name: str) -> None:
    program.label("X")
    program.to(name, "behind")
    program.emit("addi", 0, 0, 0)
    program.label("behind")


@of_row
def to_register(program: LabelledWords, name: str, register: int, *values: int) -> None:
    """A jump through a register that holds the address of the label after it."""
    program.la(register, "behind")
    nops(program, 4)
    program.label("X")
    program.emit(name, *values)
    program.label("behind")


@of_row
def loop(program: LabelledWords, way: str) -> None:
    """Eight turns; the branch X leaves them ('taken') or a branch that only the last takes."""
    program.emit("addi", 8, 0, 8)
    program.label("turn")
    nops(program, 4)
    program.emit("addi", 8, 8, -1)
    program.emit("addi", 0, 0, 0)
    program.label("X")
    if way == "taken":
        program.to("bne", "turn", 8, 0)
    else:
        program.to("beq", "out", 8, 0)
        program.emit("addi", 0, 0, 0)
        program.to("br", "turn")
        program.label("out")


def nops(program: LabelledWords, count: int) -> None:
    for _ in range(count):
        program.emit("addi", 0, 0, 0)


LATE = 2
ROWS = (
    Row("add, logic", instruction("add", 2, 3, 4), (1, 0), result=True),
    Row("compare", instruction("cmplt", 2, 3, 4), (1, 0), result=True),
    Row("shift, rotate", instruction("sll", 2, 3, 4), (1, LATE), result=True),
    Row("mul, muli", instruction("mul", 2, 3, 4), (1, LATE), result=True),
    Row("mulxss, mulxsu, mulxuu", instruction("mulxss", 2, 3, 4), (1, LATE), result=True),
    Row("div, divu", instruction("divu", 2, 3, 4), (35, LATE), "two bits per cycle", True),
    Row("load, tightly coupled", instruction("ldw", 2, 0, 5), (1, LATE), result=True),
    Row("store, tightly coupled", instruction("stw", 3, 0, 5), (1, 0)),
    Row("load, Avalon without wait states", instruction("ldwio", 2, 0, 6), None, result=True),
    Row("store, Avalon without wait states", instruction("stwio", 3, 0, 6), None),
    Row("branch, predicted, not taken", loop("not taken"), (1, 0), occurrence=3),
    Row("branch, predicted, taken", loop("taken"), (2, 0), occurrence=4),
    Row("branch, mispredicted, not taken", loop("taken"), (4, 0)),
    Row("branch, mispredicted, taken", loop("not taken"), (4, 0)),
    Row("br", to_label("br"), (2, 0)),
    Row("call", to_label("call"), (2, 0)),
    Row("jmpi", to_label("jmpi"), (2, 0)),
    Row("callr", to_register("callr", 7, 7), (3, 0)),
    Row("jmp", to_register("jmp", 7, 7), (3, 0)),
    Row("ret", to_register("ret", RA), (3, 0)),
    Row("eret", to_register("eret", EA), (4, 0)),
    Row("trap", instruction("trap", 0), (4, 0)),
    Row("break", instruction("break", 0), (4, 0)),
    Row("illegal instruction", word(2), (4, 0)),
    Row("wrctl", instruction("wrctl", ISA.control["ienable"], 0), (4, 0)),
    Row("rdctl", instruction("rdctl", 2, ISA.control["status"]), (1, LATE), result=True),
    Row("flushp", instruction("flushp"), (4, 0)),
    Row("flushi, initi", instruction("flushi", 5), (4, 0), "no cache: nothing to do"),
    Row("flushd, initd (and da)", instruction("flushd", 0, 5), (2, 0), "no cache: nothing to do"),
    Row("sync", instruction("sync"), None),
    Row("custom, combinational", custom(COMBINATIONAL_N), (1, 0), result=True),
    Row("custom, multicycle, done at once", custom(0), (1, LATE), result=True),
    Row("custom, multicycle, 5 cycles", custom(4), (5, LATE), result=True),
)


def measure(core: N2Rtl, row: Row) -> tuple[int, int]:
    """(cycles, late cycles) of a row on the RTL."""
    cost = [_cost(core, row, consumer) for consumer in ((False, True) if row.result else (False,))]
    return cost[0], cost[-1] - cost[0]


def _cost(core: N2Rtl, row: Row, consumer: bool) -> int:
    program = prologue()
    program.li(3, 0x1234_5678)
    program.emit("addi", 4, 0, 7)
    program.li(5, DTCM)
    program.li(6, AVALON)
    program.emit("addi", BT, 0, 1 if row.name == "break" else 0)
    nops(program, 8)
    row.emit(program)
    if consumer:
        program.emit(*CONSUMER)
    nops(program, 8)
    program.end()
    core.start(program.image())
    records = core.run(stop_pc=program.address("end"))
    at = [i for i, pc in enumerate(records["pc"]) if pc == program.address("X")][row.occurrence]
    return int(records["cycle"][at + 1] - records["cycle"][at - 1]) - 1


def text(cost: tuple[int, int]) -> str:
    """'1' or, with late cycles, '1 + 2'."""
    return f"{cost[0]} + {cost[1]}" if cost[1] else str(cost[0])


def table(core: N2Rtl) -> str:
    """The table in Markdown, measured now."""
    lines = ["| instruction | Nios II/f | this core | |", "| --- | --- | --- | --- |"]
    for row in ROWS:
        vendor = text(row.vendor) if row.vendor else "-"
        lines.append(f"| {row.name} | {vendor} | {text(measure(core, row))} | {row.differs} |")
    return "\n".join(lines)


def page_text(document: str, rtl: N2Rtl, file: Path = DOCUMENT) -> str:
    """The document with the measured table. Raises MarksError if it has lost its marks."""
    return between_marks(document, {"cycles": f"\n{table(rtl)}\n\n"}, file)


@command("python -m sim.rtl.n2_lockstep_cycles")
def main(arguments: Sequence[str] | None = None) -> int:
    prog = "python -m sim.rtl.n2_lockstep_cycles"
    purpose = "Measure the Nios II core's cycle table and write it into docs/nios_core.md."
    parser = script_parser(purpose, f"{prog} --document docs/nios_core.md", prog)
    parser.add_argument("--document", type=Path, default=DOCUMENT)
    options = parser.parse_args(arguments)
    try:
        text = page_text(options.document.read_text(encoding="utf-8"), N2Rtl(), options.document)
        write_text(options.document, text)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
