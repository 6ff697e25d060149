# SPDX-License-Identifier: Apache-2.0
"""Every proof, in the order of the table in docs/formal.md."""

from tests.formal import (
    blocks,
    folded,
    products,
    recurrence,
    sums,
    trigonometry,
    trigonometry_overlapped,
)
from tests.formal.catalogue import PROOFS
from tests.formal_debug import halting, nios
from tests.formal_ethercat import frames
from tests.formal_motion import arcs, drive, lines, planes
from tests.formal_servo import encoder, gates
from tests.formal_upsets import bounded

__all__ = [
    "PROOFS",
    "arcs",
    "blocks",
    "bounded",
    "drive",
    "encoder",
    "folded",
    "frames",
    "gates",
    "halting",
    "lines",
    "nios",
    "planes",
    "products",
    "recurrence",
    "sums",
    "trigonometry",
    "trigonometry_overlapped",
]
