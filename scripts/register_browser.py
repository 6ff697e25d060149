# SPDX-License-Identifier: Apache-2.0
"""Pages to browse the register maps, by PeakRDL-html: build/site/register_browser/index.html."""

from __future__ import annotations

from peakrdl_html import HTMLExporter

from asip_asm.project import ROOT
from scripts.gen_regmap import MAPS
from scripts.regmap_source import compile_map

OUTPUT = ROOT / "build/site/register_browser"


def main() -> None:
    """Write the pages of all maps."""
    maps = [compile_map(ROOT / source, name) for name, (source, *_) in MAPS.items()]
    HTMLExporter().export(maps, str(OUTPUT), title="Register maps of Microtick")
    print(f"registers: {(OUTPUT / 'index.html').relative_to(ROOT)}")


if __name__ == "__main__":
    main()
