# SPDX-License-Identifier: Apache-2.0
"""Port 0 of `mii_slave` between an MII source and an MII sink of cocotbext-eth, in the simulator.

Preamble, start delimiter and check sequence are made, found and checked by cocotbext-eth. Frames go
in and out as with `sim.bus.line.Line`, of which it has `send`, `receive`, `exchange` and
`run`; those are called in a function that `cocotb.task.bridge` started.
"""

from __future__ import annotations

from random import Random

from cocotb.clock import Clock
from cocotb.task import resume
from cocotb.triggers import Timer
from cocotbext.eth import GmiiFrame, MiiSink, MiiSource
from cocotbext.eth.constants import ETH_PREAMBLE

from sim.bus.line import GAP_NIBBLES, SETTLE_NS, Returned

CLOCK_PS, NIBBLE_PS = 10_000, 40_000
RESET_NS, WRITTEN_NS, LIMIT_NS = 100, 4_000, 400_000


class Port:
    """The source's clock has a random phase and is 100 ppm slow, exact, or 100 ppm fast.

    sent: the frames that left, with the times (ps) of their first and last nibble.
    """

    def __init__(self, dut, random: Random) -> None:
        self.dut = dut
        self.period = random.choice((NIBBLE_PS - 4, NIBBLE_PS, NIBBLE_PS + 4))
        self.phase = random.randrange(1, NIBBLE_PS, 2)  # at 0 ppm no edge falls upon one of clk_i
        self.source = MiiSource(dut.rxd_i, dut.rx_er_i, dut.rx_dv_i, dut.source_clk_i)
        self.sink = MiiSink(dut.txd_o, None, dut.tx_en_o, dut.tx_clk_o)
        self.sent: list[GmiiFrame] = []

    async def start(self) -> None:
        """Reset, clocks, and the time until the port is open."""
        self.dut.source_clk_i.value = 0
        self.dut.rst_ni.value = 0
        Clock(self.dut.clk_i, CLOCK_PS, unit="ps").start()
        await Timer(RESET_NS, unit="ns")
        self.dut.rst_ni.value = 1
        await Timer(self.phase, unit="ps")
        Clock(self.dut.source_clk_i, self.period, unit="ps").start()
        await Timer(SETTLE_NS, unit="ns")

    @resume
    async def run(self, ns: int) -> None:
        """Let time pass."""
        await Timer(ns, unit="ns")

    def send(
        self,
        data: bytes,
        sequence: bytes | None = None,
        error_at: int = -1,
        gap: int = GAP_NIBBLES,
    ) -> None:
        """Queue a frame; byte `error_at` has RX_ER. The gap, nibbles, is the least to the next."""
        if sequence is None:
            frame = GmiiFrame.from_payload(data)
        else:
            frame = GmiiFrame.from_raw_payload(data + sequence)
        if error_at >= 0:
            at = len(ETH_PREAMBLE) + error_at
            frame.error = [int(n == at) for n in range(len(frame.data))]
        frame.tx_complete = self.sent.append
        self.source.ifg = gap  # counted in nibbles here, whatever its name says
        self.source.send_nowait(frame)

    def receive(self) -> Returned | None:
        """The oldest frame that has come back, whole bytes after a whole preamble."""
        if self.sink.empty():
            return None
        frame = self.sink.recv_nowait()
        nibbles = (frame.sim_time_end - frame.sim_time_start) // NIBBLE_PS
        assert frame.get_preamble() == ETH_PREAMBLE and nibbles == 2 * len(frame), frame
        return Returned(
            bytes(frame.get_payload()),
            bytes(frame.get_fcs()),
            frame.check_fcs(),
            nibbles - 2 * len(ETH_PREAMBLE),
            frame.sim_time_start,
            frame.sim_time_end,
        )

    def exchange(self, data: bytes, **options) -> Returned | None:
        """Send a frame and wait for it; None if it does not come back within LIMIT_NS."""
        self.send(data, **options)
        resume(self.sink.wait)(LIMIT_NS, "ns")
        self.run(WRITTEN_NS)  # its writes come into force
        return self.receive()
