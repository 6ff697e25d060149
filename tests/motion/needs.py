# SPDX-License-Identifier: Apache-2.0
"""What tests of this folder may be skipped for, by name; nothing may be under CI=true."""

import os

import pytest

from sim.motion.gcode_oracle import find

needs_rs274 = pytest.mark.skipif(
    find() is None and os.environ.get("CI") != "true",
    reason="rs274 of linuxcnc-uspace is missing: python -m sim.motion.gcode_oracle",
)
