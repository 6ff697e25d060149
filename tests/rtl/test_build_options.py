# SPDX-License-Identifier: Apache-2.0
"""How hard the compiler tries with a model is one of four words, and another stops the build."""

import pytest

from sim.rtl import build


def test_optimisation__unknown__is_refused_with_the_known_ones(monkeypatch) -> None:
    monkeypatch.setattr(build, "optimisation", "-Ofast")
    with pytest.raises(build.BuildError, match="MODEL_OPTIMISATION=-Ofast.*-O0, -O1, -O2, -O3"):
        build.build_library("asip", [], build.BASE)
