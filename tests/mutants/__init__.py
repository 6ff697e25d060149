# SPDX-License-Identifier: Apache-2.0
"""Planted faults: `microtick mutants` shows that the short set of the fast bench finds each."""
