# SPDX-License-Identifier: Apache-2.0
"""How hard the compiler tries with a model is one of four words, and another stops the build; what
runs once is compiled plainly by GCC, with a header that is compiled once for all models.
"""

import ctypes
import subprocess
import sys

import pytest

from asip_asm.project import ROOT
from sim.rtl import build, runtime
from sim.rtl.sources import sources_of

HARNESS = """\
#include "bench.h"
#include "Vfp_cmp.h"
extern "C" int width() { Vfp_cmp unit; unit.eval(); return sizeof unit.a_i; }
"""


def test_optimisation__unknown__is_refused_with_the_known_ones(monkeypatch) -> None:
    monkeypatch.setattr(build, "optimisation", "-Ofast")
    with pytest.raises(build.BuildError, match="MODEL_OPTIMISATION=-Ofast.*-O0, -O1, -O2, -O3"):
        build.build_library("asip", [], build.BASE)


def test_default__is_the_strongest() -> None:
    """Tests build at -O1, a user at this one."""
    program = "from sim.rtl import build; print(build.optimisation)"
    command = [sys.executable, "-c", program]
    assert subprocess.check_output(command, cwd=ROOT, env={}, text=True) == "-O3\n"


@pytest.mark.full
@pytest.mark.parametrize("gcc", [True, False])
def test_model__is_built_by_gcc_and_by_others(gcc, monkeypatch, tmp_path) -> None:
    """By GCC as users build it: at -O3, the sources that run once at -O0, the header compiled."""
    commands, run = [], runtime.run

    def noted(words, folder) -> None:
        commands.append(list(map(str, words)))
        refuse = ["-Winvalid-pch", "-Werror=invalid-pch"] if gcc and "-c" in words else []
        run([words[0], *refuse, *words[1:]], folder)

    monkeypatch.setattr(runtime, "run", noted)
    monkeypatch.setattr(runtime, "is_gcc", lambda: gcc)
    monkeypatch.setattr(build, "optimisation", "-O3" if gcc else "-O1")
    harness = tmp_path / "harness.cpp"  # its path is no part of the model's name, its text is
    harness.write_text(f"// {tmp_path}\n{HARNESS}")
    include = ("-I", str(build.BASE.parent))
    file = build.build_library("fp_cmp", sources_of("fp_cmp"), harness, harness_flags=include)
    assert ctypes.CDLL(str(file)).width() == 4
    text = (file.parent / "model.cpp").read_text()
    quick, _, slow = text.partition('#pragma GCC optimize("O0")\n')
    assert (build.SLOW in slow and build.SLOW not in quick) if gcc else not slow
    objects = [words for words in commands if words[-1] in ("model.o", "harness.o")]
    assert len(objects) == 2
    for words in objects:
        header = words[words.index("-include") + 1] if "-include" in words else ""
        assert bool(header) is gcc
