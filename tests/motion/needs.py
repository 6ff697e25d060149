# SPDX-License-Identifier: Apache-2.0
"""What tests of this folder may be skipped for, by name."""

import pytest

from sim.motion.gcode_oracle import find

needs_rs274 = pytest.mark.skipif(
    find() is None, reason="rs274 of linuxcnc-uspace is missing: python -m sim.motion.gcode_oracle"
)
