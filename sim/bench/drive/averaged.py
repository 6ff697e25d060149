# SPDX-License-Identifier: Apache-2.0
"""The chain with averaged inverters, as a plant of `sim.core.closed_loop`: whole paths in minutes.

Windings, mechanics, friction and sensing are those of `sim.bench.drive.chain`; carrier, filters and
decoder are their formulas, and the current loops are the program's C, whose bits are the core's
except for the last bit of a sine that only sets the first angle.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.files import write_text
from asip_asm.model.c_code import parameter_macros, to_c_code
from asip_asm.project import BUILD
from sim.bench.drive.chain import compiled_law
from sim.bench.drive.plant import AXES, Plant
from sim.bench.drive.start_up import WINDOW, least_clocks
from sim.laws.drive.clocks import HALF_PERIOD, LOOP_PERIOD, MACROS
from sim.laws.drive.current_law import MAGIC, Setting
from sim.robot.records import Floats
from sim.rtl import runtime
from sim.rtl.build import machine_flag

HERE = Path(__file__).parent
NAME = "current_loops"
WINDOW_CLOCKS = 3 * 64 * 6
MIDDLE = WINDOW + WINDOW_CLOCKS // 2 - HALF_PERIOD  # of the currents' window, in the next half
END = WINDOW + WINDOW_CLOCKS + 5 - HALF_PERIOD  # positions are sampled, the run begins


def library(plant: Plant, setting: Setting, parameters: Mapping[str, float]) -> Path:
    """The shared library with these parameters of the program, built once per content."""
    compiled = compiled_law(plant.drives, setting)
    header, source = to_c_code(compiled, f"{NAME}.tick.h")
    macros = parameter_macros(compiled.law, NAME)
    defines = [
        *MACROS,
        *(f"-D{macros[name]}={value!r}f" for name, value in sorted(parameters.items())),
    ]
    texts = [header, source, *defines, runtime.toolchain()]
    texts += [(HERE / name).read_text() for name in ("averaged.cpp", "plant.h")]
    folder = BUILD / "servo" / hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16]
    path = folder / "libaveraged.so"
    with runtime.only_one(folder):
        if not runtime.sealed(path):
            folder.mkdir(exist_ok=True)
            write_text(folder / f"{NAME}.tick.h", header)
            write_text(folder / f"{NAME}.c", source)
            common = ["-O2", "-fPIC", "-ffp-contract=off", *machine_flag(), f"-I{HERE}", "-I."]
            c = ["-x", "c", f"{NAME}.c", "-c", "-o", f"{NAME}.o"]
            runtime.run([runtime.compiler(), *common, *defines, *c], folder)
            cpp = [
                "-std=c++17",
                "-shared",
                str(HERE / "averaged.cpp"),
                f"{NAME}.o",
                "-o",
                str(path),
            ]
            runtime.run([runtime.compiler(), *common, *defines, *cpp, "-o", path], folder)
            runtime.seal(path)
    return path


class AveragedPlant:
    """Robot and drives, brought up; forces ordered in, counts out: the interface of `Plant`.

    angles: electrical angle at count 0 [rad], as a start-up finds it; zeros (5, 2): words of the
    currents' offsets; by default what they are. noise: of a sensed current [A].
    """

    def __init__(
        self,
        plant: Plant,
        setting: Setting,
        at: Sequence[float],
        angles: Floats | None = None,
        zeros: ArrayLike | None = None,
        noise: float = 0.0,
    ) -> None:
        if angles is None:
            angles = true_angles(plant, at_joints(plant, at))
        if zeros is None:
            zeros = true_zeros(plant)
        words = {f"angle{n}": float(np.float32(angle)) for n, angle in enumerate(angles)}
        for n, pair in enumerate(np.asarray(zeros, dtype=float)):
            words |= {f"zero_a{n}": MAGIC + float(pair[0]), f"zero_b{n}": MAGIC + float(pair[1])}
        self._robot = plant.robot
        self._lib = ctypes.CDLL(str(library(plant, setting, words)))
        pointer, number, u32 = ctypes.c_void_p, ctypes.c_double, ctypes.c_uint32
        self._lib.averaged_new.restype = pointer
        self._lib.averaged_new.argtypes = [pointer, pointer, *[number] * 4, pointer]
        self._lib.averaged_free.argtypes = [pointer]
        self._lib.averaged_brakes.argtypes = [pointer, u32]
        self._lib.averaged_put.argtypes = [pointer] * 4
        self._lib.averaged_halves.argtypes = [*[pointer] * 4, u32]
        self._lib.averaged_look.argtypes = [pointer, pointer, pointer]
        record, start = plant.record(), np.array(at, dtype=float)
        self._counts = np.zeros(AXES, dtype=np.int64)
        self._handle = self._lib.averaged_new(
            *(record.ctypes.data, start.ctypes.data, MIDDLE, END, least_clocks(plant.drives)),
            *(noise, self._counts.ctypes.data),
        )
        self._state = np.zeros(25)
        self._look()

    def __del__(self) -> None:
        if getattr(self, "_handle", None):
            self._lib.averaged_free(self._handle)

    def _look(self) -> None:
        self._lib.averaged_look(self._handle, self._state.ctypes.data, self._counts.ctypes.data)

    @property
    def joints(self) -> NDArray[np.float64]:
        """Exact l_1 .. l_3 [m], theta_4, theta_5 [rad]."""
        return self._state[:5].copy()

    @property
    def tool(self) -> NDArray[np.float64]:
        """Position of the tool [m]."""
        return self._state[5:8].copy()

    @property
    def table(self) -> NDArray[np.float64]:
        """Angles of the table [rad]."""
        return self._state[3:5].copy()

    def counts(self) -> tuple[int, ...]:
        """Of the five encoders."""
        return tuple(self._counts.tolist())

    def put(self, place: ArrayLike, rates: ArrayLike, bristles: ArrayLike) -> None:
        """Move the machine to (x, y, z [m], tilt, rotation [rad]), with these speeds and its
        bristles (5,) bent so; the counters count the way."""
        rows = [np.array(row, dtype=float) for row in (place, rates, bristles)]
        self._lib.averaged_put(self._handle, *(row.ctypes.data for row in rows))
        self._look()

    def brakes(self, released: int) -> None:
        """Bit n opens axis n's holding brake; all are open at first."""
        self._lib.averaged_brakes(self._handle, released)

    def halves(
        self, orders: ArrayLike, joints: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """A half period per row of orders (n, 5): (n, 15), i_d, i_q [A], joints at its end.

        joints: (n + 1, 5), a test bench moves them so, whatever the forces. Raises ValueError if
        the program ends with a fault.
        """
        rows = np.ascontiguousarray(orders, dtype=np.float32)
        out = np.zeros((len(rows), 15))
        bench = None if joints is None else np.ascontiguousarray(joints, dtype=np.float64)
        moved = None if bench is None else bench.ctypes.data
        place, into = rows.ctypes.data, out.ctypes.data
        if self._lib.averaged_halves(self._handle, place, moved, into, len(rows)):
            raise ValueError("the current loops stopped with a fault")
        self._look()
        return out

    def step(self, outputs: Sequence[float]) -> tuple[int, ...]:
        """Orders for a control period; the counts at its end."""
        halves = round(self._robot.T_s / LOOP_PERIOD)
        self.halves(np.tile(np.asarray(outputs, dtype=np.float32), (halves, 1)))
        return self.counts()


def at_joints(plant: Plant, at: Sequence[float]) -> tuple[float, ...]:
    """Joints at (x, y, z [m], tilt, rotation [rad])."""
    x, y, z = at[:3]
    legs = ((x - xp, y - yp) for xp, yp in plant.robot.legs)
    return (*(float(np.sqrt(dx * dx + dy * dy + z * z)) for dx, dy in legs), *at[3:])


def true_angles(plant: Plant, joints: Sequence[float]) -> list[float]:
    """Electrical angles [rad] where the counters are 0, -pi .. pi."""
    found = []
    for n, motor in enumerate(plant.drives.motors):
        resolution = plant.robot.resolution[n]
        count = np.floor(joints[n] / resolution + 0.5)
        angle = motor.wave * count * resolution + plant.angle[n]
        found.append(float((angle + np.pi) % (2 * np.pi) - np.pi))
    return found


def true_zeros(plant: Plant) -> NDArray[np.float64]:
    """Words (5, 2) of the currents' offsets, whole counts."""
    axis = plant.record()["axis"]
    scale = 2**17 / plant.drives.current_scale
    return np.round(np.stack([axis["offset_a"], axis["offset_b"]], axis=1) * scale)
