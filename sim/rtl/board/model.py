# SPDX-License-Identifier: Apache-2.0
"""The Verilated top of a board as a Python object: its pins, clock by clock.

The PLL is a pass-through here (rtl/board/ecp5_pll.sv): a clock of the oscillator's pin is a clock
of the core.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from pathlib import Path

from sim.rtl.build import build_library
from sim.rtl.sources import sources_of
from sim.rtl.verilated import Verilated

HARNESS = Path(__file__).with_name("board_harness.cpp")
HEADERS = (Path(__file__).parents[1] / "serial_line.h",)


@dataclass(frozen=True)
class Pins:
    """Top of a board, names of its pins, and clocks that a bit of its serial line takes."""

    module: str
    clock: str
    reset: str
    receive: str
    transmit: str
    divider: int


BOARDS = {
    "ulx3s": Pins("asip_ulx3s", "clk_25mhz", "btn_pwr_n", "ftdi_txd", "ftdi_rxd", 25),
    "colorlight-i9": Pins("asip_colorlight_i9", "clk_25mhz", "reset_n", "uart_rx", "uart_tx", 651),
    "versa-ecp5": Pins("asip_versa_ecp5", "clk_100mhz", "reset_n", "uart_rx", "uart_tx", 33),
    "ecpix5": Pins("asip_ecpix5", "clk_100mhz", "reset_n", "uart_rx", "uart_tx", 33),
}


class BoardRtl(Verilated):
    """One board, reset; the model is built at first use. Raises BuildError."""

    prefix = "board"

    def __init__(self, board: str = "ulx3s") -> None:
        pins = BOARDS[board]
        names = {
            "BOARD": f"V{pins.module}",
            "clk_i": pins.clock,
            "rst_ni": pins.reset,
            "rx_i": pins.receive,
            "tx_o": pins.transmit,
        }
        library = build_library(
            pins.module,
            sources_of(pins.module),
            HARNESS,
            headers=HEADERS,
            harness_flags=(
                *(f"-D{name}={value}" for name, value in names.items()),
                f"-I{HEADERS[0].parent}",
            ),
        )
        integer, text, u32 = ctypes.c_int, ctypes.c_char_p, ctypes.c_uint32
        signatures = {
            "step": (integer,),
            "direction": (integer,),
            "clock": (None, u32),
            "button": (None, integer),
            "encoders": (None, u32, u32, u32),
            "line_divider": (None, u32),
            "line_send": (None, text, u32),
            "line_receive": (integer, text, u32),
        }
        super().__init__(library, signatures)
        self.line(pins.divider)

    def clock(self, cycles: int = 1) -> None:
        """So many clocks."""
        self._lib.board_clock(self._handle, cycles)

    def button(self, down: bool) -> None:
        """The button that resets."""
        self._lib.board_button(self._handle, down)

    def encoders(self, a: int, b: int, z: int) -> None:
        """Levels of the encoders' lines, axis n in bit n."""
        self._lib.board_encoders(self._handle, a, b, z)

    @property
    def step(self) -> int:
        """Levels of the step pins, axis n in bit n."""
        return self._lib.board_step(self._handle)

    @property
    def direction(self) -> int:
        """Levels of the direction pins."""
        return self._lib.board_direction(self._handle)

    def line(self, divider: int) -> None:
        """Clocks of a bit at the far end of the serial line; at first those of the reset."""
        self._lib.board_line_divider(self._handle, divider)

    # A `ByteLine` of sim.debug.link
    def write(self, data: bytes) -> None:
        """Bytes for the serial line, after those that wait."""
        self._lib.board_line_send(self._handle, data, len(data))

    def read(self) -> bytes:
        """Bytes that the serial line has brought."""
        buffer = ctypes.create_string_buffer(65536)
        count = self._lib.board_line_receive(self._handle, buffer, len(buffer))
        return buffer.raw[:count]
