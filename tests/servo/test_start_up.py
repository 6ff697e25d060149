# SPDX-License-Identifier: Apache-2.0
"""Start-up and faults on the RTL of the chain, every clock: each ends in a defined state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sim.bench.drive import hardware, start_up
from sim.bench.drive import status as status_text
from sim.bench.drive.averaged import at_joints, true_angles, true_zeros
from sim.bench.drive.chain import ChainRtl, GuardedChain
from sim.bench.drive.plant import Plant
from sim.laws.drive.current_law import Setting
from sim.robot.drives import Drives
from sim.robot.parameters import Robot
from sim.rtl.asip_bus import CSR
from sim.rtl.gen.drive_regmap import REGMAP

ROBOT, DRIVES = Robot.load(), Drives.load()
SETTING, PLANT = Setting(ROBOT.resolution), Plant(ROBOT, DRIVES)
ALL = start_up.ALL
JOINTS = at_joints(PLANT, ROBOT.start)
MOST = [1e-4] * 3 + [1e-2] * 2  # following error [m, rad]


def brought_up(plant: Plant = PLANT, kind: type[ChainRtl] = ChainRtl) -> ChainRtl:
    """Configured, offsets measured, guards on; all gates off, brakes closed."""
    system = kind()
    counts = system.place(plant, ROBOT.start)
    start_up.configure(system, DRIVES, SETTING, counts)
    zeros = start_up.measure_offsets(system, 16)
    np.testing.assert_allclose(zeros, true_zeros(PLANT), atol=3)
    start_up.guard(system, ROBOT, DRIVES, SETTING)
    return system


def short(system: ChainRtl) -> None:
    """A winding with a fiftieth of its inductance swings beyond a limit of 5 A, ordered 2 A."""
    system.front("LINK")
    system.clock(1250)
    start_up.order(system, [300.0, 0.0, 0.0, 0.0, 0.0])
    system.front("LINK", enable=1)
    system.front("CURRENT_LIMIT", size=round(256 * 5.0 / DRIVES.current_scale))
    system.fault(DRIVES.U_dc, shorted=1)


# Fault -> what happens, axes that trip, flags of STATUS.
FAULTS = {
    "power stage": (lambda s: s.fault(DRIVES.U_dc, stage=2), 2, ()),
    "undervoltage": (lambda s: s.fault(300.0), ALL, ("undervoltage",)),
    "overvoltage": (lambda s: s.fault(1.16 * DRIVES.U_dc), ALL, ("overvoltage",)),
    "encoder": (lambda s: s.fault(DRIVES.U_dc, touching=4), 4, ("illegal",)),
    "overcurrent": (short, 1, ()),
    "watchdog": (lambda s: s.current.write(CSR["WATCHDOG"], 50), ALL, ("fault",)),
}


@pytest.mark.full
def test_faults__end_with_gates_off_and_brakes_closed_and_can_be_cleared():
    system = brought_up()
    watchdog = system.current.image.watchdog
    for name, (fault, axes, flags) in FAULTS.items():
        start_up.write_angles(system, true_angles(PLANT, JOINTS))
        start_up.enable(system)
        start_up.release(system)
        system.clock(1250)
        assert system.look().released == ALL, name
        assert start_up.supervise(system, JOINTS, ROBOT.resolution, MOST) == "", name
        fault(system)
        system.clock(30 * 1250)
        status = system.status()
        assert status["trip"] == axes, name
        assert all(status[flag] for flag in flags), name
        assert system.look().released == ALL & ~axes, name
        told = start_up.supervise(system, JOINTS, ROBOT.resolution, MOST)
        assert told.startswith(f"tripped: {status_text.named(axes)} ("), name
        assert all(f"{flag}: " in told for flag in flags if flag != "illegal"), name
        assert system.look().released == 0, name
        system.clock(1250)
        assert np.abs(system.look().i_q).max() < 0.1, "no gate, no current"
        system.fault(DRIVES.U_dc)
        system.current.write(CSR["WATCHDOG"], watchdog)
        system.clock(5000)
        start_up.recover(system)
    assert system.look().shoot_through == 0


@pytest.mark.full
def test_enabled_far_from_count_0__the_way_there_is_no_speed():
    """A start-up after a stop begins at any counts; the first samples must not look like motion."""
    system = brought_up()
    start_up.write_angles(system, true_angles(PLANT, JOINTS))
    far = np.array([20_000, -20_000, 10_000, 3_000, -6_000])
    share = np.arange(1, 4001)[:, None] / 4000  # slowly: two counts at once would trip
    system.travel(JOINTS + share * far * ROBOT.resolution)
    system.clock(4002 * 1250)
    counts = start_up.positions(system)
    assert (np.abs(counts - far) <= 1).all()
    start_up.enable(system)
    assert (currents(system, 100) < 0.001).all()
    assert start_up.told(system.status()) == ""


def test_linked__counts_have_the_sign_of_their_low_bits():
    most = 1 << 22
    counts = np.array([0, -1, most - 1, most, -most, -most - 1, 5 * most])
    assert start_up.linked(counts).tolist() == [0, -1, most - 1, -most, -most, most - 1, -most]


def test_configured__build_and_registers_are_what_the_limits_of_parameters_say():
    system = brought_up()
    config = system.read_front("CONFIG")
    built = {name: f.of(config) for name, f in REGMAP.registers["CONFIG"].fields.items()}
    assert built["bit_clocks"] == hardware.BIT_CLOCKS
    assert built["least_dead_time"] == hardware.LEAST_DEAD_TIME
    assert 2 ** (3 * built["fast_log2"] - 1) == start_up.FAST_FULL_SCALE
    strongest = max(motor.i_max for motor in DRIVES.motors)
    limit = system.read_front("CURRENT_LIMIT") * DRIVES.current_scale / start_up.FAST_FULL_SCALE
    assert strongest < limit < DRIVES.current_scale
    assert system.read_front("DEAD_TIME") * start_up.CLOCK == pytest.approx(DRIVES.dead_time)


def test_brake_chopper__is_on_before_the_trip_and_off_at_the_bus_voltage():
    system = brought_up()
    for volts, on in ((1.0, 0), (1.08, 0), (1.12, 1), (1.08, 1), (1.0, 0)):
        system.fault(volts * DRIVES.U_dc)
        system.clock(3)
        assert system.look().chopper == on == system.status()["chopper"], volts
        assert not system.status()["trip"], volts


def turning(share: float, kind: type[ChainRtl] = ChainRtl) -> ChainRtl:
    """A test bench turns all motors, and the host orders a share of the greatest force of each."""
    system = brought_up(kind=kind)
    start_up.write_angles(system, true_angles(PLANT, JOINTS))
    start_up.order(system, [0.0] * 5)
    system.front("LINK", enable=1)
    system.clock(3 * 1250)
    system.front("MODE", **start_up.RUN)
    system.spin([0.1] * 3 + [0.4] * 2)
    start_up.order(system, [share * m.i_max * m.force_per_ampere for m in DRIVES.motors])
    system.clock(5 * 12_500)
    assert start_up.told(system.status()) == ""
    return system


def currents(system: ChainRtl, halves: int) -> np.ndarray:
    """Greatest currents (5,) in so many half periods, as shares of `i_max`."""
    most = np.zeros(5)
    for _ in range(halves):
        system.clock(1250)
        seen = system.look()
        most = np.maximum(most, np.hypot(seen.i_d, seen.i_q))
    return most / [motor.i_max for motor in DRIVES.motors]


def test_open_phases_and_dead_sensors__trip_their_axes_below_twice_the_rated_current():
    """Leg 1 and the rotation lose a sensor, leg 2 and the tilt a phase, leg 3 nothing."""
    system = turning(0.5)
    system.sensors(stuck={0: 1, 1: 16}, broken=2 << 5 | 8 << 10)
    most = currents(system, 150)
    status = system.status()
    assert status["trip"] == status["plausible"] == ALL & ~4
    assert (most < 2).all() and most[2] == pytest.approx(0.5, abs=0.02)
    assert "leg 1, leg 2, tilt, rotation: a phase had voltage" in start_up.told(status)
    system.sensors()
    system.front("LINK")
    start_up.recover(system)


def test_counts_that_are_lost__trip_by_the_index_before_a_hundredth_of_the_speed_is_lost():
    """One count of 500 is lost by leg 2, whose lines then also do not meet at the index."""
    system = turning(0.1)
    for speed in (0.2, 0.3, 0.4, 0.5):  # a jump of the speed would be one of the lines
        system.spin([speed] * 3 + [3 * speed] * 2)
        system.clock(100 * 1250)
    assert start_up.told(system.status()) == ""
    before = start_up.positions(system)
    system.slip(2, 500)
    for _ in range(700):
        system.clock(1250)
        status = system.status()
        if status["trip"]:
            break
    assert status["trip"] == status["index_lost"] == 2
    assert "leg 2: its encoder's index was elsewhere or missing" in start_up.told(status)
    counted = np.abs(start_up.positions(system) - before)[1]
    assert start_up.INDEX_TOLERANCE < counted / 500 < 3 * start_up.INDEX / 500


@pytest.mark.full
def test_sensors_that_drift__trip_with_a_third_sensor_in_two_samples():
    """Each sensor in turn shows 1 A too much, or nothing; without a fault the sum is small."""
    system = turning(0.9, GuardedChain)
    assert REGMAP.registers["CONFIG"].fields["third_sensor"].of(system.read_front("CONFIG")) == 1
    for phase in range(3):
        drift = np.zeros((5, 3))
        drift[phase, phase] = 1.0
        system.sensors(drift=drift, stuck={phase: 16})
        most = currents(system, 3)
        status = system.status()
        assert status["trip"] == status["sum"] == 1 << phase | 16, phase
        assert (most < 1).all()
        assert "rotation: the sum of its currents was not 0" in start_up.told(status)
        system.sensors()
        system.clock(2500)
        system.front("MODE")
        start_up.recover(system)
        system.front("MODE", **start_up.RUN)
        system.clock(12_500)
        assert start_up.told(system.status()) == ""


def test_offset_of_a_sensor_before_the_start__is_refused():
    system = ChainRtl()
    start_up.configure(system, DRIVES, SETTING, system.place(PLANT, ROBOT.start))
    drift = np.zeros((5, 3))
    drift[3, 1] = 0.2  # with the sensor's own 0.02 A below a 128th of 32 A
    system.sensors(drift=drift)
    start_up.measure_offsets(system, 4)
    drift[3, 1] = 0.3
    system.sensors(drift=drift)
    with pytest.raises(start_up.StartUpError, match="axis 4, current b without gates: "):
        start_up.measure_offsets(system, 4)


def test_limits_of_plausible_currents__between_motion_and_twice_the_current():
    volts, persist = start_up.plausible_limits(ROBOT, DRIVES)
    speeds = [ROBOT.v_max_leg] * 3 + [ROBOT.v_max_table] * 2
    for limit, motor, speed in zip(volts, DRIVES.motors, speeds, strict=True):
        assert speed * motor.wave * motor.psi < limit < 2 * motor.R * motor.i_max
    assert 1 < persist < 2**8
    fast, quick = start_up.plausible_limits(replace(ROBOT, v_max_leg=1.2), DRIVES)
    assert fast[:3] == [0, 0, 0] and fast[3:] == volts[3:] and quick <= persist


def test_following_error__stops_all_axes():
    system = brought_up()
    start_up.write_angles(system, true_angles(PLANT, JOINTS))
    start_up.enable(system)
    start_up.release(system)
    away = [*JOINTS[:4], JOINTS[4] + 0.02]
    found = start_up.supervise(system, away, ROBOT.resolution, MOST)
    assert found == "following error of axis 5: 0.02"
    system.clock(10)
    assert system.look().released == 0
    assert system.read_front("MODE") == 0 and system.read_front("LINK") == 0


def test_cause_that_is_still_there__is_not_cleared():
    system = brought_up()
    system.fault(300.0)
    with pytest.raises(start_up.StartUpError, match=r"tripped: leg 1, .*undervoltage: .*check"):
        start_up.recover(system)


def off_by(angles: np.ndarray, plant: Plant) -> float:
    """Largest distance from the true angles [degrees]."""
    off = angles - np.array(true_angles(plant, JOINTS))
    return float(np.degrees(np.abs((off + np.pi) % (2 * np.pi) - np.pi)).max())


@pytest.mark.full
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_alignment__finds_any_electrical_angles_against_the_brakes(seed):
    turns = np.random.default_rng(seed).uniform(-np.pi, np.pi, 5)
    plant = replace(PLANT, angle=tuple(turns.tolist()))
    system = brought_up(plant)
    assert off_by(start_up.align(system, DRIVES, SETTING), plant) < 3.0
    assert not system.status()["trip"]


def moves(angles: np.ndarray, size: float) -> np.ndarray:
    """Counts of a brake that bends by the cosine, around an offset."""
    return np.round(size * np.cos(np.subtract.outer(start_up.DIRECTIONS, angles)) + 30)


def test_alignment__fit_of_whole_counts():
    true = np.linspace(-3.1, 3.1, 50)
    angles, size, off = start_up.fitted_angles(start_up.DIRECTIONS, moves(true, 20.0))
    assert np.degrees(np.abs((angles - true + np.pi) % (2 * np.pi) - np.pi)).max() < 2.0
    assert np.abs(size - 20).max() < 1.0 and off.max() < 1.0


@pytest.mark.parametrize(
    ("size", "stuck", "message"),
    [(2.0, 0, "axis 1, under .* moved by .* check motor, encoder"), (20.0, 20, "off a sine")],
)
def test_alignment__a_motor_that_does_not_answer_as_one_is_refused(
    size, stuck, message, monkeypatch
):
    """Counts made up in place of the encoders': too few, and a joint that sticks once."""
    system = brought_up()
    rows = moves(np.zeros(5), size).astype(np.int64)
    rows[1] += stuck
    rest = np.zeros(5, dtype=np.int64)
    found = iter([rest, rest, *rows])
    monkeypatch.setattr(start_up, "positions", lambda system: next(found))
    monkeypatch.setattr(start_up, "SETTLE", 1e-5)  # no motor has to come to rest
    with pytest.raises(start_up.StartUpError, match=message):
        start_up.align(system, DRIVES, SETTING, dwell=1e-5)


@pytest.mark.parametrize("counts", [-1, (1 << 22) + 1])
def test_guard__index_that_the_hardware_cannot_check__is_refused(counts):
    class Silent:
        """A chain that nothing may be written to."""

    index = [4096, counts, 4096, 4096, 4096]
    with pytest.raises(start_up.StartUpError, match="axis 2: .* expected 1 to 4194304"):
        start_up.guard(Silent(), ROBOT, DRIVES, SETTING, index)
