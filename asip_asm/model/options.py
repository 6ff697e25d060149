# SPDX-License-Identifier: Apache-2.0
"""What a user may choose of a compiled law, and the compiled law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from asip_asm.model.graph import Graph
from asip_asm.model.law import Law

if TYPE_CHECKING:
    from asip_asm.model.plan import Plan

SINES = ("balanced", "unit", "pipes")


@dataclass(frozen=True)
class Options:
    """What a user may choose. `reassociate`: sums and products in the order of arrival;
    `reciprocal`: quotients of one divisor through its reciprocal; `sine`: 'unit', or 'balanced'
    with polynomials for those sines and cosines that would wait for it, or 'pipes' with polynomials
    for all whose angle has known limits. All change roundings.
    `constants`: at most so many in bank K (None: all that fit). `registers`: the others may be in
    registers that keep them from run to run; the others are loaded from data memory.
    """

    configuration: str = "fast"
    reassociate: bool = False
    reciprocal: bool = False
    sine: str = SINES[0]
    constants: int | None = None
    registers: bool = True


@dataclass(frozen=True)
class Compiled:
    """A compiled law: the graph of core operations, the source text; the plan of a program of loops
    and streams.
    """

    law: Law
    options: Options
    graph: Graph
    text: str
    plan: Plan | None = None


def compiled(plan: Plan, law: Law) -> Compiled:
    """A finished plan as a compiled law."""
    options = Options(configuration=plan.machine.configuration)
    return Compiled(law, options, plan.graph, plan.text(), plan)
