# SPDX-License-Identifier: Apache-2.0
"""One law side by side: cycles of the core and of FPGA2 in RTL, times of its C on this machine.

Every platform gets the form of the law that is fastest on it (`FORMS`), and the same inputs. Bits
are compared with the exact interpreter of that form.
"""

from __future__ import annotations

import os
import platform
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from asip_asm.isa import default_isa
from asip_asm.model.compiler import Compiled, Options, compile_law
from asip_asm.model.exact import Array
from asip_asm.model.law import Law
from asip_asm.model.program import build
from sim.bench.platforms.nios import build_elf, run_elf
from sim.bench.run.tables import synthesised
from sim.core.api import Core
from sim.laws.native.bits import first_difference, prove_c, separate
from sim.laws.native.law import NativeLaw, Times
from sim.laws.prove_program import Sample, draw_ticks, prove, unit_sine
from sim.rtl.nios_image import read_elf
from sim.rtl.nios_map import default_system_map

FORMS = {
    "as written": Options(sine="unit"),
    "reassociated": Options(reassociate=True, reciprocal=True, sine="unit"),
    "reassociated, sines balanced": Options(reassociate=True, reciprocal=True),
}
NIOS_ROWS = 100
ROWS = 4096  # different inputs, in turn
PROVED = 2000  # inputs
SHARES = {"median": 50.0, "p9999": 99.99, "worst": 100.0}
TOPS = {"core": "asip_fast", "fpga2": "fpga2"}


@dataclass(frozen=True)
class Request:
    """What is measured: a law, its inputs, runs on the PC, seed of the inputs, folder of what is
    built."""

    law: Law
    sample: Sample
    runs: int
    seed: int
    folder: Path

    def drawn(self, rows: int) -> tuple[dict[str, Array], dict[str, Array]]:
        """Inputs and states of consecutive ticks."""
        return draw_ticks(self.law, rows, np.random.default_rng(self.seed), self.sample)


def side_by_side(request: Request, say: Callable[[str], None]) -> dict[str, Any]:
    """Everything that was measured, for JSON. `say` hears what comes next.

    Raises CompilerError (no cross compiler), CoreFault, NiosError.
    """
    forms = {}
    for name, options in FORMS.items():
        say(f"compiling {request.law.title}, {name}")
        forms[name] = compile_law(request.law, options)
    return {
        "law": request.law.title,
        "seed": request.seed,
        "core": on_core(request, forms, say),
        "fpga2": on_fpga2(request, forms, say),
        "pc": on_pc(request, forms, say),
        "area": synthesised(),
    }


def on_core(
    request: Request, forms: dict[str, Compiled], say: Callable[[str], None]
) -> dict[str, Any]:
    """Cycles of the core, the same in each tick, and whether its bits are the interpreter's."""
    built = {
        name: build(compiled, request.folder / f"side_{k}.s")
        for k, (name, compiled) in enumerate(forms.items())
    }
    best = min(built, key=lambda name: built[name].cycles)
    say(f"core, {best}: {PROVED} ticks in RTL")
    inputs, states = request.drawn(PROVED)
    with Core(built[best].image) as core:
        core.preset({name: value[0].item() for name, value in states.items()})
        cycles = core.batch(inputs).cycles
    compiled, image, seed = built[best].compiled, built[best].image, request.seed
    proof = prove(compiled, image, count=PROVED, seed=seed, sample=request.sample)
    clock = default_isa().clock_mhz
    assert cycles is not None  # the RTL counts
    return _cycles(cycles, clock, best, proof.first_difference)


def on_fpga2(
    request: Request, forms: dict[str, Compiled], say: Callable[[str], None]
) -> dict[str, Any]:
    """Cycles of a call of the law's C on FPGA2."""
    found = {}
    inputs, states = request.drawn(NIOS_ROWS)
    for name, compiled in forms.items():
        say(f"FPGA2, {name}: {NIOS_ROWS} ticks in RTL")
        folder = request.folder / "side_fpga2" / name.replace(" ", "_").replace(",", "")
        elf = build_elf(compiled, folder, NIOS_ROWS)
        ran = run_elf(read_elf(elf), compiled, inputs, states)
        difference = first_difference(separate(compiled), ran, inputs, states, unit_sine)
        clock = default_system_map().clock_mhz
        found[name] = _cycles(ran.cycles, clock, name, difference)
    return min(found.values(), key=lambda row: row["cycles_max"])


def _cycles(cycles: Array, clock_mhz: float, form: str, difference: str) -> dict[str, Any]:
    return {
        "form": form,
        "clock_mhz": clock_mhz,
        "ticks": len(cycles),
        "cycles_min": int(cycles.min()),
        "cycles_max": int(cycles.max()),
        "worst_us": float(cycles.max() / clock_mhz),
        "bits_equal": not difference,
        "first_difference": difference,
    }


def on_pc(
    request: Request, forms: dict[str, Compiled], say: Callable[[str], None]
) -> dict[str, Any]:
    """Times of the law's C on this machine, on one processor and on any."""
    inputs, _ = request.drawn(ROWS)
    cpu = max(os.sched_getaffinity(0))
    laws = {name: NativeLaw(compiled) for name, compiled in forms.items()}
    trial = {name: np.median(law.time(inputs, ROWS, cpu).ticks) for name, law in laws.items()}
    best = min(trial, key=lambda name: trial[name])
    say(f"PC, {best}: {request.runs} ticks, pinned and not")
    difference = prove_c(forms[best], PROVED, request.seed)
    return {
        "form": best,
        "machine": machine(),
        "runs": request.runs,
        "pinned": _times(laws[best].time(inputs, request.runs, cpu)),
        "unpinned": _times(laws[best].time(inputs, request.runs)),
        "bits_equal": not difference,
        "first_difference": difference,
    }


def _times(times: Times) -> dict[str, float]:
    """Microseconds, without what reading the clock takes (its median)."""
    found = {
        f"{name}_us": float(np.percentile(times.ticks, share) - times.clock) / 1e3
        for name, share in SHARES.items()
    }
    return found | {"clock_us": times.clock / 1e3}


def machine() -> dict[str, Any]:
    """Processor, number of processors, programs that want to run, system, compiler."""
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    flags = next((line for line in lines if line.startswith("flags")), "")
    version = subprocess.run(
        [os.environ.get("CC", "cc"), "--version"], capture_output=True, text=True, check=False
    )
    return {
        "processor": names[0] if names else platform.machine(),
        "processors": os.cpu_count(),
        "load": round(os.getloadavg()[0], 1),
        "virtual": "hypervisor" in flags.split(),
        "system": f"{platform.system()} {platform.release().split('-')[0]}",
        "compiler": version.stdout.split("\n")[0],
    }
