# SPDX-License-Identifier: Apache-2.0
"""The page of measured latencies says what the core does."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_latency_page__measured_again__equal():
    done = subprocess.run(
        [sys.executable, "scripts/latency_table.py", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
