# SPDX-License-Identifier: Apache-2.0
"""The proof of a robot's law finds mistakes of its reader."""

from __future__ import annotations

import pytest

from sim.laws.laws import LAWS
from tests.model_compiler import planted
from tests.model_compiler.planted import HELD, PLANTED, STATED, Planted


@pytest.mark.quick("encoders *", "sign of a *")
@pytest.mark.parametrize("mistake", PLANTED, ids=lambda one: one.name)
def test_planted_mistake__of_the_reader__is_found(mistake, tmp_path):
    assert planted.found(mistake, tmp_path)


@pytest.mark.parametrize("law", LAWS)
def test_no_mistake__of_the_reader__none_is_found(law, tmp_path):
    for stated in (STATED, HELD):
        assert not planted.found(Planted("none", law, stated=stated), tmp_path)
