# SPDX-License-Identifier: Apache-2.0
"""pysoem (SOEM), unmodified, as a master of `master_loop`."""

from __future__ import annotations

import pysoem

from sim.bus.register import ByteRegister
from sim.bus.tap import INTERFACE

STATE_TIMEOUT_US = 60_000_000
FRAME_TIMEOUT_US = 2_000_000


def read(slave: pysoem.CdefSlave, register: ByteRegister, wait_us: int) -> int:
    """A register of a slave."""
    return int.from_bytes(slave._fprd(register.address, register.width, wait_us), "little")


class Master:
    """`master_loop.Master`; simulated wires are slow, so its time-outs are longer.

    second: interface at the far end of a ring, for redundancy. `pysoem` is the master itself.
    """

    def __init__(self, slaves: int, second: str | None = None) -> None:
        for name in ("ret", "safe", "eeprom", "state"):
            setattr(pysoem.settings.timeouts, name, FRAME_TIMEOUT_US)
        self._wanted = slaves
        self._second = second
        self.pysoem = pysoem.Master()

    def to_op(self) -> None:
        """Raises RuntimeError with the state reached."""
        self.to_safeop()
        self.from_safeop()

    def to_safeop(self) -> None:
        """The first half of `to_op`."""
        master = self.pysoem
        master.open(INTERFACE, self._second)
        if (found := master.config_init()) != self._wanted:
            raise RuntimeError(f"pysoem found {found} slaves, there are {self._wanted}")
        master.config_map()
        state = master.state_check(pysoem.SAFEOP_STATE, STATE_TIMEOUT_US)
        if state != pysoem.SAFEOP_STATE:
            raise RuntimeError(f"the slaves are in state {state}, not in SAFEOP")

    def from_safeop(self) -> None:
        """The second half of `to_op`."""
        master = self.pysoem
        master.send_processdata()
        master.receive_processdata(FRAME_TIMEOUT_US)
        master.state = pysoem.OP_STATE
        master.write_state()
        state = master.state_check(pysoem.OP_STATE, STATE_TIMEOUT_US)
        if state != pysoem.OP_STATE:
            raise RuntimeError(f"the slaves are in state {state}, not in OP")

    def exchange(self, value: int, wait_us: int = FRAME_TIMEOUT_US) -> bool:
        """As `master_loop.Master` has it; wait_us: for the answer."""
        for slave in self.pysoem.slaves:
            slave.output = bytes([value]) * len(slave.output)
        self.pysoem.send_processdata()
        return self.pysoem.receive_processdata(wait_us) == self.pysoem.expected_wkc

    def inputs(self) -> list[bytes]:
        """As `master_loop.Master` has it."""
        return [slave.input[: len(slave.output)] for slave in self.pysoem.slaves]

    def in_op(self) -> bool:
        """As `master_loop.Master` has it."""
        self.pysoem.read_state()
        return all(slave.state == pysoem.OP_STATE for slave in self.pysoem.slaves)

    def expected_counter(self) -> int:
        """As `master_loop.Master` has it."""
        return self.pysoem.expected_wkc

    def close(self) -> None:
        """As `master_loop.Master` has it."""
        self.pysoem.close()
