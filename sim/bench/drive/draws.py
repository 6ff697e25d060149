# SPDX-License-Identifier: Apache-2.0
"""What another draw of the modulators' noise changes in the currents of the RTL.

The RTL of the current loops takes the orders and the motion of a recording again, as averaged
inverters do in `sample.same_currents`, with modulators that begin elsewhere: their bits, and so the
noise of the sensed currents, are others from then on, and nothing else is. What was simulated is
cached like a recording.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from asip_asm.files import replaced
from asip_asm.project import BUILD
from sim.bench.drive import start_up
from sim.bench.drive.chain import ORDER_FILTER, ChainRtl, current_program
from sim.bench.drive.plant import AXES, Plant
from sim.bench.drive.recording import Recording, path_and_moves
from sim.bench.drive.response import RAMP, ahead, record
from sim.bench.drive.sample import BEFORE, SKIP, per_tick
from sim.laws.drive.clocks import HALF_PERIOD
from sim.laws.drive.current_law import Setting
from sim.report.cache import fingerprint
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.rtl.processes import processes

SEEDS = (1, 2)
SOURCES = ("chain.py", "draws.py", "response.py", "start_up.py")


def replay(
    robot: Robot, drives: Drives, rtl: Recording, at: Sequence[float], ticks: int, seed: int
) -> NDArray[np.float64]:
    """i_q (ticks, 5) [A], means of a tick, with a recording's orders and motion, the first tick's
    beginning with its half period `BEFORE`; at: (x, y, z [m], tilt, rotation [rad]) of count 0;
    seed: of the draw. Raises StartUpError."""
    system, setting = ChainRtl(), Setting(robot.resolution, order_filter=ORDER_FILTER)
    start_up.configure(system, drives, setting, system.place(Plant(robot, drives), at))
    system.modulators(np.random.default_rng(seed).uniform(-1, 1, (AXES, 2)))
    start_up.write_zeros(system, rtl.zeros)
    start_up.write_angles(system, rtl.angles)
    places = rtl.halves["position"][BEFORE - 2 :]
    joints = system.look().joints
    share = np.arange(1, RAMP + 1)[:, None] / RAMP  # slowly: two counts at once would trip
    system.travel(joints + share * (places[0] - joints))
    system.clock((RAMP + 1) * HALF_PERIOD)
    start_up.order(system, rtl.commands[0])
    system.front("LINK", enable=1)
    system.clock(3 * HALF_PERIOD)
    system.front("MODE", **start_up.RUN)
    orders = np.repeat(rtl.commands, 10, axis=0)[: 10 * ticks + 1]
    ahead(system)
    system.travel(places[1 : len(orders) + 2])
    found = record(system, system.current.input_addresses(start_up.FORCES), orders)
    return per_tick(found["i_q"][1:])


def apart(robot: Robot, drives: Drives, rtl: Recording, ticks: int) -> NDArray[np.float64]:
    """Difference (ticks - `SKIP`, 5) of i_q [A] between two draws, means of a tick: the ticks and
    means of `sample.same_currents`. Raises StartUpError."""
    places = [_place(robot, drives, rtl, ticks, seed) for seed in SEEDS]
    with processes(len(SEEDS)) as pool:
        for work in [
            pool.submit(_keep, place, robot, drives, rtl, ticks, seed)
            for place, seed in zip(places, SEEDS, strict=True)
            if not place.exists()
        ]:
            work.result()
    one, other = (np.load(place) for place in places)
    return (one - other)[SKIP:]


def _keep(place: Path, robot: Robot, drives: Drives, rtl: Recording, ticks: int, seed: int) -> None:
    path, _ = path_and_moves(robot, 1)
    at = (*path.position[0].tolist(), *path.table_position[0].tolist())
    with replaced(place) as draft:
        np.save(draft, replay(robot, drives, rtl, at, ticks, seed))


def _place(robot: Robot, drives: Drives, rtl: Recording, ticks: int, seed: int) -> Path:
    """File that keeps a draw; another for anything that changes it."""
    setting = Setting(robot.resolution, order_filter=ORDER_FILTER)
    image, record = current_program(drives, setting).image, Plant(robot, drives).record().tolist()
    parts = (rtl.joints, rtl.commands, rtl.halves["position"], rtl.angles, rtl.zeros)
    replayed = [part.tobytes() for part in parts]
    files = [Path(__file__).with_name(name) for name in SOURCES]
    system = ChainRtl().library.parent.name
    of = fingerprint(files, system, image, record, ticks, seed, replayed)
    return BUILD / "servo" / f"draw_{seed}_{of}.npy"
