# SPDX-License-Identifier: Apache-2.0
"""Commands of sim.bus that run a master and Verilated slaves, and what they report."""

from __future__ import annotations

import json

from sim.bus.line import library
from sim.bus.tap import in_namespace


def report_of(module: str, *options: object, timeout: float = 600, status: int = 0) -> dict:
    """The JSON in the one line of it that `python -m sim.bus.MODULE` prints.

    KickCAT prints lines of its own, usually before it. Raises AssertionError for another exit
    status.
    """
    library()  # built here: the master's clock runs in the other process
    done = in_namespace(f"sim.bus.{module}", [*map(str, options)], timeout=timeout)
    assert done.returncode == status, done.stdout + done.stderr
    reports = [line for line in done.stdout.splitlines() if line.startswith("{")]
    assert len(reports) == 1, done.stdout + done.stderr
    return json.loads(reports[0])
