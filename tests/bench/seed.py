# SPDX-License-Identifier: Apache-2.0
"""Seed of the random cases: SEED of the environment, 1 without it."""

import os

SEED = int(os.environ.get("SEED", "1"))
