# SPDX-License-Identifier: Apache-2.0
"""Proofs of the arithmetic units: `python -m tests.formal --help`, docs/formal.md."""
