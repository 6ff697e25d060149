# SPDX-License-Identifier: Apache-2.0
"""The processor as a LiteX module: an AXI4-Lite bus, an interrupt and the sources of the RTL.

    soc.asip = Asip(platform)
    region = SoCRegion(origin=0x9000_0000, size=Asip.SIZE, cached=False)
    soc.bus.add_slave("asip", soc.asip.bus, region)
    soc.irq.add("asip")

LiteX adds its own converter if the bus of the system is Wishbone.
"""

from __future__ import annotations

from litex.gen import LiteXModule
from litex.soc.interconnect.axi import AXILiteInterface
from litex.soc.interconnect.csr_eventmanager import EventManager, EventSourceLevel
from migen import ClockSignal, Instance, ResetSignal, Signal

from asip_asm.isa import default_isa
from sim.rtl.sources import sources_of

TOP = "asip_axil"
ADDRESS_BITS = 16  # of bytes
# Channel -> whether the core receives it, and its fields.
CHANNELS = {
    "aw": (True, ("addr", "prot")),
    "w": (True, ("data", "strb")),
    "b": (False, ("resp",)),
    "ar": (True, ("addr", "prot")),
    "r": (False, ("data", "resp")),
}


class Asip(LiteXModule):
    """The core `asip_axil` in the clock domain `sys`.

    `bus` is its AXI4-Lite port. `ev.run` is its interrupt, a level that is high from the end of a
    run until `CONTROL.clear` or the next start.
    """

    SIZE = 1 << ADDRESS_BITS

    def __init__(self, platform, configuration: str = "fast") -> None:
        """`configuration` is `fast`, `small`, `stream` or `wide`. Raises ValueError otherwise."""
        known = default_isa().configurations
        if configuration not in known:
            names = ", ".join(known)
            raise ValueError(f"no configuration '{configuration}'; there are {names}")
        self.bus = AXILiteInterface(data_width=32, address_width=32)
        self.ev = EventManager()
        self.ev.run = EventSourceLevel(description="A run has ended.")
        self.ev.finalize()
        interrupt = Signal()
        self.comb += self.ev.run.trigger.eq(interrupt)
        self.specials += Instance(
            TOP,
            i_clk_i=ClockSignal(),
            i_rst_ni=~ResetSignal(),
            o_irq_o=interrupt,
            **{f"p_{name}": value for name, value in known[configuration].parameters.items()},
            **self._pins(),
        )
        for path in sources_of(TOP):
            platform.add_source(str(path))

    def _pins(self) -> dict[str, Signal]:
        """Ports of the instance, as migen names them."""
        pins = {}
        for name, (received, fields) in CHANNELS.items():
            channel = getattr(self.bus, name)
            there, back = ("i", "o") if received else ("o", "i")
            for field in fields:
                signal = getattr(channel, field)
                word = signal[:ADDRESS_BITS] if field == "addr" else signal
                pins[f"{there}_{name}{field}_{there}"] = word
            pins[f"{there}_{name}valid_{there}"] = channel.valid
            pins[f"{back}_{name}ready_{back}"] = channel.ready
        return pins
