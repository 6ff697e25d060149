# SPDX-License-Identifier: Apache-2.0
"""KickCAT, unmodified, as a master of `master_loop`: no code of SOEM in it.

It waits its whole time-out at each broadcast, and takes an answer that comes later for a lost one:
simulated wires on a loaded machine are sometimes that slow. A bring-up that lost an answer begins
again, with twice the time-out.
"""

from __future__ import annotations

import kickcat

from sim.bus.tap import INTERFACE

FRAME_TIMEOUTS_S = (0.05, 0.1, 0.2, 0.4)
CYCLE_TIMEOUT_S, STATE_TIMEOUT_S = 2.0, 60.0
WATCHDOG_S = 0.1


class Master:
    """`master_loop.Master`."""

    def __init__(self, slaves: int) -> None:
        self._wanted = slaves
        self._link = kickcat.create_link(INTERFACE, "")

    def to_op(self) -> None:
        """Raises RuntimeError with the last reason."""
        for timeout in FRAME_TIMEOUTS_S:
            self._link.set_timeout(timeout)
            try:
                self._bus = self._mapped()
                break
            except RuntimeError as error:
                reason = error
        else:
            raise RuntimeError(f"KickCAT gave up {len(FRAME_TIMEOUTS_S)} times, last: {reason}")
        self._slaves = self._bus.slaves()
        self._link.set_timeout(CYCLE_TIMEOUT_S)
        self.exchange(0)
        self._bus.request_state(kickcat.State.OPERATIONAL)
        receive = self._bus.process_data_no_check
        self._bus.wait_for_state(kickcat.State.OPERATIONAL, STATE_TIMEOUT_S, receive)

    def _mapped(self) -> kickcat.Bus:
        """The slaves in SAFEOP."""
        bus = kickcat.Bus(self._link)
        bus.init(WATCHDOG_S)
        if (found := len(bus.slaves())) != self._wanted:
            raise RuntimeError(f"KickCAT found {found} slaves, there are {self._wanted}")
        bus.create_mapping()
        bus.request_state(kickcat.State.SAFE_OP)
        bus.wait_for_state(kickcat.State.SAFE_OP, STATE_TIMEOUT_S)
        return bus

    def exchange(self, value: int) -> bool:
        """As `master_loop.Master` has it; KickCAT reports a wrong counter by an error."""
        for slave in self._slaves:
            slave.set_output_bytes(bytes([value]) * slave.output_size)
        try:
            self._bus.process_data()
        except RuntimeError:
            return False
        return True

    def inputs(self) -> list[bytes]:
        """As `master_loop.Master` has it."""
        return [slave.input_data[: slave.output_size] for slave in self._slaves]

    def in_op(self) -> bool:
        """As `master_loop.Master` has it."""
        return all(self._bus.get_state(s) == kickcat.State.OPERATIONAL for s in self._slaves)

    def expected_counter(self) -> None:
        """KickCAT does not report it."""

    def close(self) -> None:
        """The link ends with this object."""
