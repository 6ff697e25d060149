# SPDX-License-Identifier: Apache-2.0
"""One slave controller with an adapter and an RGMII PHY at each of its two ports, Verilated.

Frames go in and out as with `sim.bus.line.Line`, of which it has `send`, `receive`,
`exchange`, `run` and `now`. The PHYs (rgmii_harness.cpp) are written from the text of RGMII 2.0.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path

from sim.bus import line, verilated

HERE = Path(__file__).parent
TOP = "rgmii_slave"
UP, DOWN = 0b1011, 0b0000  # duplex, speed (01: 100 Mbit/s), link
PERIOD_PS = 40_000


@dataclass(frozen=True)
class Phy:
    """How a PHY sends: clock RXC and its delay after the data, ps; status nibble of the link.

    repeat: the nibble is there at the falling edge too; without, its complement does.
    """

    phase: int = 0
    period: int = PERIOD_PS
    high: int = PERIOD_PS // 2
    delay: int = 2000
    repeat: bool = True
    status: int = UP


@dataclass(frozen=True)
class Margins:
    """What a PHY saw at the pins: times in ps; nibbles with TX_ER and with unlike halves."""

    setup: int
    hold: int
    shortest: int
    longest: int
    errors: int
    unlike: int


@dataclass(frozen=True)
class Latencies:
    """(least, most) clocks of port 0: RXC falls, or rises, to mii_rx_clk; TX_EN to TX_CTL."""

    falling: tuple[int, int]
    rising: tuple[int, int]
    transmit: tuple[int, int]


class Rgmii(line.Line):
    """The slave's clock is `ppm` parts per million fast; `phys` at ports 0 and 1."""

    new = (ctypes.c_double,)

    def __init__(self, phys: tuple[Phy, Phy] = (Phy(), Phy(status=DOWN)), ppm: float = 0.0) -> None:
        folders = (*line.FOLDERS, HERE)
        longs = ("bus_began", "bus_now")
        library = verilated.load(TOP, HERE / "rgmii_harness.cpp", longs, folders)
        verilated.BusModel.__init__(self, library, ppm)
        for port, phy in enumerate(phys):
            self.phy(port, phy)
        self.run(line.SETTLE_NS)

    def phy(self, port: int, phy: Phy) -> None:
        """Let a port's PHY send like this from now on."""
        times = (ctypes.c_int64(x) for x in (phy.phase, phy.period, phy.high, phy.delay))
        self._call("shape", port, *times, int(phy.repeat))
        self._call("status", port, phy.status)

    def status(self, port: int, nibble: int) -> None:
        """What is on RXD between frames."""
        self._call("status", port, nibble)

    def stop(self, port: int = 0, stopped: bool = True) -> None:
        """RXC stops."""
        self._call("stopped", port, int(stopped))

    def link(self, port: int = 0) -> bool:
        """link_o of a port's adapter."""
        return bool(self._call("link", port))

    def began(self, number: int, port: int = 0) -> int:
        """When frame `number` from this port's PHY began at the pins, ps."""
        return self._call("began", port, number)

    def margins(self, port: int = 0) -> Margins:
        """What this port's PHY saw so far."""
        found = (ctypes.c_uint64 * 6)()
        self._call("margins", port, found)
        return Margins(*found)

    def latencies(self) -> Latencies:
        """What the adapter of port 0 took so far."""
        found = (ctypes.c_uint * 6)()
        self._call("latencies", found)
        return Latencies(*(tuple(found[n : n + 2]) for n in (0, 2, 4)))
