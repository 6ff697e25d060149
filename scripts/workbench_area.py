# SPDX-License-Identifier: Apache-2.0
"""Goals of the workbench from synthesis and proofs: cost of the debug block, what is proved."""

from __future__ import annotations

from collections.abc import Iterator

from scripts.synth_unit import OUTPUT, alm_area, cells_of, ecp5_speed, read_commands
from sim.report.goals import Goal, at_most, exactly
from sim.rtl.sources import sources_of

CONFIGURATIONS = {
    "small": {"FmaPipes": 1, "Slots": 1},
    "fast": {"FmaPipes": 2, "Slots": 3},
}
SEEDS = (1, 2, 3, 4, 5)
ALUTS, BLOCKS = 1500, 8
TIMED = "small"  # the configuration whose clock is measured
SLACK = 0.97  # of the core's own median clock: less is within what seeds differ by
PROOFS = (
    *("marked_bundle", "held_core", "staged_page", "bus_of_a_commit", "idle_core"),
    "halted_nios",
)


def _area(name: str, top: str, parameters: dict[str, int]) -> dict[str, int]:
    folder = OUTPUT / f"workbench_{name}"
    folder.mkdir(parents=True, exist_ok=True)
    return alm_area(top, read_commands(top, sources_of(top), parameters), folder)


def _ram(parameters: dict[str, int]) -> int:
    """Block RAMs of an ECP5 that the block takes, the core a black box next to it."""
    folder = OUTPUT / "workbench_ram"
    folder.mkdir(parents=True, exist_ok=True)
    top = "debug_asip"
    read = read_commands(top, sources_of(top), parameters | {"Uart": 0}) + "; blackbox asip"
    return cells_of(f"{read}; synth_ecp5 -top {top}", folder / "cells").get("DP16KD", 0)


def rows(full: bool) -> Iterator[Goal]:
    """ALUTs and block RAM of the block next to the core; with `full`, `fast` and the clock too.

    The goal counts what it lists: breakpoints, channels, ring. The serial port is in the note.
    Block RAMs are those of the ECP5, where the clock is measured: 16 kbit each, so that the ring of
    131 072 bits is 8. Of the M10K of a Cyclone V, 10 kbit each, no layout takes fewer than 13; what
    Yosys takes is in the note.
    """
    for name, parameters in CONFIGURATIONS.items():
        if name != "small" and not full:
            continue
        core = _area(f"{name}_core", "asip", parameters)
        more = []
        for uart in (0, 1):
            block = _area(f"{name}_uart{uart}", "debug_asip", parameters | {"Uart": uart})
            more.append({what: block[what] - core[what] for what in core})
        block, serial = more[0], more[1]["alut"] - more[0]["alut"]
        note = f"{block['ff']} registers, {block['mlab']} MLAB cells; serial port {serial} ALUTs"
        yield at_most(f"{name}: debug block", block["alut"], ALUTS, "ALUTs", note)
        note = f"16 kbit each; of a Cyclone V's 10 kbit {block['m10k']}"
        yield at_most(f"{name}: block RAMs", _ram(parameters), BLOCKS, "DP16KD", note)
    if full:
        clock = {}
        # The core alone, as `microtick synth` places it; a placed result is used again.
        for top, name in (("asip", f"asip_{TIMED}"), ("debug_asip", f"workbench_{TIMED}_clock")):
            folder = OUTPUT / name
            folder.mkdir(parents=True, exist_ok=True)
            commands = read_commands(top, sources_of(top), CONFIGURATIONS[TIMED])
            clock[top] = ecp5_speed(top, commands, folder, SEEDS)["fmax_median_mhz"]
        ratio = clock["debug_asip"] / clock["asip"]
        note = f"{clock['debug_asip']:.1f} of {clock['asip']:.1f} MHz, median of {len(SEEDS)} seeds"
        yield Goal(f"{TIMED}: clock with the block", ratio, "", f">= {SLACK}", ratio >= SLACK, note)


def proofs(full: bool) -> Iterator[Goal]:
    """Cases proved of what a halted core and a staged page are to keep."""
    from tests.formal.catalogue import PROOFS as KNOWN
    from tests.formal.engine import PROVED, run
    from tests.formal.proofs import PROOFS as _  # noqa: F401, fills the table

    for proof in KNOWN:
        if proof.name in PROOFS:
            verdicts = list(run(proof))
            missed = sum(verdict.status != PROVED for verdict in verdicts)
            yield exactly(f"{proof.name}: cases not proved", missed, 0, "", f"of {len(verdicts)}")
