# SPDX-License-Identifier: Apache-2.0
"""What redundancy costs in area: LUTs of the whole core on ECP5, with and without, by Yosys."""

from __future__ import annotations

import hashlib
import json

from asip_asm.project import BUILD
from scripts.motion_size import area
from sim.harness.sources import sources_of

RESULT = BUILD / "upsets/area.json"
CORES = {
    "plain": {"Resilience": 0},
    "resilient": {"Resilience": 1, "Plausible": 0},
    "record": {"Resilience": 1},
}
"""What is measured: redundancy alone, and with the plausibility record."""


def _mark() -> str:
    digest = hashlib.sha256()
    for path in sources_of("asip"):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def measure() -> dict[str, int]:
    """LUTs of each of CORES, kept in build. Raises SynthesisError."""
    found = {name: area("asip", parameters)["luts"] for name, parameters in CORES.items()}
    RESULT.parent.mkdir(parents=True, exist_ok=True)
    RESULT.write_text(json.dumps({"rtl": _mark(), "luts": found}) + "\n")
    return found


def measured() -> dict[str, int] | None:
    """What `measure` has kept, None if that is of other RTL or missing."""
    try:
        kept = json.loads(RESULT.read_text())
    except FileNotFoundError:
        return None
    return kept["luts"] if kept["rtl"] == _mark() else None
