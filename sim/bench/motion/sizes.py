# SPDX-License-Identifier: Apache-2.0
"""Sizes and clock of the motion front-end that `microtick motion-size` measured, and their limits.

scripts/motion_size.py measures them; this module knows the designs, what they may take, and whether
stored figures are of the present RTL.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sim.report.cache import Entry, fingerprint, load
from sim.rtl.sources import sources_of

ROOT = Path(__file__).resolve().parents[3]
RESULTS = ROOT / "build/motion/sizes.json"
MEASURE = [
    ROOT / name
    for name in ("requirements-synth.lock", "scripts/motion_size.py", "scripts/synth_unit.py")
]
"""What measures them: versions of the tools, and how they are run."""
FRONT_END_MHZ = 100
DESIGNS: dict[str, tuple[str, dict[str, int], bool]] = {
    "pulse_generator": ("pulse_generator", {}, False),
    "velocity_control": ("velocity_control", {"Axes": 1}, False),
    "motion_front_end": ("motion_front_end", {"Interpolators": 0}, True),
    "motion_front_end, interpolators": ("motion_front_end", {"Interpolators": 1}, True),
}
"""Name -> module, parameters, whether its clock is wanted."""
LIMITS: dict[str, tuple[int, int | None]] = {
    "pulse_generator": (100, 110),
    "velocity_control": (400, 400),
    "motion_front_end": (3000, None),
}
"""Most LUTs (ECP5) and registers; none of them may use a multiplier."""
FLOWS: dict[str, tuple[str, dict[str, int], tuple[str, ...], str]] = {
    "ecp5": (
        "synth_ecp5",
        {"LUT4": 1, "CCU2C": 2, "TRELLIS_DPR16X4": 4},
        ("TRELLIS_FF",),
        "MULT18X18D",
    ),
    "xc7": (
        "synth_xilinx -flatten -family xc7",
        {f"LUT{n}": 1 for n in range(1, 7)}
        | {"INV": 1, "SRL16E": 1, "SRLC32E": 1}
        | {"RAM32M": 4, "RAM64M": 4, "RAM32X1D": 2, "RAM64X1D": 2, "RAM128X1D": 4},
        ("FDRE", "FDSE", "FDCE", "FDPE"),
        "DSP48E1",
    ),
}
"""Yosys script, LUTs of its cells, registers, multiplier."""


def entry(results: Path = RESULTS) -> Entry:
    """Where the sizes are cached: for all sources, what is set on them and what measures them."""
    files = [file for top, *_ in DESIGNS.values() for file in sources_of(top)]
    return Entry(results, fingerprint([*files, *MEASURE], DESIGNS, FLOWS))


def within(name: str, found: Mapping[str, Any]) -> bool:
    """Whether a design keeps its limits of size and, where it was timed, of the clock."""
    luts, registers = LIMITS.get(name, (None, None))
    size = found["ecp5"]
    return (
        (luts is None or size["luts"] <= luts)
        and (registers is None or size["registers"] <= registers)
        and size["multipliers"] == 0
        and found.get("mhz_median", FRONT_END_MHZ) >= FRONT_END_MHZ
    )


def current(results: Path = RESULTS) -> dict[str, Any]:
    """What was measured of the present sources. Raises KeyError if nothing was."""
    if (designs := load(entry(results))) is None:
        raise KeyError(f"{results.name} has no sizes of these sources; run microtick motion-size")
    return designs
