# SPDX-License-Identifier: Apache-2.0
"""Records that the controllers, the tests and the reports exchange: set-points and results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asip_asm.interface import program_interface

Floats = Sequence[float] | NDArray[np.floating]
Counts = Sequence[int] | NDArray[np.integer]

TRACKING = program_interface("tracking")
"""Inputs and outputs of the tracking law, of every program that computes it."""
TRACKING_PROGRAMS = (
    "tracking_as_printed",
    "tracking_optimised",
    "tracking_observer",
    "tracking_stamps",
)
MEASURED_STATES = frozenset(
    state.name
    for program in TRACKING_PROGRAMS
    for state in program_interface(program).states
    if state.starts_from is not None
)
"""States of the programs that hold the last measurement; they start with the first one."""
SET_POINTS = TRACKING.set_points
COUNTS = TRACKING.measurements
STAMPS = tuple(f"stamp{n}" for n in range(1, 6))
"""Inputs of a program that takes speeds from time stamps; they follow the counts."""
OUTPUTS = tuple(signal.name for signal in TRACKING.outputs)
POSITIONS = ("l1", "l2", "l3", "theta4", "theta5")
VELOCITIES = ("v1", "v2", "v3", "omega4", "omega5")
ACCELERATIONS = ("a1", "a2", "a3", "eps4", "eps5")
TABLE_3 = POSITIONS + VELOCITIES + ACCELERATIONS
"""Rows of the published table 3: the desired joint motion."""
EXPORT_OF_ROW = dict(
    zip(
        TABLE_3,
        (
            *("l1", "l2", "l3", "alpha", "gamma"),
            *("v1", "v2", "v3", "w_alpha", "w_gamma"),
            *("acc1", "acc2", "acc3", "eps_alpha", "eps_gamma"),
        ),
        strict=True,
    )
)
"""Row of table 3 -> export of the programs; 'a1' cannot be one, it names a register."""


@dataclass(frozen=True)
class SetPoints:
    """Desired tool motion over N ticks, arrays of shape (N, 3) and (N, 2) in SI units."""

    position: NDArray[np.floating]  # x, y, z
    velocity: NDArray[np.floating]  # v_x, v_y, v_z
    acceleration: NDArray[np.floating]  # a_x, a_y, a_z
    table_position: NDArray[np.floating]  # alpha, gamma
    table_velocity: NDArray[np.floating]  # w_alpha, w_gamma
    table_acceleration: NDArray[np.floating]  # eps_alpha, eps_gamma

    def __post_init__(self) -> None:
        ticks = np.shape(self.position)[0]
        for name, array in vars(self).items():
            want = (ticks, 2 if name.startswith("table") else 3)
            if np.shape(array) != want:
                raise ValueError(f"{name} has the shape {np.shape(array)}, must be {want}")

    def __len__(self) -> int:
        return self.position.shape[0]

    def words(self) -> NDArray[np.floating]:
        """The 15 inputs of each tick, (N, 15), in the order of the fields."""
        return np.concatenate(tuple(vars(self).values()), axis=1)

    @classmethod
    def from_words(cls, words: ArrayLike) -> SetPoints:
        """Inverse of `words`."""
        return cls(*np.split(np.asarray(words), (3, 6, 9, 11, 13), axis=1))


@dataclass(frozen=True)
class TrackingResult:
    """Every quantity of the tracking law: arrays over N ticks, or tuples for a single tick.

    Unless noted the last dimension holds the five axes (legs 1-3, tilt, rotation) and the units are
    m and N for legs, rad and N m for the table.
    """

    position_d: Any  # desired, (7), (18)
    velocity_d: Any  # desired, (8), (19)
    acceleration_d: Any  # desired, (9)-(11), (20)
    position: Any  # measured
    velocity: Any  # measured, difference over T_s or an observer's
    tool: Any  # x, y, z of the measured lengths, (14)-(15)
    e: Any
    e_v: Any
    sign: Any  # s_g, (35), (37)
    ticks: Any  # t_c / T_s, (33), saturated at T_c / T_s
    phi_c: Any  # (30)
    s_c: Any  # (29)
    m_z: Any  # one value per tick, (25)
    mass: Any  # M_11 .. M_33 (23), J_44, J_55
    gravity: Any  # G_1 .. G_3 (24), table (27)
    demand: Any  # (28), (36) before saturation
    output: Any  # F_1 .. F_3, tau_4, tau_5

    def row(self, name: str) -> NDArray[np.floating]:
        """One row of table 3 or one output by name, (N,). Raises KeyError for another name."""
        for names, values in (
            (POSITIONS, self.position_d),
            (VELOCITIES, self.velocity_d),
            (ACCELERATIONS, self.acceleration_d),
            (OUTPUTS, self.output),
        ):
            if name in names:
                return np.asarray(values)[..., names.index(name)]
        raise KeyError(name)


def checked_counts(counts: ArrayLike, ticks: int, columns: int = 5) -> NDArray[np.int32]:
    """Encoder counts as int32 (ticks, 5), with stamps (ticks, 10); raises ValueError for another
    type, shape or range."""
    counts = np.asarray(counts)
    if counts.shape != (ticks, columns):
        raise ValueError(f"counts have the shape {counts.shape}, must be {(ticks, columns)}")
    if not np.issubdtype(counts.dtype, np.integer):
        raise ValueError(f"counts have the type {counts.dtype}, must be integers")
    limits = np.iinfo(np.int32)
    if counts.size and (counts.min() < limits.min or counts.max() > limits.max):
        raise ValueError("counts do not fit in 32 bits")
    return counts.astype(np.int32)
