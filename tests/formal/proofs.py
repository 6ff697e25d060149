# SPDX-License-Identifier: Apache-2.0
"""Every proof, in the order of the table in docs/formal.md: modules list theirs when imported."""

from tests.formal import (  # noqa: F401
    blocks,
    folded,
    products,
    recurrence,
    sums,
    trigonometry,
    trigonometry_overlapped,
)
from tests.formal.catalogue import PROOFS
from tests.formal_debug import halting, nios  # noqa: F401
from tests.formal_ethercat import frames  # noqa: F401
from tests.formal_motion import arcs, drive, lines, planes  # noqa: F401
from tests.formal_nios import stores  # noqa: F401
from tests.formal_servo import encoder, gates  # noqa: F401
from tests.formal_upsets import bounded  # noqa: F401

__all__ = ["PROOFS"]
