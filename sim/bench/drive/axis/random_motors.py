# SPDX-License-Identifier: Apache-2.0
"""Random motors that a person might have on the table, rotary and linear, each as its file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from sim.bench.drive.axis.motor_file import MotorFileError, OneMotor, load

SEED = 39
BUSES = (48.0, 96.0, 320.0, 560.0)
LINEAR_SHARE = 0.3


def text(rng: np.random.Generator) -> str:
    """A file: voltages and currents first, the rest in proportion to them."""

    def between(low: float, high: float) -> float:
        return float(math.exp(rng.uniform(math.log(low), math.log(high))))

    linear = rng.random() < LINEAR_SHARE
    bus, rated = float(rng.choice(BUSES)), between(2, 20)
    circle = bus / math.sqrt(3)
    resistance = between(0.04, 0.25) * circle / rated
    inductance, saliency = resistance * between(0.6e-3, 8e-3), rng.uniform(1.0, 1.4)
    flux = 0.6 * circle / between(500, 3000)
    pole = between(0.02, 0.06) if linear else 2 * math.pi / int(rng.integers(2, 13))
    wave = 2 * math.pi / pole
    force = 1.5 * wave * flux * rated
    inertia = force * between(0.008, 0.2) / (600 / wave)
    counts = between(1000, 200_000) / pole * (1 if linear else 2 * math.pi)
    current = rng.uniform(3500, 6000)
    values = {
        "R": resistance,
        "L_d": inductance,
        "L_q": inductance * saliency,
        "flux": flux,
        "pole_pitch" if linear else "pole_pairs": pole / 2 if linear else round(2 * math.pi / pole),
        "mass" if linear else "inertia": inertia,
        "rated_current": rated,
        "bus_voltage": bus,
        "encoder_counts": round(counts),
        "current_bandwidth": current,
        "velocity_bandwidth": between(20, 100),
        "friction": force * between(0.005, 0.05),
        "viscous": force * rng.uniform(0, 0.05) / (600 / wave),
        "cogging": force * rng.uniform(0, 0.02),
    }
    if linear:
        values["travel"] = pole * rng.uniform(5, 20)
    lines = [f'type = "{"linear" if linear else "rotary"}"']
    lines += [f"{name} = {value:.5g}" for name, value in values.items()]
    return "\n".join(lines) + "\n"


def motors(folder: Path, count: int, seed: int = SEED) -> Iterator[tuple[Path, OneMotor]]:
    """The first motors of a seed that a drive can run: their files in a folder, as read."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    found = 0
    while found < count:
        file = folder / f"motor_{found + 1}.toml"
        file.write_text(text(rng), encoding="utf-8")
        try:
            one = load(file)
        except MotorFileError:
            continue  # too little inductance for the bus, for instance
        found += 1
        yield file, one
