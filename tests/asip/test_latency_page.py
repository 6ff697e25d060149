# SPDX-License-Identifier: Apache-2.0
"""The page of measured latencies says what the core does."""

import sys
from pathlib import Path

from tests.bench.commands import output

ROOT = Path(__file__).parents[2]


def test_latency_page__measured_again__equal():
    output(sys.executable, "scripts/latency_table.py", "--check", cwd=ROOT)
