# SPDX-License-Identifier: Apache-2.0
"""Models of one library are freed in any order, also after the one that was made last."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from sim.rtl.nios_rtl import NiosRtl
from sim.rtl.verilated import Verilated

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


def test_arguments_without_types__are_refused() -> None:
    """ctypes cuts an address without a type to 32 bits, which some builds of Python survive."""

    class Untyped(Verilated):
        prefix = "nios"

    with pytest.raises(TypeError, match="nios_new: 1 arguments, but .* has 0 types"):
        Untyped(NiosRtl("fpga2")._lib, {}, 1)
