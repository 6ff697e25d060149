# SPDX-License-Identifier: Apache-2.0
"""The processor with its debug block as a Python object: Verilated model, its bus and pins."""

from __future__ import annotations

import ctypes

from sim.debug.link import SerialLink
from sim.debug.state import REGISTER, REGMAP
from sim.rtl.asip_rtl import HARNESS, AsipRtl


class DebugRtl(AsipRtl):
    """One instance in one of the configurations, built at first use.

    `run` and ports of ticks are those of the core alone; a run that is halted does not end, so use
    `start` of a client, or `clock`, where a run may be halted.
    """

    top = "debug_asip"
    files = ("debug/debug.f",)
    headers = (HARNESS.with_name("serial_line.h"),)
    harness_flags = ("-DDEBUG_BLOCK",)

    def __init__(self, configuration: str = "fast") -> None:
        super().__init__(configuration)
        integer, text, u32 = ctypes.c_int, ctypes.c_char_p, ctypes.c_uint32
        signatures = {
            "debug_active": (integer,),
            "line_divider": (None, u32),
            "line_send": (None, text, u32),
            "line_receive": (integer, text, u32),
        }
        self._bind(signatures)

    @property
    def debug_active(self) -> bool:
        """Level of the line to the power stage."""
        return bool(self._lib.asip_debug_active(self._model))

    def serial_link(self, divider: int = 8) -> SerialLink:
        """A link over the pins of the serial port, so many clocks a bit."""
        uart = REGMAP.registers["UART"]
        self.write(REGISTER["UART"], uart.word(divider=divider))
        self._lib.asip_line_divider(self._model, divider)
        return SerialLink(_Pins(self), "serial pins of the model", clock=self)

    def send_line(self, data: bytes) -> None:
        """Bytes for the serial line, after those that wait."""
        self._lib.asip_line_send(self._model, data, len(data))

    def receive_line(self) -> bytes:
        """Bytes that the serial line has brought."""
        buffer = ctypes.create_string_buffer(65536)
        count = self._lib.asip_line_receive(self._model, buffer, len(buffer))
        return buffer.raw[:count]


class _Pins:
    """The line of a model for a `SerialLink`."""

    def __init__(self, model: DebugRtl) -> None:
        self._model = model

    def write(self, data: bytes) -> None:
        self._model.send_line(data)

    def read(self) -> bytes:
        return self._model.receive_line()

    def close(self) -> None:
        """The model stays."""
