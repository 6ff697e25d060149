# SPDX-License-Identifier: Apache-2.0
"""The pair of cores in lockstep: cycles and bits of one core, and no upset that nobody notices."""

from __future__ import annotations

import subprocess
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from asip_asm.isa import default_isa
from sim.rtl import build
from sim.rtl.asip_bus import FAULT_NAMES
from sim.rtl.asip_rtl import AsipRtl
from sim.rtl.sources import sources_of
from tests.silicon.ticks import PROGRAMS, compared, inputs, program
from tests.silicon.work import PairRtl
from tests.upsets.model import EFFECTS, HARNESS, OPEN, UPSET, Model
from tests.upsets.plan import KINDS, draw, line_of, upset_of

TOP = "asip_lockstep"
NOTICED = ("masked", "latent", "fault reported")


class PairModel(Model):
    """Both cores open; the host reads STATUS after the outputs."""

    @staticmethod
    def _library(resilient: bool) -> Path:
        shape = default_isa().configurations["fast"]
        return build.build_library(
            TOP,
            [OPEN, *sources_of(TOP)],
            HARNESS,
            {"FmaPipes": shape.fma_pipes, "Slots": len(shape.slots)},
            model_flags=("--flatten", "--vpi", "--prefix", "Vasip"),
        )


@pytest.fixture(scope="module")
def pair() -> PairModel:
    return PairModel(resilient=True)


def test_lockstep__without_a_delay__is_refused_at_elaboration():
    tool = [build.verilator_driver(), "--lint-only", "--quiet", "--top-module", TOP, "-GDelay=0"]
    done = subprocess.run([*tool, *sources_of(TOP)], capture_output=True, text=True)
    assert done.returncode != 0 and "Delay=0, must be 1 or more" in done.stderr


@pytest.mark.quick("small")
@pytest.mark.parametrize("configuration", ["small", "fast"])
def test_lockstep__without_an_upset__cycles_and_bits_of_one_core(configuration):
    cores = PairRtl(configuration), AsipRtl(configuration)
    image = program(PROGRAMS[1], configuration)
    assert compared(image, inputs(200), *cores)[0] is None


@pytest.mark.full
def test_lockstep__any_bit_of_either_core__nothing_wrong_is_silent(pair):
    found: Counter[tuple[str, str]] = Counter()
    for kind in KINDS:
        upsets = draw(pair, kind, 0)[:120]
        for upset, outcome in zip(upsets, pair.inject(upsets), strict=True):
            effect = EFFECTS[outcome["effect"]]
            assert effect in NOTICED, line_of(pair.sites, upset)
            assert outcome["unsafe"] == 0
            found[kind.name, effect] += 1
    assert found["flip-flops", "fault reported"] > 5
    assert found["program memory in use", "fault reported"] > 20


@pytest.mark.full
def test_lockstep__a_bit_of_a_result__is_the_fault_disagree(pair):
    places = [n for n, s in enumerate(pair.sites) if s.name.endswith("operand_e1_q")]
    assert len(places) >= 2  # of each core
    for site in places:
        bits = range(20, pair.sites[site].bits, 32)  # of each operand
        moments = [(9, clock, site, 0, bit) for clock in range(70, 200) for bit in bits]
        upsets = np.array(moments, dtype=UPSET)
        known = [o for o in pair.inject(upsets) if o["cause"]]
        assert {FAULT_NAMES[int(o["cause"])] for o in known} == {"DISAGREE"}
        assert all(o["ticks"] == 0 for o in known)  # a state that is wrong, too


def test_lockstep__own_registers__a_false_alarm_at_most(pair):
    own = [s for s in pair.sites if "gen_core" not in s.name and s.elements == 1]
    assert {"up_q", "differs_q", "mismatch_q"} <= {site.name.split(".")[-1] for site in own}
    for site in own:
        for bit in range(0, site.bits, 7):
            (outcome,) = pair.inject(upset_of(pair.sites, f"5 90 {site.name}.{bit}"))
            assert EFFECTS[outcome["effect"]] in NOTICED, (site.name, bit)
