# SPDX-License-Identifier: Apache-2.0
"""Parameters of the motion front-end: what they make of one another, which are refused."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from sim.rtl.build import ROOT, WAIVERS, file_list, verilator_driver

TOP = "motion_front_end"


def elaborated(
    mode: Sequence[str | Path], parameters: Mapping[str, int]
) -> subprocess.CompletedProcess[str]:
    command = [verilator_driver(), *mode, "--quiet", "--top-module", TOP]
    command += [f"-G{name}={value}" for name, value in parameters.items()]
    files = file_list("motion/motion.f")
    return subprocess.run([*command, *files], cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(("axes", "clocks"), [(8, 71), (5, 47), (1, 15), (1, 256), (9, 100)])
def test_shape__that_cannot_work__is_refused_at_elaboration(axes, clocks):
    done = elaborated(["--lint-only"], {"Axes": axes, "ClocksPerTick": clocks})
    assert done.returncode != 0
    assert f"Axes={axes}, ClocksPerTick={clocks}, must be 1..8 and 8*Axes + 8 .. 255" in done.stderr


@pytest.mark.parametrize(("axes", "clocks"), [(8, 72), (5, 48), (1, 16), (1, 255)])
def test_shape__at_the_limits__is_taken(axes, clocks):
    parameters = {"Axes": axes, "ClocksPerTick": clocks}
    done = elaborated(["--lint-only", "-Wall", WAIVERS], parameters)
    assert done.returncode == 0, done.stderr


def moduli(node: Any) -> Iterator[str]:
    """Values of all parameters of that name in Verilator's tree."""
    if isinstance(node, list):
        for each in node:
            yield from moduli(each)
    elif isinstance(node, dict):
        if node.get("name") == "Modulus" and node.get("type") == "VAR":
            yield node["valuep"][0]["name"]
        yield from moduli(list(node.values()))


def test_modulus__unless_given__follows_the_clock(tmp_path: Path):
    done = elaborated(["--json-only", "--Mdir", tmp_path], {"ClocksPerTick": 125})
    assert done.returncode == 0, done.stderr
    tree = json.loads((tmp_path / f"V{TOP}.tree.json").read_text())
    assert set(moduli(tree)) == {f"32'h{16 * 125_000_000:x}"}
