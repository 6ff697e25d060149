# SPDX-License-Identifier: Apache-2.0
"""The tracking program as a controller, on the Verilated core and on the instruction-set model."""

from __future__ import annotations

import numpy as np
import pytest

from asip_asm.assemble import assemble
from asip_asm.project import ROOT
from sim.core.controller import AsipController, ControllerFault
from sim.robot.parameters import Robot

COUNTS = np.array([2_600_000, 2_600_500, 2_599_000, 40, -30])


@pytest.fixture(scope="module")
def image():
    source = ROOT / "asip_asm/programs/tracking_optimised.s"
    return assemble(source, configuration="fast", defines=Robot.load().values())


def ticks(controller: AsipController) -> list:
    """Five ticks with the tool on a line, counts that follow it."""
    words = np.zeros(15)
    words[2] = 0.6
    controller.prime(words, COUNTS)
    found = []
    for tick in range(5):
        words[0] = 1e-6 * tick
        found.append(controller.step(words, COUNTS + tick))
    return found


def test_controller__on_the_model__computes_what_the_core_does_but_has_no_clock(image):
    core, model = (ticks(AsipController(image, backend=where)) for where in ("rtl", "iss"))
    for ours, other in zip(core, model, strict=True):
        # One unit in the last place of a sine or cosine may differ (docs/numerics.md).
        np.testing.assert_allclose(ours.outputs, other.outputs, rtol=1e-5)
        np.testing.assert_allclose(ours.exported, other.exported, rtol=1e-6)
        assert ours.cycles.min() > 0 and not other.cycles.any()


def test_controller__ticks_one_by_one_and_together__are_the_same(image):
    alone = AsipController(image)
    found = ticks(alone)
    again = AsipController(image)
    words = np.zeros((5, 15))
    words[:, 2] = 0.6
    again.prime(words[0], COUNTS)
    words[:, 0] = 1e-6 * np.arange(5)
    batch = again.batch(words, COUNTS + np.arange(5)[:, np.newaxis])
    assert np.array_equal(batch.outputs, np.concatenate([tick.outputs for tick in found]))
    assert alone.tick == again.tick == 5


def test_controller__of_a_closed_core__raises(image):
    controller = AsipController(image)
    ticks(controller)
    controller.core.close()
    with pytest.raises(ControllerFault, match="tick 5: the core is closed"):
        controller.step(np.zeros(15), COUNTS)
