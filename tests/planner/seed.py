# SPDX-License-Identifier: Apache-2.0
"""Seed of the random moves in the planner's tests."""

import os

SEED = int(os.environ.get("SEED", "1"))
