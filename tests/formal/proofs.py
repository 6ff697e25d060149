# SPDX-License-Identifier: Apache-2.0
"""Every proof, in the order of the table in docs/formal.md."""

from tests.formal import blocks, products, recurrence, sums, trigonometry
from tests.formal.catalogue import PROOFS

__all__ = ["PROOFS", "blocks", "products", "recurrence", "sums", "trigonometry"]
