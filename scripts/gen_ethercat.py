# SPDX-License-Identifier: Apache-2.0
"""Generate what describes the device on the bus from its object dictionary.

Source: nios_sw/ethercat/dictionary.toml. Outputs: C tables, ESI file and SII image in
nios_sw/ethercat/gen, docs/ethercat_dictionary.md. With --check nothing is written; exit 1 if a file
would differ.
"""

from __future__ import annotations

import sys

from scripts.generated import run
from sim.bus.coe import c_tables, esi, page, sii
from sim.bus.coe.dictionary import load

GEN = "nios_sw/ethercat/gen"


def memory(image: bytes) -> str:
    """Bytes for $readmemh, 16 to a line."""
    rows = [image[at : at + 16].hex(" ") for at in range(0, len(image), 16)]
    return f"// {c_tables.ORIGIN}\n" + "\n".join(rows) + "\n"


def generate() -> dict[str, str]:
    """Text of each generated file by its path. Raises DictionaryError."""
    device = load()
    return {
        f"{GEN}/objects.h": c_tables.header(device),
        f"{GEN}/objects.c": c_tables.source(device),
        f"{GEN}/sii.c": c_tables.image(sii.image(device)),
        f"{GEN}/microtick.xml": esi.document(device),
        f"{GEN}/sii.hex": memory(sii.image(device)),
        "docs/ethercat_dictionary.md": page.page(device),
    }


if __name__ == "__main__":
    sys.exit(run("scripts/gen_ethercat.py", __doc__.splitlines()[0], generate))
