# SPDX-License-Identifier: Apache-2.0
"""The planted faults of the arithmetic units, and copies that hold them, each under a macro."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from sim.core.fpbench.native import operations, sources, unit_of
from sim.core.fpbench.variants import VARIANTS
from sim.rtl.build import ROOT
from tests.bench import faults as table
from tests.bench.faults import BY_MACRO, TableError, write_if_changed

TABLE = Path(__file__).with_name("mutants.toml")
BUILD = ROOT / "build/mutants"
COPY = BUILD / "rtl"


class Fault(table.Fault):
    """A fault that the short set of one of the operations in `found` must find."""

    @property
    def ops(self) -> tuple[str, ...]:
        """Operations of the bench, tried in this order."""
        return self.found

    @property
    def unit(self) -> str:
        """Unit of the bench through which the fault is looked for."""
        stem = self.name.removesuffix(".sv")
        return stem if stem in VARIANTS else unit_of(self.ops[0])


def load(path: Path = TABLE) -> list[Fault]:
    """The faults in the order of the table. Raises TableError for the first wrong entry."""
    faults = table.load(path, Fault)
    for fault in faults:
        if unknown := set(fault.ops) - set(operations()):
            raise fault.error(
                f"found: {', '.join(sorted(unknown))}; name operations of the bench: "
                f"{', '.join(operations())}"
            )
        units = {unit_of(op) for op in fault.ops}
        if len(units) > 1:
            raise fault.error(f"found: operations of several units: {', '.join(sorted(units))}")
        if fault.name not in [path.name for path in sources(fault.unit)]:
            raise fault.error(
                f"{fault.name} is no part of {fault.unit}, which executes {fault.ops[0]}; name an "
                "operation that uses it"
            )
    return faults


def write_copy(faults: Sequence[Fault], folder: Path = COPY) -> Path:
    """rtl/fpu with all faults in `folder`; files that stay equal keep their time."""
    return table.copy(folder, faults, BY_MACRO, "fpu")


def write_lanes(unit: str, faults: Sequence[Fault], top: Sequence[Path]) -> list[Path]:
    """Sources above a unit for one lane without fault (lane 0) and one lane per fault.

    The modules of a faulty lane are the copies compiled with the macro of the fault, under names
    of their own. `top`: fp_lane.sv and fpbench.sv of the fast bench. Returns what replaces them.
    """
    lane, bench = (path.read_text() for path in top)
    modules = [path for path in sources(unit, COPY) if path.stem != "fp_pkg"]
    names = "|".join([*(path.stem for path in modules), top[0].stem])
    text = "\n".join([*(path.read_text() for path in modules), lane])
    variants = [
        f"`define {fault.macro}\n"
        + re.sub(rf"\b({names})\b", rf"\1__{fault.number:02d}", text)
        + f"\n`undef {fault.macro}\n"
        for fault in faults
    ]
    instance = re.search(r"\bfp_lane lane (\(.*?\);)", bench, re.DOTALL)
    if instance is None:
        raise TableError(f"{top[1]}: no instance `fp_lane lane (...)` to vary from lane to lane")
    chain = "".join(
        f"if (i == {k}) begin : gen_{fault.number:02d}\n"
        f"    fp_lane__{fault.number:02d} lane {instance[1]}\n    end else "
        for k, fault in enumerate(faults, 1)
    )
    chain += f"begin : gen_good\n    {instance[0]}\n    end"
    folder = BUILD / "lanes" / unit
    folder.mkdir(parents=True, exist_ok=True)
    write_if_changed(folder / "variants.sv", "".join(variants))
    changed = bench[: instance.start()] + chain + bench[instance.end() :]
    write_if_changed(folder / "fpbench.sv", changed)
    return [top[0], folder / "variants.sv", folder / "fpbench.sv"]
