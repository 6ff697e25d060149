# SPDX-License-Identifier: Apache-2.0
"""The whole chain as RTL, every clock of it: moves to set-points to forces to gate edges, and back.

`ChainRtl` is the Verilated `drive_chain` with its plant, brought up by `sim.bench.drive.start_up`.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.image import Image
from asip_asm.model.compiler import Compiled, Options, compile_law
from asip_asm.model.program import Built, build
from asip_asm.project import BUILD
from sim.bench.drive.plant import AXES, Plant
from sim.laws.drive.clocks import MACROS
from sim.laws.drive.current_law import Setting, current_law
from sim.robot.drives import Drives
from sim.rtl.asip_bus import BLOCK
from sim.rtl.dual_rtl import Core, DualRtl
from sim.rtl.gen.drive_regmap import REGMAP
from sim.rtl.gen.dual_regmap import REGMAP as DUAL

CURRENT, FRONT_END = 1 << 16, 2 << 16  # of the address
ORDER_FILTER = (0.0, 0.0, 0.0, 1e-3, 1e-3)  # of the table's axes, whose counts are coarse [s]
INDEX = 4096  # counts between two indices, as chain_harness.cpp makes them
CONFIGURATIONS = {"trajectory": "small", "tracking": "fast", "current": "small"}
_PERIOD = DUAL.registers["PERIOD"].reset
assert _PERIOD is not None
CONTROL_PERIOD = _PERIOD  # clocks
OPTIONS = Options(configuration=CONFIGURATIONS["current"], reassociate=True, reciprocal=True)
FLAGS = {name: REGMAP.registers[name].fields for name in ("STATUS", "CAUSE")}
HALF = np.dtype(
    [
        *((name, float, AXES) for name in ("i_d", "i_q", "position")),
        ("duty", float, (AXES, 3)),
    ]
)
"""Means of a half period around the instant of a sample; duty: of the conducting high switch."""


@dataclass(frozen=True)
class Look:
    """State of the plant (five each, SI units), clocks since reset, open brakes as bits.

    place, rates: of tool and table (x, y, z, tilt, rotation) and their speeds.
    shoot_through: edges after which both gates, or both switches, of a phase are on; silent: clock
    of the last moment at which all gates went off; chopper: 1 while `chopper_o` is on.
    """

    joints: NDArray[np.float64]
    place: NDArray[np.float64]
    i_d: NDArray[np.float64]
    i_q: NDArray[np.float64]
    bristles: NDArray[np.float64]
    rates: NDArray[np.float64]
    clock: int
    shoot_through: int
    released: int
    silent: int
    chopper: int


class ChainRtl(DualRtl):
    """`drive_chain` just out of reset with its motors; the bus is that of `DualRtl`.

    It has two current sensors an axis, and a third one in `GuardedChain`.
    """

    top = "drive_chain"
    harness = Path(__file__).with_name("chain_harness.cpp")
    headers = (Path(__file__).with_name("plant.h"),)
    macros = MACROS

    def __init__(self) -> None:
        super().__init__(CONFIGURATIONS["trajectory"], CONFIGURATIONS["tracking"])
        pointer, u32 = ctypes.c_void_p, ctypes.c_uint32
        self._lib.chain_place.argtypes = [pointer] * 4
        self._lib.chain_look.argtypes = [pointer] * 2
        self._lib.chain_begun.argtypes = [pointer] * 2
        self._lib.chain_trace.argtypes = [pointer, ctypes.c_int]
        self._lib.chain_halves.argtypes = [pointer, pointer, u32]
        self._lib.chain_orders.argtypes = [pointer, pointer, pointer, u32]
        self._lib.chain_spin.argtypes = [pointer] * 2
        self._lib.chain_travel.argtypes = [pointer, pointer, u32]
        self._lib.chain_modulators.argtypes = [pointer] * 2
        self._lib.chain_slip.argtypes = [pointer, u32, ctypes.c_int64]
        self._lib.chain_sensors.argtypes = [pointer, u32, pointer, u32]
        self._lib.chain_fault.argtypes = [pointer, *[u32] * 4, ctypes.c_double]
        self.current = Core(self, "trajectory", CONFIGURATIONS["current"])
        self.current._base = CURRENT

    def place(self, plant: Plant, at: Sequence[float]) -> NDArray[np.int64]:
        """Put the plant at rest at (x, y, z [m], tilt, rotation [rad]); its encoders' counts."""
        record, start = plant.record(), np.array(at, dtype=float)
        counts = np.zeros(AXES, dtype=np.int64)
        self._lib.chain_place(
            self._handle, record.ctypes.data, start.ctypes.data, counts.ctypes.data
        )
        return counts

    def spin(self, speeds: Sequence[float]) -> None:
        """A test bench turns the motors at these speeds (5,) [m/s, rad/s] from now on."""
        held = np.array(speeds, dtype=float)
        self._lib.chain_spin(self._handle, held.ctypes.data)

    def travel(self, rows: ArrayLike) -> None:
        """The test bench moves the joints to a row (5,) [m, rad] in each of the next half periods,
        between the instants at which `halves` takes positions."""
        places = np.ascontiguousarray(rows, dtype=float)
        self._lib.chain_travel(self._handle, places.ctypes.data, len(places))

    def modulators(self, state: ArrayLike) -> None:
        """First integrators (5, 2) of the currents' modulators: another draw of their noise."""
        begun = np.array(state, dtype=float)
        self._lib.chain_modulators(self._handle, begun.ctypes.data)

    def look(self) -> Look:
        """The plant as it is."""
        out = np.zeros(35)
        self._lib.chain_look(self._handle, out.ctypes.data)
        joints, place, i_d, i_q, bristles, rates = (out[i : i + 5] for i in range(0, 30, 5))
        clock, shoot_through, released, silent, chopper = (int(value) for value in out[30:])
        return Look(
            *(joints, place, i_d, i_q, bristles, rates, clock, shoot_through, released, silent),
            chopper,
        )

    def begun(self) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
        """Joints (5,) and tool (3,) in the first clock of the last control period; that clock
        counted from the carrier's half."""
        out = np.zeros(11)
        self._lib.chain_begun(self._handle, out.ctypes.data)
        return out[:5], out[5:8], int(out[10])

    def trace(self) -> None:
        """Begin (and empty) the record of half periods."""
        self._lib.chain_trace(self._handle, 1)

    def halves(self) -> NDArray[np.void]:
        """Half periods since `trace`, (n,) of `HALF`."""
        count = self._lib.chain_halves(self._handle, None, 0)
        out = np.zeros(count, dtype=HALF)
        self._lib.chain_halves(self._handle, out.ctypes.data, count)
        return out

    def order(self, addresses: Sequence[int], rows: ArrayLike) -> None:
        """Let the host write a row of five orders [N, N m] in each of the next half periods."""
        places = np.array([CURRENT + a for a in addresses], dtype=np.uint32)
        words = np.ascontiguousarray(rows, dtype=np.float32).view(np.uint32)
        self._lib.chain_orders(self._handle, places.ctypes.data, words.ctypes.data, len(words))

    def fault(self, volts: float, **axes: int) -> None:
        """Faults of the plant: bits of axes for lost, touching, shorted, stage; the bus voltage."""
        bits = [axes.get(name, 0) for name in ("lost", "touching", "shorted", "stage")]
        self._lib.chain_fault(self._handle, *bits, volts)

    def sensors(
        self, stuck: Mapping[int, int] | None = None, drift: ArrayLike = 0.0, broken: int = 0
    ) -> None:
        """Faults of the current sensors and windings.

        stuck: phase (0, 1, 2) to bits of axes whose sensor shows no current; drift: what the
        sensors (5, 3) show too much [A]; broken: bit 5 phase + axis of a phase that is open.
        """
        bits = sum(axes << AXES * phase for phase, axes in (stuck or {}).items())
        more = np.ascontiguousarray(np.broadcast_to(drift, (AXES, 3)), dtype=float)
        self._lib.chain_sensors(self._handle, bits, more.ctypes.data, broken)

    def slip(self, axes: int, every: int) -> None:
        """Encoders of these axes (bits) lose one of so many counts from now on."""
        self._lib.chain_slip(self._handle, axes, every)

    def front(self, name: str, index: int = 0, **fields: int) -> None:
        """Write a register of the front-end by its fields, the others 0."""
        word = REGMAP.registers[name].word(**fields)
        self.write_word(FRONT_END + REGMAP.address(name) + index, word)

    def read_front(self, name: str, index: int = 0) -> int:
        """Read a register of the front-end, unsigned."""
        return self.read_word(FRONT_END + REGMAP.address(name) + index)

    def status(self) -> dict[str, int]:
        """Fields of the front-end's STATUS and CAUSE."""
        found: dict[str, int] = {}
        for register, fields in FLAGS.items():
            word = self.read_front(register)
            found |= {name: field.of(word) for name, field in fields.items()}
        return found


class GuardedChain(ChainRtl):
    """`drive_chain` with three current sensors an axis."""

    parameters = MappingProxyType({"ThirdSensor": 1})


def compiled_law(drives: Drives, setting: Setting) -> Compiled:
    """The current loops' program as it runs in the chain."""
    return compile_law(current_law(drives, setting), OPTIONS)


@functools.cache
def current_program(drives: Drives, setting: Setting) -> Built:
    """Its image, made once."""
    path = BUILD / "servo/current_loops.s"
    path.parent.mkdir(parents=True, exist_ok=True)
    return build(compiled_law(drives, setting), path)


def write_constants(core: Core, image: Image, values: Mapping[str, float]) -> None:
    """Write parameters of a program by name, between two runs."""
    places = {entry.name: entry.index for entry in image.constants}
    for name, value in values.items():
        word = int(np.float32(value).view(np.uint32))
        core.write(BLOCK["constants"] + places[name], word)
