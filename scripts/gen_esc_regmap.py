# SPDX-License-Identifier: Apache-2.0
"""Generate what hardware, C and Python share of the slave controller's registers.

Source: rtl/ethercat/regmap.rdl (SystemRDL). Its registers are at byte addresses and have 8 to 64
bits, for they are what masters know. Outputs: a SystemVerilog package with addresses, fields and
who may write what, a C header, Python records, a page. With --check nothing is written; exit 1 if a
file differs from what would be generated.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from itertools import pairwise

from systemrdl.node import AddrmapNode, RegfileNode, RegNode

from asip_asm.project import ROOT
from scripts.gen_regmap import constructor, formatted
from scripts.generated import run, template
from scripts.regmap_source import compile_map, fields_of, reset_of, text_of
from sim.bus.register import ByteRegister

SCRIPT = "scripts/gen_esc_regmap.py"
SOURCE = "rtl/ethercat/regmap.rdl"
NAME = "esc"
BYTE = 8


def record(node: RegNode, name: str, count: int, stride: int) -> ByteRegister:
    """What the map says of one register."""
    some = next(iter(node.fields()))
    return ByteRegister(
        name=name,
        address=node.raw_absolute_address if count == 1 else node.absolute_address,
        width=node.get_property("regwidth") // BYTE,
        reset=reset_of(node),
        master=some.is_sw_writable,
        application=some.is_hw_writable,
        fields=fields_of(node),
        count=count,
        stride=stride,
        doc=text_of(node),
    )


def registers(top: AddrmapNode) -> list[ByteRegister]:
    """All registers in the order of their addresses; those of an array once."""
    found = []
    for node in top.children(unroll=False):
        if isinstance(node, RegNode):
            found.append(record(node, node.inst_name, 1, 0))
        elif isinstance(node, RegfileNode):
            first = next(n for n in top.children(unroll=True) if n.inst_name == node.inst_name)
            found += [
                record(
                    r, f"{node.inst_name}_{r.inst_name}", node.n_elements, node.array_stride or 0
                )
                for r in first.registers()
            ]
    return found


def ranges(places: Iterable[int]) -> list[tuple[int, int]]:
    """First and last of each run of neighbours."""
    held = sorted(set(places))
    breaks = [i for i, (a, b) in enumerate(pairwise(held), 1) if b != a + 1]
    return [(held[a], held[b - 1]) for a, b in pairwise([0, *breaks, len(held)])] if held else []


def within(value: str, bits: int, first: int, last: int) -> str:
    """Condition that `value` lies in the range."""
    if first == last:
        return f"{value} == {bits}'h{first:x}"
    low = [f"{value} >= {bits}'h{first:x}"] if first else []
    high = [f"{value} <= {bits}'h{last:x}"] if last != (1 << bits) - 1 else []
    return f"({' && '.join(low + high)})"


def writable(found: list[ByteRegister], side: str) -> list[str]:
    """Conditions on `address`, one of which holds where that side may write."""
    single = [
        r.address + i for r in found if r.count == 1 and getattr(r, side) for i in range(r.width)
    ]
    conditions = [within("address", 12, a, b) for a, b in ranges(single)]
    arrays: dict[tuple[int, int, int], list[int]] = {}
    for r in found:
        if r.count > 1 and getattr(r, side):
            key = (r.address // (r.count * r.stride), r.count * r.stride, r.stride)
            arrays.setdefault(key, []).extend(r.address % r.stride + i for i in range(r.width))
    for (index, size, stride), places in arrays.items():
        low, bits = size.bit_length() - 1, stride.bit_length() - 1
        inside = " || ".join(
            within(f"address[{bits - 1}:0]", bits, a, b) for a, b in ranges(places)
        )
        conditions.append(f"(address[11:{low}] == {12 - low}'h{index:x} && ({inside}))")
    return conditions


def generate() -> dict[str, str]:
    """Text of each generated file by its path. Raises RegisterMapError."""
    top = compile_map(ROOT / SOURCE, NAME)
    found = registers(top)
    values = {
        "script": SCRIPT,
        "source": SOURCE,
        "name": NAME,
        "title": top.get_property("name"),
        "note": " ".join(text_of(top).split()),
        "registers": found,
        "assignments": [f"{r.name} = {constructor(r)}" for r in found],
        "master": writable(found, "master"),
        "application": writable(found, "application"),
        "reset_bytes": [
            (r.at(n) + i, value)
            for r in found
            for n in range(r.count)
            for i, value in enumerate((r.reset or 0).to_bytes(r.width, "little"))
            if value
        ],
    }

    def rendered(name: str) -> str:
        return template(name).render(values)

    return {
        "rtl/gen/esc_regmap_pkg.sv": rendered("esc_regmap_pkg.sv.j2"),
        "nios_sw/include/gen/esc_regs.h": rendered("esc_regs.h.j2"),
        "sim/bus/gen/esc_regmap.py": formatted(rendered("esc_regmap.py.j2")),
        "docs/esc_regmap.md": rendered("esc_regmap.md.j2"),
    }


if __name__ == "__main__":
    sys.exit(run(SCRIPT, "Generate what the slave controller's register map gives.", generate))
