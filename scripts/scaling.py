# SPDX-License-Identifier: Apache-2.0
"""Cycles per tick of the tracking law over the number of axes.

`python scripts/scaling.py` cuts tracking_optimised.s down to what 1 to 5 of its axes need,
schedules each for both configurations, runs one tick on the core and writes
build/scaling/scaling.json and scaling.png. Axes are added in two orders, legs first and table
first, because the legs share their kinematics, statics and masses and the table's axes nothing.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Collection
from dataclasses import asdict, dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from asip_asm.allocate import allocate_registers  # noqa: E402
from asip_asm.assemble import encode, parse_program  # noqa: E402
from asip_asm.image import Image  # noqa: E402
from asip_asm.ir import Operation, Output, Program  # noqa: E402
from asip_asm.isa import default_isa  # noqa: E402
from asip_asm.machine import load_machine, sources  # noqa: E402
from asip_asm.report import report_program  # noqa: E402
from asip_asm.schedule import schedule_program  # noqa: E402
from sim.harness.asip_rtl import AsipRtl  # noqa: E402

SOURCE = ROOT / "asip_asm/programs/tracking_optimised.s"
ORDERS = {"legs first": (1, 2, 3, 4, 5), "table first": (5, 4, 3, 2, 1)}

HOME = {
    "z": 0.6,
    "count1": 3_124_100,
    "count2": 3_124_110,
    "count3": 3_124_090,
    "count4": 9,
    "count5": -5,
}
"""Inputs of the tick [m, counts], others 0: at rest, a few counts from the set-point, so that no
output saturates.
"""


@dataclass(frozen=True)
class Point:
    """One program: axes it controls, operations and bundles, cycles of a tick on the core, and the
    largest lower bound of its schedule.
    """

    order: str
    configuration: str
    axes: tuple[int, ...]
    operations: int
    bundles: int
    cycles: int
    bound: int


def reduced(axes: Collection[int], configuration: str) -> Program:
    """The tracking law without the outputs, exports and states of the other axes, nor anything that
    only they need.
    """
    program = parse_program(SOURCE, configuration=configuration)
    (region,) = program.regions
    program.outputs = [output for output in program.outputs if axis(output.name) in axes]
    program.exports = [export for export in program.exports if axis(export.name) in (None, *axes)]
    outputs = {output.index for output in program.outputs}
    needed: set[object] = {export.value for export in program.exports}
    kept: set[Operation] = set()
    grown = True
    while grown:
        count = len(kept)
        for op in reversed(region.operations):
            is_output = isinstance(op.dst, Output) and op.dst.index in outputs
            if is_output or op.dst in needed:
                kept.add(op)
                needed.update(sources(op))
        needed |= {state.last for state in program.states if state.first in needed}
        grown = len(kept) > count
    region.operations = [op for op in region.operations if op in kept]
    program.states = [state for state in program.states if state.first in needed]
    return program


def axis(name: str) -> int | None:
    """Axis of an output or export, the digit that its name ends in; None without."""
    return int(name[-1]) if name[-1].isdecimal() else None


def measure(order: str, axes: tuple[int, ...], configuration: str) -> Point:
    """Figures of the law for the given axes."""
    program = reduced(axes, configuration)
    machine = load_machine(configuration)
    schedule_program(program, machine)
    allocate_registers(program, machine)
    (section,) = report_program(program, machine).sections
    cycles, _ = run_tick(encode(program, machine, SOURCE))
    return Point(
        order, configuration, axes, section.operations, section.bundles, cycles, section.bound
    )


def float_word(value: float) -> int:
    """Word of a single float."""
    return int(np.float32(value).view(np.uint32))


def run_tick(image: Image) -> tuple[int, dict[str, int]]:
    """CYCLES and output words of a tick on the core with the inputs `HOME`."""
    core = AsipRtl(image.configuration)
    core.load(image)
    names = [entry.name for entry in image.inputs]
    before = {f"{name}_before": float_word(value) for name, value in HOME.items()}
    core.preset({s.name: before[s.name] for s in image.states if s.name in before})
    words = [
        HOME.get(entry.name, 0) & 0xFFFFFFFF
        if entry.type == "int"
        else float_word(HOME.get(entry.name, 0))
        for entry in image.inputs
    ]
    outputs = [output.name for output in image.outputs]
    result = core.run(
        core.input_addresses(names),
        np.array([words], dtype=np.uint32),
        core.output_addresses(outputs),
    )
    if result.fault != "NONE":
        raise SystemExit(f"scaling: a tick ended in {result.fault}")
    return int(result.cycles[0]), dict(zip(outputs, result.words[0].tolist(), strict=True))


def plot(points: list[Point], path: Path) -> None:
    """Cycles over the number of axes."""
    figure, plane = plt.subplots(figsize=(6.5, 4.2), layout="constrained")
    for configuration in default_isa().configurations:
        for order, marker in zip(ORDERS, "os", strict=True):
            line = [p for p in points if (p.order, p.configuration) == (order, configuration)]
            axes = [len(point.axes) for point in line]
            (drawn,) = plane.plot(
                axes, [p.cycles for p in line], marker=marker, label=f"{configuration}, {order}"
            )
            plane.plot(axes, [p.bound for p in line], ":", color=drawn.get_color(), linewidth=1)
    plane.plot([], [], ":", color="grey", label="largest lower bound")
    plane.set(xlabel="axes", ylabel="cycles per tick", xticks=range(1, 6), ylim=(0, None))
    plane.set_title("Tracking law, optimised: cycles per tick over axes")
    plane.grid(alpha=0.3)
    plane.legend()
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main() -> None:
    """Write table, JSON and plot."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--output", type=Path, default=ROOT / "build/scaling", help="folder")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    points = [
        measure(order, axes[:count], configuration)
        for configuration in default_isa().configurations
        for order, axes in ORDERS.items()
        for count in range(1, len(axes) + 1)
    ]
    (folder / "scaling.json").write_text(json.dumps([asdict(p) for p in points], indent=1) + "\n")
    plot(points, folder / "scaling.png")
    print(f"{'':26}axes  operations  cycles  bound")
    for p in points:
        name = f"{p.configuration}, {p.order}: {' '.join(map(str, p.axes))}"
        print(f"{name:<30}{p.operations:>12}{p.cycles:>8}{p.bound:>7}")


if __name__ == "__main__":
    main()
