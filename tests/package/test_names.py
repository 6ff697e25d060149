# SPDX-License-Identifier: Apache-2.0
"""How the wheel names modules: `sim.core` of the checkout is `microtick.sim.core`."""

from __future__ import annotations

import pytest

from asip_asm.project import ROOT
from scripts.wheel import WheelError, moved, moved_source


@pytest.mark.parametrize(
    ("source", "wanted"),
    [
        ("from sim import Core\n", "from microtick.sim import Core\n"),
        ("from sim.core import Core\n", "from microtick.sim.core import Core\n"),
        ("    from asip_asm import isa\n", "    from microtick.asip_asm import isa\n"),
        ("run('-m', 'sim.debug.server')", "run('-m', 'microtick.sim.debug.server')"),
        ("f'sim.bus.{name}_master'", "f'microtick.sim.bus.{name}_master'"),
        ("# python -m sim.cocotb asip", "# python -m microtick.sim.cocotb asip"),
        ("'sim/core/api.py' 'build/sim.core'", "'sim/core/api.py' 'build/sim.core'"),
        ("'sim.vvp' 'sim.mk' 'sim'", "'sim.vvp' 'sim.mk' 'sim'"),
        ("options.sim.core", "options.sim.core"),
        ("from mysim.core import x", "from mysim.core import x"),
        ("from .sim.core import x", "from .sim.core import x"),
    ],
)
def test_name__is_moved_if_it_is_a_module_of_ours(source: str, wanted: str) -> None:
    assert moved(source, ROOT) == wanted


@pytest.mark.parametrize(
    ("source", "cause"),
    [
        ("import sim.core", "write 'from x import y'"),
        ("import numpy, asip_asm", "write 'from x import y'"),
        ("sim = 1\nprint(sim.core)", "file.py:2: rename the variable 'sim'"),
        ("from sim  import Core", "cannot be moved"),
        ("from sim . core import Core", "cannot be moved"),
        ("x = 'sim' '.core'", "cannot be moved"),
    ],
)
def test_form_that_cannot_be_moved__is_refused(source: str, cause: str) -> None:
    with pytest.raises(WheelError, match=cause):
        moved_source(source, "file.py", ROOT)


def test_code__is_the_same_otherwise() -> None:
    text = "from sim.core import Core\n\nx = Core('sim.toml')  # sim.core\n"
    wanted = "from microtick.sim.core import Core\n\nx = Core('sim.toml')  # microtick.sim.core\n"
    assert moved_source(text, "file.py", ROOT) == wanted
