# SPDX-License-Identifier: Apache-2.0
"""Clock of the drives and half period of their carrier.

The laws, the plants in C++ and the start-up take both from here. The clock is that of the
instruction set, the half period the reset value of the register PWM.
"""

from __future__ import annotations

from asip_asm.isa import default_isa
from sim.rtl.gen.drive_regmap import REGMAP

_PWM = REGMAP.registers["PWM"]
_HALF = _PWM.fields["half_period"]

CLOCK = 1 / (1e6 * default_isa().clock_mhz)  # its period [s]
HALF_PERIOD = ((_PWM.reset or 0) >> _HALF.low) % (1 << _HALF.width)  # of the carrier [clocks]
LOOP_PERIOD = HALF_PERIOD * CLOCK  # of the current loops [s]
MACROS = (f"-DSERVO_CLOCK={CLOCK!r}", f"-DSERVO_HALF={HALF_PERIOD}")  # of the plants in C++
