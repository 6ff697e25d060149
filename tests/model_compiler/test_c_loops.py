# SPDX-License-Identifier: Apache-2.0
"""C of programs of loops and streams: its bits on this machine are those of the interpreter."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from asip_asm.model import c_loops
from asip_asm.model.c_code import to_c_code
from asip_asm.model.compiler import Compiled, Options, compile_law
from asip_asm.model.law import load_law
from asip_asm.model.mpc_problem import load_problem
from sim.laws import mpc
from sim.laws.native.bits import prove_c
from tests.model_compiler.onnx_models import perceptron
from tests.model_compiler.test_mpc import cart
from tests.model_compiler.test_networks import written

TICKS = 60
CONFIGURATIONS = ("stream", "wide")


def control(folder: Path, configuration: str, reference: str = "trajectory") -> Compiled:
    problem = load_problem(cart(folder, ('"trajectory"', f'"{reference}"')))
    return mpc.build_mpc(problem, folder / "cart.s", configuration)[0].compiled


def network(folder: Path, configuration: str, activation: str) -> Compiled:
    made = perceptron((7, 33, 5, 2), activation, seed=2)
    law = load_law(*written(folder, made, 7, 2), whole=False)
    return compile_law(law, Options(configuration=configuration))


@pytest.mark.quick("wide-trajectory")
@pytest.mark.parametrize("reference", ["none", "point", "trajectory"])
@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_predictive_control_has_the_bits_of_the_program(configuration, reference, tmp_path):
    assert prove_c(control(tmp_path, configuration, reference), TICKS, seed=2) == ""


@pytest.mark.quick("stream-Elu", "wide-Tanh")
@pytest.mark.parametrize("activation", ["Relu", "Elu", "Tanh", "Softsign", "Gelu"])
@pytest.mark.parametrize("configuration", CONFIGURATIONS)
def test_network_has_the_bits_of_the_program(configuration, activation, tmp_path):
    assert prove_c(network(tmp_path, configuration, activation), TICKS, seed=2) == ""


@pytest.mark.quick("vfmadd")
@pytest.mark.parametrize("operation", ["vfmadd", "vfmul", "vmadd", "vabove", "vscale", "vbelow"])
def test_lane_that_differs_is_found(operation, tmp_path, monkeypatch):
    monkeypatch.setitem(c_loops.LANE, operation, f"1.001f * ({c_loops.LANE[operation]})")
    assert "tick 0: got" in prove_c(network(tmp_path, "wide", "Elu"), TICKS, seed=2)


def test_memory_that_is_not_kept_is_found(tmp_path, monkeypatch):
    monkeypatch.setattr(
        "asip_asm.model.c_code._Looped._states", lambda self: ["  state->slot[1] = next.slot[1];"]
    )
    assert ", tick " in prove_c(control(tmp_path, "wide"), TICKS, seed=2)


def test_infinite_output__leaves_the_memory_as_it_was(tmp_path):
    _, source = to_c_code(control(tmp_path, "wide"), "cart.tick.h")
    fault, kept = source.index("return 1;"), source.index("*state = next;")
    assert fault < kept and source.count("state->") == 0


def test_loops_are_loops(tmp_path):
    """Ten times the iterations change no line of the C but numbers of rounds."""
    longer = ("iterations = 8", "iterations = 80")
    few = to_c_code(control(tmp_path, "wide"), "cart.tick.h")[1]
    problem = load_problem(cart(tmp_path, longer))
    built, _ = mpc.build_mpc(problem, tmp_path / "cart.s", "wide")
    many = to_c_code(built.compiled, "cart.tick.h")[1]
    assert len(few.splitlines()) == len(many.splitlines())


def test_command_writes_and_proves_the_c(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(mpc, "TIMED", 200)
    stem = tmp_path / "out" / "cart"
    given = [str(cart(tmp_path)), "--c", "--prove", "--ticks", "20", "--states", "10"]
    assert mpc.main([*given, "-o", str(stem)]) == 0
    out = capsys.readouterr().out
    assert "C on this machine: bits equal the interpreter's\ntime of the C, 200 ticks" in out
    pattern = (
        r"median ([\d.]+) us, 99.99 % ([\d.]+) us, worst ([\d.]+) us; .*: ([\d.]+) us in every"
    )
    median, far, worst, core = map(float, re.findall(pattern, out)[0])
    assert 0 < median <= far <= worst and out.endswith("proved\n")
    assert abs(core - json.loads(Path(f"{stem}.asip.json").read_text())["cycles"] / 125) < 0.01
    assert '#include "cart.tick.h"' in Path(f"{stem}.tick.c").read_text(encoding="utf-8")
    assert "float slot[" in Path(f"{stem}.tick.h").read_text(encoding="utf-8")
    monkeypatch.setattr("sim.laws.native.bits.prove_c", lambda *given: "force, tick 0: got 1")
    assert mpc.main([*given, "-o", str(stem)]) == 1
    out = capsys.readouterr().out
    assert "C on this machine: force, tick 0: got 1\n" in out and out.endswith("NOT proved\n")
