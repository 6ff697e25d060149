# SPDX-License-Identifier: Apache-2.0
"""Proofs of the redundancy of the core (docs/upsets.md)."""
