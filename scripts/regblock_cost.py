# SPDX-License-Identifier: Apache-2.0
"""What register blocks by PeakRDL-regblock would cost beside our decoders: docs/registers.md.

Makes the block of a map with an Avalon-MM agent and synthesises it and the module with our decoder
for Cyclone V, as scripts/synth_unit.py does. Writes the table of docs/registers.md.
"""

from __future__ import annotations

import sys

from peakrdl_regblock import RegblockExporter
from peakrdl_regblock.cpuif.avalon import Avalon_Cpuif_flattened
from peakrdl_regblock.udps import ALL_UDPS

from asip_asm.command import command, script_parser
from asip_asm.files import write_text
from asip_asm.project import ROOT
from scripts.gen_regmap import MAPS
from scripts.generated import table
from scripts.regmap_source import compile_map
from scripts.synth_unit import OUTPUT, SynthesisError, alm_area, read_commands
from sim.report.marks import write_between_marks
from sim.rtl.sources import sources_of

PAGE = ROOT / "docs/registers.md"
# Maps whose decoder is a module of its own.
OURS = {"asip": "asip_host", "dual": "dual_host"}


def areas(name: str) -> tuple[dict[str, int], dict[str, int]]:
    """Cells of our module and of PeakRDL's block. Raises SynthesisError."""
    folder = OUTPUT / f"regblock_{name}"
    folder.mkdir(parents=True, exist_ok=True)
    block = f"{name}_regblock"
    RegblockExporter().export(
        compile_map(ROOT / MAPS[name][0], name, ALL_UDPS),
        str(folder),
        cpuif_cls=Avalon_Cpuif_flattened,
        module_name=block,
    )
    files = [folder / f"{block}{part}.sv" for part in ("_pkg", "")]
    for file in files:  # Yosys reads packed structs only
        text = file.read_text(encoding="utf-8").replace("struct {", "struct packed {")
        write_text(file, text)
    ours = alm_area(OURS[name], read_commands(OURS[name], sources_of(OURS[name]), {}), folder)
    return ours, alm_area(block, read_commands(block, files, {}), folder)


@command("scripts/regblock_cost.py")
def main() -> int:
    """Measure and write the table; returns the exit status."""
    script_parser(__doc__, "python scripts/regblock_cost.py").parse_args()
    rows = []
    for name in OURS:
        try:
            ours, theirs = areas(name)
        except SynthesisError as error:
            print(error, file=sys.stderr)
            return 1
        share = f"{theirs['alut'] / ours['alut']:.0%}"
        cells = [f"{a['alut']} / {a['ff']}" for a in (ours, theirs)]
        rows.append([f"`{name}`", f"`{OURS[name]}`", *cells, share])
        print(*rows[-1])
    head = ["map", "our module", "ALUT / FF", "PeakRDL-regblock, ALUT / FF", "ALUT of ours"]
    write_between_marks(PAGE, {"regblock": "\n".join(table(head, rows)) + "\n"})
    return 0


if __name__ == "__main__":
    sys.exit(main())
