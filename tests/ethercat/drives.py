# SPDX-License-Identifier: Apache-2.0
"""The axes of the device as drives of CiA 402, for a master in a test."""

from __future__ import annotations

import numpy as np
from canopen.profiles.p402 import State402

from tests.ethercat.host import AXES, Host

SHUTDOWN, SWITCH_ON, ENABLE, QUICK_STOP, RESET = 0x06, 0x07, 0x0F, 0x02, 0x80
PP, PV, PT, HOMING, CSP, CSV, CST = 1, 3, 4, 6, 8, 9, 10
TICK = 1e-4  # s
PLANNING = 34  # control cycles in which a move of profile position is planned


def state_of(status: int) -> str:
    """The one state whose mask python-canopen finds in the statusword."""
    found = [s for s, (mask, value) in State402.SW_MASK.items() if status & mask == value]
    assert len(found) == 1, hex(status)
    return found[0]


class Drives(Host):
    """The device in OP; `set` gives outputs of an axis, each `step` writes them."""

    def __init__(self, mode: int = CSP) -> None:
        super().__init__()
        self.to_op()
        self.values = {(0x6060 + 0x800 * n, 0): mode for n in range(AXES)}
        self.step()

    def set(self, axis: int = 0, **values: int) -> None:
        names = {
            "control": 0x6040, "mode": 0x6060, "position": 0x607A, "velocity": 0x60FF,
            "torque": 0x6071, "velocity_offset": 0x60B1, "torque_offset": 0x60B2,
        }  # fmt: skip
        for name, value in values.items():
            self.values[names[name] + 0x800 * axis, 0] = value

    def step(self, cycles: int = 1, **values: int) -> None:
        """A frame of the master, with these outputs of the first axis, then control cycles."""
        self.set(**values)
        self.outputs(self.values)
        self.cycle(cycles)

    def follow(self, cycles: int, every: int = 10, **values: int) -> np.ndarray:
        """`set_point` in each of so many control cycles, with a frame in the first one and in
        every `every`-th after it."""
        self.set(**values)
        rows = []
        for n in range(cycles):
            if n % every == 0:
                self.outputs(self.values)
            self.cycle()
            rows.append(self.set_point())
        return np.array(rows)

    def set_point(self) -> tuple[float, float, float]:
        """Position, velocity, acceleration of the first axis."""
        axis = self.command.axis[0]
        return axis.position + axis.fraction, axis.velocity, axis.acceleration

    def statusword(self, axis: int = 0) -> int:
        return self.inputs()[0x6041 + 0x800 * axis, 0]

    def state(self, axis: int = 0) -> str:
        return state_of(self.statusword(axis))

    def enable(self, axis: int = 0, **values: int) -> None:
        for control in (SHUTDOWN, SWITCH_ON, ENABLE):
            self.set(axis, control=control, **values)
            self.step()
        assert self.state(axis) == "OPERATION ENABLED"
