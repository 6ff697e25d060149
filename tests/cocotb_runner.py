# SPDX-License-Identifier: Apache-2.0
"""cocotb's runner with the Verilator of the environment, also where the project's path has spaces.

Files given to it go through `sim.harness.plain.plain`.
"""

from __future__ import annotations

import os
from pathlib import Path

import cocotb_tools.config
from cocotb_tools.runner import Runner, get_runner

from sim.harness.build import verilator_driver
from sim.harness.plain import plain


def verilator_runner() -> Runner:
    """A runner for one build. Puts Verilator first on PATH."""
    os.environ["PATH"] = os.pathsep.join((str(verilator_driver().parent), os.environ["PATH"]))
    for name in ("share_dir", "libs_dir"):  # go into makefiles
        setattr(cocotb_tools.config, name, plain(Path(getattr(cocotb_tools.config, name))))
    return get_runner("verilator")
