# SPDX-License-Identifier: Apache-2.0
"""Models of one library are freed in any order, also after the one that was made last."""

from __future__ import annotations

import os
import subprocess
import sys

from sim.rtl.nios_rtl import NiosRtl

PROGRAM = """
import ctypes, sys
library = ctypes.CDLL(sys.argv[1])
library.nios_new.restype = ctypes.c_void_p
first, last = library.nios_new(), library.nios_new()
for model in (last, first):
    library.nios_free(ctypes.c_void_p(model))
"""


def test_free__of_the_last_model_before_the_first__uses_no_freed_memory() -> None:
    """A mutex in freed memory, which the C library fills here, would never be free."""
    model = NiosRtl("fpga2")
    command = [sys.executable, "-c", PROGRAM, model._lib._name]
    subprocess.run(command, env=os.environ | {"MALLOC_PERTURB_": "165"}, check=True, timeout=60)
