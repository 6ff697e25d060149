# SPDX-License-Identifier: Apache-2.0
"""Pages to browse the register maps, by PeakRDL-html: build/site/register_browser/index.html."""

from __future__ import annotations

import sys
from pathlib import Path

from peakrdl_html import HTMLExporter

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from scripts.gen_regmap import MAPS  # noqa: E402
from scripts.regmap_source import compile_map  # noqa: E402

OUTPUT = ROOT / "build/site/register_browser"


def main() -> None:
    """Write the pages of all maps."""
    maps = [compile_map(ROOT / source, name) for name, (source, *_) in MAPS.items()]
    HTMLExporter().export(maps, str(OUTPUT), title="Register maps of Microtick")
    print(f"registers: {(OUTPUT / 'index.html').relative_to(ROOT)}")


if __name__ == "__main__":
    main()
