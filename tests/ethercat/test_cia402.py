# SPDX-License-Identifier: Apache-2.0
"""Drives of CiA 402: state machine, faults, stops, inputs and outputs.

Independent of us: python-canopen's masks of the statusword and its table of transitions.
"""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
from canopen import objectdictionary
from canopen.profiles.p402 import BaseNode402, State402
from canopen.sdo import SdoClient

from tests.ethercat.drives import (
    CSV,
    ENABLE,
    QUICK_STOP,
    RESET,
    SHUTDOWN,
    SWITCH_ON,
    TICK,
    Drives,
    state_of,
)
from tests.ethercat.host import AXES, ERROR, OP, PREOP, SAFEOP, Host

# -------------------------------------------------------------------- state machine

NUMBERS = {
    ("READY TO SWITCH ON", "SWITCH ON DISABLED"): 7,
    ("OPERATION ENABLED", "SWITCH ON DISABLED"): 9,
    ("SWITCHED ON", "SWITCH ON DISABLED"): 10,
    ("QUICK STOP ACTIVE", "SWITCH ON DISABLED"): 12,
    ("NOT READY TO SWITCH ON", "SWITCH ON DISABLED"): 1,
    ("START", "NOT READY TO SWITCH ON"): 0,
    ("FAULT REACTION ACTIVE", "FAULT"): 14,
    ("SWITCH ON DISABLED", "READY TO SWITCH ON"): 2,
    ("SWITCHED ON", "READY TO SWITCH ON"): 6,
    ("OPERATION ENABLED", "READY TO SWITCH ON"): 8,
    ("READY TO SWITCH ON", "SWITCHED ON"): 3,
    ("OPERATION ENABLED", "SWITCHED ON"): 5,
    ("SWITCHED ON", "OPERATION ENABLED"): 4,
    ("QUICK STOP ACTIVE", "OPERATION ENABLED"): 16,
    ("OPERATION ENABLED", "QUICK STOP ACTIVE"): 11,
    ("FAULT", "SWITCH ON DISABLED"): 15,
}

# Bits that count for a command, by the controlword python-canopen sends for it (CiA 402, table of
# the controlword). Not in its table: quick stop of a drive without power, transitions 7 and 10.
CARE = {0x00: 0x82, 0x02: 0x86, 0x06: 0x87, 0x07: 0x87, 0x0F: 0x8F}
DISABLE_OPERATION = 0x8F


def asked(state: str, word: int, edge: bool) -> set[str]:
    """States that the table of python-canopen leads to with this controlword."""
    found = set()
    for (before, after), command in State402.TRANSITIONTABLE.items():
        if before != state or before == "FAULT REACTION ACTIVE":
            continue
        if command == State402.CW_SWITCH_ON_DISABLED:
            leads = edge
        elif before == "NOT READY TO SWITCH ON":
            leads = True
        else:
            disables = (before, after) == ("OPERATION ENABLED", "SWITCHED ON")
            care = DISABLE_OPERATION if disables else CARE[command]
            leads = word & care == command & care
        if leads:
            found.add(after)
    if state in ("READY TO SWITCH ON", "SWITCHED ON") and word & 0x86 == QUICK_STOP:
        found.add("SWITCH ON DISABLED")
    if state == "SWITCHED ON" and "OPERATION ENABLED" in found:
        found.discard("SWITCHED ON")
    return found


def random_controlwords(words: int, seed: int) -> set[tuple[str, str]]:
    """Compare each step of the five axes with the table; the transitions that were seen."""
    rng = random.Random(seed)
    drives = Drives()
    for n in range(AXES):
        drives.put(0x605A + 0x800 * n, 0, 6)  # stays in quick stop active
    common = [0, 2, 6, 7, 0xF, 0x80, 0x8F]
    states = [drives.state(n) for n in range(AXES)]
    before = [0] * AXES
    seen = set()
    for count in range(words // AXES):
        words_now, faults = [], []
        for n in range(AXES):
            word = rng.choice(common) if rng.random() < 0.6 else rng.randrange(0x10000)
            words_now.append(word & ~0x100)  # halt is no transition
            faults.append(rng.random() < 0.02)
            drives.set(n, control=words_now[n])
            drives.feedback.axis[n].fault = 0x5441 if faults[n] else 0
        drives.step()
        inputs = drives.inputs()
        for n in range(AXES):
            now, word = state_of(inputs[0x6041 + 0x800 * n, 0]), words_now[n]
            edge = bool(word & 0x80 and not before[n] & 0x80)
            context = f"seed {seed}, step {count}, axis {n}: {states[n]} {word:04x} -> {now}"
            if states[n] == "FAULT REACTION ACTIVE" or faults[n] and states[n] == "FAULT":
                assert now == "FAULT", context  # no reset while the cause lasts
            elif faults[n]:
                # Without power the reaction has nothing to stop: 13 and 14 in one step.
                powered = states[n] in ("OPERATION ENABLED", "QUICK STOP ACTIVE")
                powered = powered or "OPERATION ENABLED" in asked(states[n], word, edge)
                assert now == "FAULT" or powered and now == "FAULT REACTION ACTIVE", context
            else:
                wanted = asked(states[n], word, edge)
                assert len(wanted) <= 1, (context, wanted)
                assert now == (wanted.pop() if wanted else states[n]), context
            if now != states[n]:
                seen.add((states[n], now))
            states[n], before[n] = now, word
    return seen


def test_random_controlwords__agree_with_the_table_of_canopen():
    seen = random_controlwords(10_000, 17)
    assert set(NUMBERS) == set(State402.TRANSITIONTABLE)
    # 0, 1 and 13, 14 of a drive with power: the tests below.
    missing = {n for edge, n in NUMBERS.items() if edge not in seen} - {0, 1, 14}
    assert not missing


@pytest.mark.full
def test_random_controlwords__hundred_thousand():
    random_controlwords(100_000, 2)


def transitions_one_by_one() -> set[int]:
    """Walk through all transitions of CiA 402; the numbers of those that the statuswords showed."""
    host = Host().to_safeop()
    states = [state_of(host.inputs()[0x6041, 0])]  # before the first cycle
    host.cycle()
    states.append(state_of(host.inputs()[0x6041, 0]))
    drives = Drives()
    drives.put(0x605A, 0, 6)
    drives.put(0x6085, 0, 1_000_000)
    path = [
        SHUTDOWN, SWITCH_ON, ENABLE, SWITCH_ON, SHUTDOWN, 0, SHUTDOWN, SWITCH_ON, ENABLE,
        SHUTDOWN, SWITCH_ON, 0, SHUTDOWN, SWITCH_ON, ENABLE, 0, SHUTDOWN, SWITCH_ON, ENABLE,
        QUICK_STOP, ENABLE, QUICK_STOP, 0, SHUTDOWN, SWITCH_ON, ENABLE,
    ]  # fmt: skip
    for control in path:
        drives.step(control=control)
        states.append(drives.state())
    drives.follow(100, velocity=1_000_000, mode=CSV)
    drives.feedback.axis[0].fault = 0x5441
    drives.step()
    states.append(drives.state())  # fault while it moves
    drives.feedback.axis[0].fault = 0
    drives.follow(12_000)
    states.append(drives.state())
    drives.step(control=RESET)
    states.append(drives.state())
    faulted = {(state, "FAULT REACTION ACTIVE"): 13 for state in states}  # not in canopen's table
    return {(NUMBERS | faulted)[edge] for edge in itertools.pairwise(states)}


def test_all_sixteen_transitions__one_by_one():
    assert transitions_one_by_one() == set(range(1, 17))


def test_node_of_canopen__brings_the_axis_to_every_state():
    host = Host().to_op()
    host.put(0x10F1, 2, 0)
    host.put(0x605A, 0, 6)

    class Line:
        def send_message(self, can_id, data, remote=False):
            answer = host.coe(2, bytes(data))
            host.outputs({(0x6040, 0): int(host.get(0x6040))})
            host.cycle()
            node.sdo.on_response(0x581, bytearray(answer[:8]), 0.0)

    od = objectdictionary.ObjectDictionary()
    for index, kind in ((0x6040, 6), (0x6041, 6), (0x6060, 2), (0x6061, 2)):
        variable = objectdictionary.ODVariable(str(index), index)
        variable.data_type = kind
        od.add_object(variable)
    node = BaseNode402(1, od)
    assert isinstance(node.sdo, SdoClient)
    node.sdo.network = Line()
    for state in (
        "READY TO SWITCH ON", "SWITCHED ON", "OPERATION ENABLED", "QUICK STOP ACTIVE",
        "OPERATION ENABLED", "SWITCHED ON", "SWITCH ON DISABLED",
    ):  # fmt: skip
        node.state = state
        assert node.state == state


def test_controlword__outside_of_op_moves_nothing():
    host = Host().to_preop()
    for control in (SHUTDOWN, SWITCH_ON, ENABLE):
        host.put(0x6040, 0, control)
        host.cycle(3)
    assert state_of(int(host.get(0x6041))) == "SWITCH ON DISABLED"
    assert not host.command.axis[0].power


# -------------------------------------------------------------------- faults, stops, I/O


def moving(option: int, value: int) -> Drives:
    velocity = 4_000_000
    drives = Drives(CSV)
    drives.put(option, 0, value)
    drives.enable(velocity=velocity)
    drives.follow(200)
    assert abs(drives.command.axis[0].velocity - velocity) < 1
    return drives


@pytest.mark.parametrize(
    ("option", "control", "value", "deceleration", "end"),
    [
        (0x605A, QUICK_STOP, 0, None, "SWITCH ON DISABLED"),
        (0x605A, QUICK_STOP, 1, 1e8, "SWITCH ON DISABLED"),
        (0x605A, QUICK_STOP, 2, 4e8, "SWITCH ON DISABLED"),
        (0x605A, QUICK_STOP, 5, 1e8, "QUICK STOP ACTIVE"),
        (0x605A, QUICK_STOP, 6, 4e8, "QUICK STOP ACTIVE"),
        (0x605B, SHUTDOWN, 0, None, "READY TO SWITCH ON"),
        (0x605B, SHUTDOWN, 1, 1e8, "READY TO SWITCH ON"),
        (0x605C, SWITCH_ON, 0, None, "SWITCHED ON"),
        (0x605C, SWITCH_ON, 1, 1e8, "SWITCHED ON"),
        (0x605E, None, 0, None, "FAULT"),
        (0x605E, None, 1, 1e8, "FAULT"),
        (0x605E, None, 2, 4e8, "FAULT"),
    ],
)
def test_stop__on_the_ramp_of_its_option_then_without_power(
    option, control, value, deceleration, end
):
    drives = moving(option, value)
    if control is None:
        drives.feedback.axis[0].fault = 0x5441
    else:
        drives.set(control=control)
    drives.outputs(drives.values)
    speeds = []
    for _ in range(600):
        drives.cycle()
        if drives.command.axis[0].power:
            speeds.append(drives.command.axis[0].velocity)
        drives.feedback.axis[0].fault = 0
        drives.outputs(drives.values)
    assert drives.state() == end
    if deceleration is None:
        assert len(speeds) <= 2
    else:
        ticks = 4_000_000 / (deceleration * TICK) + 1  # the first set-point has the axis' speed
        steps = -np.diff(speeds)[1:]
        assert np.abs(steps[: int(ticks) - 3] - deceleration * TICK).max() < 1
        if end != "QUICK STOP ACTIVE":
            assert abs(len(speeds) - ticks) < 4
    assert drives.command.axis[0].power == (end == "QUICK STOP ACTIVE")


def test_following_error__faults_after_its_time_out_with_code_and_emergency():
    drives = Drives()
    drives.put(0x6065, 0, 1000)
    drives.put(0x6066, 0, 5)
    drives.enable()
    drives.held.add(0)
    for k in range(100):
        drives.step(10, position=min(20 * k, 1100))
        if drives.state() == "FAULT":
            break
    assert drives.state() == "FAULT"
    inputs = drives.inputs()
    assert inputs[0x603F, 0] == 0x8611 and abs(inputs[0x60F4, 0]) <= 1100
    assert all(drives.state(n) != "FAULT" for n in range(1, AXES))
    kind, data = drives.receive()
    assert data[2:4] == b"\x11\x86" and data[5] == 0
    drives.step(2, control=RESET)
    assert drives.inputs()[0x603F, 0] == 0 and drives.upload(0x1001) == b"\0"


def test_master_that_dies__watchdog_quick_stop_fault_outputs_to_their_error_value():
    drives = Drives(CSV)
    drives.put(0x10F1, 2, 0)
    drives.put(0x8A07, 1, 0x5A)
    for n in range(AXES):
        drives.enable(n, velocity=3_000_000)
    drives.values[0x8A00, 1] = 0xFF
    drives.follow(100)
    assert drives.command.digital_outputs == 0xFF
    speeds = []
    for _ in range(1300):
        drives.cycle()
        speeds.append(drives.command.axis[4].velocity)
    assert drives.status == (SAFEOP | ERROR, 0x001B)
    for n in range(AXES):
        assert drives.state(n) == "FAULT" and not drives.command.axis[n].power
        assert drives.inputs()[0x603F + 0x800 * n, 0] == 0x7500
    assert drives.command.digital_outputs == 0x5A
    assert 0 in speeds and np.diff(speeds).min() >= -4e8 * TICK * 1.01  # the quick stop ramp
    # The way back: acknowledge, OP, reset of the fault.
    drives.step(control=RESET)
    assert drives.ask(OP | ERROR) == (OP, 0)
    drives.step(control=0)
    drives.step(control=RESET)
    assert drives.state() == "SWITCH ON DISABLED"


def test_lost_outputs__fault_before_the_watchdog_when_the_limit_says_so():
    drives = Drives()
    drives.put(0x10F1, 2, 4)
    drives.enable()
    drives.follow(100)
    drives.cycle(35)
    assert drives.state() == "OPERATION ENABLED"
    drives.cycle(25)
    assert drives.state() == "FAULT" and drives.status == (SAFEOP | ERROR, 0x001A)
    assert drives.inputs()[0x603F, 0] == 0x7500 and drives.get(0x1C32, 32) == 1


def test_op_left_on_request__quick_stop_without_a_fault():
    drives = moving(0x605A, 2)
    assert drives.ask(SAFEOP) == (SAFEOP, 0)
    rows = []
    for _ in range(200):
        drives.cycle()
        rows.append((drives.command.axis[0].velocity, drives.command.axis[0].power))
    assert rows[0][1] and not rows[-1][1]
    assert state_of(drives.inputs()[0x6041, 0]) == "SWITCH ON DISABLED"
    assert np.diff([v for v, _ in rows]).min() >= -4e8 * TICK * 1.01


@pytest.mark.parametrize("option", [0, 1, 2, 5, 6])
@pytest.mark.parametrize("state", [SAFEOP, PREOP])
def test_op_left__no_torque_after_the_stop_whatever_the_option(option, state):
    drives = moving(0x605A, option)
    assert drives.ask(state) == (state, 0)
    drives.cycle(500)
    assert not drives.command.axis[0].power
    assert state_of(int(drives.get(0x6041))) == "SWITCH ON DISABLED"


def test_inputs_and_outputs_of_the_device__in_the_axes_too():
    drives = Drives()
    drives.feedback.digital_inputs = 0xA5
    drives.values[0x8A00, 1] = 0x0F
    drives.step(2)
    assert drives.command.digital_outputs == 0x0F
    assert [drives.get(0x60FD + 0x800 * n) for n in range(AXES)] == [0xA50000] * AXES
    drives.put(0x70FE, 1, 0x12_0000)
    drives.step()
    assert drives.command.digital_outputs == 0x0F  # not in the mask
    drives.put(0x70FE, 2, 0x33_0001)
    drives.step()
    assert drives.command.digital_outputs == 0x1E
    drives.put(0x8A07, 1, 0x40)
    drives.ask(SAFEOP)
    drives.cycle()
    assert drives.command.digital_outputs == 0x40


def test_digital_inputs_and_outputs__eight_each_and_pose():
    drives = Drives()
    for value in (0x00, 0xA5, 0xFF):
        drives.values[0x8A00, 1] = value
        drives.feedback.digital_inputs = value ^ 0x3C
        drives.step()
        assert drives.command.digital_outputs == value
        assert drives.inputs()[0x8800, 1] == value ^ 0x3C
    drives.feedback.pose[2] = 0.25
    drives.step()
    assert drives.get(0x2010, 3) == 0.25


def test_gain_of_the_law__goes_to_the_law_at_once():
    drives = Drives()
    assert drives.command.setting_number == 0
    for n in range(AXES):
        drives.put(0x2001, n + 1, 100.0 + n)
    seen = []
    for _ in range(8):
        drives.step()
        found = drives.command
        seen.append((found.setting_number, found.setting_index, found.setting_subindex,
                     found.setting_value))  # fmt: skip
    assert seen[:5] == [(n + 1, 0x2001, n + 1, 100.0 + n) for n in range(AXES)]
    assert seen[-1] == seen[4]
