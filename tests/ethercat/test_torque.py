# SPDX-License-Identifier: Apache-2.0
"""Torque, its offset and the law's gains from the master's words to the robot: the application in C
on this machine, the law on the ASIP, the plant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from sim.bus.forces import along_axes, directions, with_torques
from sim.bus.gains import GainError, Gains
from sim.bus.machine import AXES, PROGRAM, Machine
from sim.bus.path_run import TICKS, Drive
from sim.bus.session import CSP, ENABLE, SHUTDOWN, SWITCH_ON, inputs, outputs
from sim.robot.parameters import Robot
from sim.robot.plant import Plant
from sim.robot.tracking import Tracking
from tests.ethercat.host import DEVICE, Host
from tests.ethercat.test_path import HostLink

ROBOT = Robot.load(None)
POSE = (0.03, -0.02, 0.6, 0.1, -0.2)
CST = 10
X, Z, TILT, ROTATION = 0, 2, 3, 4
NEAR = 1e-5  # of the greatest outputs


class Rig(Drive):
    """A master's cycles of 1 ms with a device whose plant may differ from the law's robot."""

    def __init__(self, plant: Robot = ROBOT) -> None:
        self.host = Host().to_op()
        super().__init__(HostLink(self.host), DEVICE, Machine(ROBOT, DEVICE, POSE))
        self.machine.plant = Plant(plant, POSE[:3], POSE[3:])
        self.targets = np.rint(np.array(POSE) / self.machine.increments).astype(int)
        self.poses: list[np.ndarray] = []

    def tick(self) -> None:
        super().tick()
        self.poses.append(np.array((*self.machine.plant.tool, *self.machine.plant.table)))

    def run(
        self,
        cycles: int,
        control: int = ENABLE,
        modes: Sequence[int] = (CSP,) * AXES,
        step: Sequence[int] = (0,) * AXES,
        **values: Sequence[int],
    ) -> dict[str, list[int]]:
        """So many cycles, targets moving by `step` increments in each; the last inputs."""
        for _ in range(cycles):
            self.targets = self.targets + np.array(step)
            targets = self.targets.tolist()
            words = {"controlword": control, "mode": list(modes), "target_position": targets}
            data = outputs(DEVICE, words | values)
            back = self.session.cycle(data, TICKS, self.tick)
        return inputs(DEVICE, back)

    def power_on(self, **values: Sequence[int]) -> None:
        for control in (SHUTDOWN, SWITCH_ON, ENABLE):
            self.run(3, control, **values)


class Listener:
    """What the law got and gave in each tick: set-points (15,), counts (5,), outputs (5,)."""

    def __init__(self, machine: Machine) -> None:
        self.step = machine._law.step
        self.ticks: list[tuple[np.ndarray, tuple[int, ...], np.ndarray]] = []
        machine._law.step = self

    def __call__(self, words, counts):
        result = self.step(words, counts)
        self.ticks.append((np.float32(words).astype(float), counts, result.outputs[0]))
        return result

    def differ_from(self, robot: Robot) -> float:
        """Largest difference to the law in double precision, of the greatest outputs; the first
        tick is that which makes the measurement the last one."""
        law = Tracking(robot)
        law.step(*self.ticks[0][:2])
        law._integrators = Tracking(robot)._integrators
        found = [law.step(words, counts).output - out for words, counts, out in self.ticks[1:]]
        return float((np.abs(found) / ROBOT.output_max).max())


def with_gains(**gains: tuple[float, ...]) -> Robot:
    """The robot with gains that no bandwidth gives."""
    robot = replace(ROBOT)
    robot.__dict__.update(gains)  # cached properties
    return robot


def of_axis(axis: int, value: int, others: int = 0) -> list[int]:
    return [value if n == axis else others for n in range(AXES)]


def slope(values: np.ndarray, ticks: int) -> float:
    """Acceleration of a way over ticks, by a parabola."""
    t = np.arange(ticks) * ROBOT.T_s
    return 2 * np.polyfit(t, values[-ticks:], 2)[0]


def expected(axis: int, per_mille: int) -> float:
    """Acceleration while the law holds the other axes, friction of full speed: (24), (26), (27)."""
    if axis == ROTATION:
        return (per_mille / 1000 * ROBOT.tau_max_5 - ROBOT.friction_table) / ROBOT.J_55
    along = directions(ROBOT, POSE[:3])[axis]
    lengths = [math.dist((*leg, 0.0), POSE[:3]) for leg in ROBOT.legs]
    across = [(ROBOT.J_a + ROBOT.m_s * (n - ROBOT.l_c) ** 2) / n**2 for n in lengths]
    mass = ROBOT.m_p + sum(
        ROBOT.m_s * w * w + p * (1 - w * w) for w, p in zip(along, across, strict=True)
    )
    return (per_mille / 1000 * ROBOT.F_max - ROBOT.friction_legs * np.abs(along).sum()) / mass


@pytest.mark.parametrize(("axis", "torque"), ((X, 30), (ROTATION, 40)))
def test_cst__moves_one_axis_with_the_acceleration_of_its_torque(axis: int, torque: int):
    rig = Rig()
    rig.power_on()
    rig.run(20)
    begin = len(rig.poses)
    back = rig.run(40, modes=of_axis(axis, CST, CSP), target_torque=of_axis(axis, torque))
    ways = np.array(rig.poses)
    assert slope(ways[:, axis], 200) == pytest.approx(expected(axis, torque), rel=0.03)
    others = [n for n in range(AXES) if n != axis]
    assert np.abs(ways[begin:, others] - ways[begin, others]).max() < 30e-6
    assert back["torque_actual"][axis] == torque
    assert back["error_code"] == [0] * AXES


def speeds_of(rig: Rig, axis: int, begin: int) -> np.ndarray:
    """True speeds in each tick from this one on, increments/s."""
    ways = np.array(rig.poses)[begin:, axis]
    return np.diff(ways) / ROBOT.T_s / rig.machine.increments[axis]


@pytest.mark.parametrize(
    ("axis", "torque", "most", "cycles"),
    [(X, 60, 5_000_000, 80), (ROTATION, -100, 10_000_000, 150), (Z, 0, 3_000_000, 100)],
)
def test_cst__no_axis_is_faster_than_the_limit(axis, torque, most, cycles):
    """Driven by its torque, and z by its weight; the law takes torque away, or brakes."""
    rig = Rig()
    rig.power_on()
    rig.run(10)
    rig.host.put(0x607F + 0x800 * axis, 0, most)
    begin = len(rig.poses)
    modes, torques = of_axis(axis, CST, CSP), of_axis(axis, torque)
    back = rig.run(cycles, modes=modes, target_torque=torques)
    speeds = np.abs(speeds_of(rig, axis, begin))
    assert speeds.max() < 1.02 * most
    assert speeds[-100:].mean() == pytest.approx(most, rel=0.005)
    assert back["statusword"][axis] & 0x0800 and back["error_code"] == [0] * AXES
    assert abs(rig.host.get(0x606B + 0x800 * axis)) == most
    others = [n for n in range(AXES) if n != axis]
    assert np.abs(np.array(rig.poses)[begin:, others] - rig.poses[begin][others]).max() < 30e-6
    rig.host.put(0x607F + 0x800 * axis, 0, 2 * most)
    begin = len(rig.poses)
    rig.run(30, modes=modes, target_torque=torques)
    assert np.abs(speeds_of(rig, axis, begin)).max() > 1.1 * most, "the limit was the cause"


def test_cst__torque_that_brakes_acts_at_the_limit_at_once():
    rig = Rig()
    rig.power_on()
    rig.host.put(0x607F + 0x800 * ROTATION, 0, 5_000_000)
    modes = of_axis(ROTATION, CST, CSP)
    back = rig.run(100, modes=modes, target_torque=of_axis(ROTATION, 100))
    assert back["statusword"][ROTATION] & 0x0800
    back = rig.run(20, modes=modes, target_torque=of_axis(ROTATION, -40))
    wanted = -expected(ROTATION, 40) - 2 * ROBOT.friction_table / ROBOT.J_55
    assert slope(np.array(rig.poses)[:, ROTATION], 180) == pytest.approx(wanted, rel=0.03)
    assert back["torque_actual"][ROTATION] == -40


def test_cst__stays_where_it_is_without_torque_and_csp_goes_on_from_there():
    rig = Rig()
    rig.power_on()
    rig.run(30)
    before = rig.poses[-1][ROTATION]
    rig.run(50, modes=of_axis(ROTATION, CST, CSP))
    rig.run(50)
    ways = np.array(rig.poses)[-1000:, ROTATION]
    assert np.abs(ways - before).max() < 5e-5


def test_cst__to_csp_on_the_way_without_a_jump():
    rig = Rig()
    rig.power_on()
    modes = of_axis(ROTATION, CST, CSP)
    back = rig.run(30, modes=modes, target_torque=of_axis(ROTATION, 40))
    back = rig.run(5, modes=modes, target_torque=of_axis(ROTATION, 4))  # that of friction
    speed = back["velocity_actual"][ROTATION] // 1000  # increments in a cycle
    assert speed > 500
    lead = round(2.7 * speed)  # what a target comes late, and the inputs are old
    rig.targets[ROTATION] = back["position_actual"][ROTATION] + lead
    switched = len(rig.poses)
    rig.run(60, step=of_axis(ROTATION, speed))
    ways = np.array(rig.poses)[switched - 50 :, ROTATION]
    rates = np.diff(ways) / ROBOT.T_s
    assert np.abs(rates / rates[0] - 1).max() < 0.1  # the speed goes on
    assert np.abs(np.diff(rates)).max() / ROBOT.T_s < 2 * ROBOT.a_max_table
    assert rig.run(1, step=of_axis(ROTATION, speed))["error_code"] == [0] * AXES


def test_cst__the_integrator_stays_where_it_is():
    rig = Rig()
    rig.power_on()
    rig.run(20)
    modes, torque = of_axis(ROTATION, CST, CSP), of_axis(ROTATION, 40)
    rig.run(2, modes=modes, target_torque=torque)
    integral = [rig.machine._law._program.read("integral5")]
    for _ in range(2):
        rig.run(20, modes=modes, target_torque=torque)
        integral.append(rig.machine._law._program.read("integral5"))
    assert max(integral) - min(integral) < 1e-5 * ROBOT.K_I[ROTATION] * ROBOT.s_max_table


def sag(plant: Robot, offset: int) -> float:
    """Largest error of z [m] after power, when the tool is heavier than the law thinks."""
    rig = Rig(plant)
    rig.power_on(torque_offset=of_axis(Z, offset))
    rig.run(100, torque_offset=of_axis(Z, offset))
    return float(np.abs(np.array(rig.poses)[:, Z] - POSE[Z]).max())


def test_torque_offset__takes_an_error_of_the_model_away():
    heavier = 6.0
    offset = round(1000 * heavier * ROBOT.g / ROBOT.F_max)
    plant = replace(ROBOT, m_p=ROBOT.m_p + heavier)
    without, with_offset, wrong = (sag(plant, n) for n in (0, offset, -offset))
    assert with_offset < 0.1 * without
    assert wrong > 1.5 * without


def test_gain__written_by_the_master_is_that_of_the_law():
    rig = Rig()
    listener = Listener(rig.machine)
    gains = {0x2000: 90_000.0, 0x2001: 150.0, 0x2002: 400_000.0}
    for index, axis in ((0x2000, X), (0x2001, ROTATION), (0x2002, TILT)):
        rig.host.put(index, axis + 1, gains[index])
    rig.run(3)
    rig.power_on()
    rig.run(30, step=(2000, -1000, 1000, 500, 800))
    position, speed, integral = gains.values()
    right = {
        "K_P": (position,) * 3 + ROBOT.K_P[3:],
        "K_V": ROBOT.K_V[:3] + (speed,) * 2,
        "K_I": ROBOT.K_I[:3] + (integral,) * 2,
    }
    assert rig.machine.refused == []
    near = listener.differ_from(with_gains(**right))
    assert near < NEAR
    for name in right:
        own = right | {name: getattr(ROBOT, name)}
        assert listener.differ_from(with_gains(**own)) > 30 * near, name


def test_gain__of_zero_gives_the_laws_own_back():
    rig = Rig()
    rig.host.put(0x2000, 1, 90_000.0)
    rig.host.put(0x2000, 1, 0.0)
    rig.run(2)
    listener = Listener(rig.machine)
    rig.power_on()
    rig.run(10, step=(2000, -1000, 1000, 500, 800))
    assert listener.differ_from(ROBOT) < NEAR


def test_gain__of_the_integral_stiffens_the_axis():
    heavier = replace(ROBOT, m_4=ROBOT.m_4 + 20.0)
    left = []
    for gain in (0.0, 3.0):
        rig = Rig(heavier)
        if gain:
            rig.host.put(0x2002, TILT + 1, gain * ROBOT.K_I[TILT])
        rig.power_on()
        rig.run(30)
        left.append(abs(rig.poses[-1][TILT] - POSE[TILT]))
    assert left[1] < 0.5 * left[0]


def test_gain__that_is_no_number_is_refused_and_the_old_one_kept():
    rig = Rig()
    rig.machine._take_setting(np.array((1, 0x200101, 0x7F800000), np.uint32))  # infinite
    assert len(rig.machine.refused) == 1
    listener = Listener(rig.machine)
    rig.power_on()
    rig.run(10, step=(2000, -1000, 1000, 500, 800))
    assert listener.differ_from(ROBOT) < NEAR


def test_gains__of_a_program_without_them_are_refused(tmp_path):
    image = Rig().machine._law.image
    source = tmp_path / PROGRAM.name
    source.write_text("; nothing")
    with pytest.raises(GainError, match="0 constants KP_legs"):
        Gains(source, image, ROBOT.values()).change(0x2000, 1, 1.0)


def test_forces__of_legs_and_axes_do_the_same_work():
    random = np.random.default_rng(4)
    law = random.uniform(-90, 90, AXES)
    torques = np.array((10.0, -20.0, 5.0, 30.0, -40.0))
    nobody = np.zeros(AXES, bool)
    both = with_torques(ROBOT, POSE[:3], law, torques, nobody)
    added = (along_axes(ROBOT, POSE[:3], part) for part in (both, law))
    assert np.subtract(*added) == pytest.approx(torques / 1000 * ROBOT.output_max)
    # A small way of the tool: what the legs do is what the axes do.
    way = 1e-6 * random.normal(size=3)
    lengths = [
        np.array([math.dist((*leg, 0.0), place) for leg in ROBOT.legs])
        for place in (np.array(POSE[:3]), POSE[:3] + way)
    ]
    assert (lengths[1] - lengths[0]) @ law[:3] == pytest.approx(
        along_axes(ROBOT, POSE[:3], law)[:3] @ way, rel=1e-4
    )
    alone = np.array((True, False, False, False, True))
    own = along_axes(ROBOT, POSE[:3], with_torques(ROBOT, POSE[:3], law, torques, alone))
    assert own[0] == pytest.approx(0.01 * ROBOT.F_max)
    assert own[1] == pytest.approx(along_axes(ROBOT, POSE[:3], law)[1] - 0.02 * ROBOT.F_max)
    assert own[4] == pytest.approx(-0.04 * ROBOT.tau_max_5)
