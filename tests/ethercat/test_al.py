# SPDX-License-Identifier: Apache-2.0
"""State machine of the application layer: every change, every check, every status code."""

from __future__ import annotations

import itertools
import struct

import pytest

from sim.bus.gen import esc_regmap
from sim.bus.gen.esc_regmap import AL_CONTROL, AL_STATUS
from tests.ethercat import managers
from tests.ethercat.host import BOOT, DEVICE, ERROR, INIT, OP, PREOP, SAFEOP, Host


def in_state(state: int) -> Host:
    host = Host()
    {
        INIT: lambda: None,
        PREOP: host.to_preop,
        BOOT: host.to_boot,
        SAFEOP: host.to_safeop,
        OP: host.to_op,
    }[state]()
    return host


@pytest.mark.parametrize(
    ("state", "wanted"),
    list(itertools.product((INIT, PREOP, BOOT, SAFEOP, OP), repeat=2)),
)
def test_every_change__as_the_standard_allows(state, wanted):
    host = in_state(state)
    if wanted == OP and state == SAFEOP:
        host.outputs()
        host.cycle()
    found = host.ask(wanted)
    if state == wanted or (state, wanted) == (BOOT, INIT):
        assert found == (wanted, 0)
    elif (state, wanted) == (INIT, BOOT):
        assert found == (INIT | ERROR, 0x0015)  # the mailbox was not set up
    elif BOOT in (state, wanted):
        assert found == (state | ERROR, 0x0011)
    elif wanted > state and (state, wanted) not in ((INIT, PREOP), (PREOP, SAFEOP), (SAFEOP, OP)):
        assert found == (state | ERROR, 0x0011)
    elif (state, wanted) == (INIT, PREOP):
        assert found == (INIT | ERROR, 0x0016)  # the mailbox was not set up
    elif (state, wanted) == (PREOP, SAFEOP):
        assert found == (PREOP | ERROR, 0x001D)  # process data were not set up
    else:
        assert found == (wanted, 0)


@pytest.mark.parametrize("wanted", [0, 5, 6, 7, 9, 12, 15])
def test_unknown_state__0012(wanted):
    host = in_state(PREOP)
    assert host.ask(wanted) == (PREOP | ERROR, 0x0012)


def test_error__holds_until_it_is_acknowledged():
    host = Host()
    assert host.ask(OP) == (INIT | ERROR, 0x0011)
    host.mailboxes()
    assert host.ask(PREOP) == (INIT | ERROR, 0x0011)
    assert host.ask(PREOP | ERROR) == (PREOP, 0)


@pytest.mark.parametrize(
    "fault",
    [
        (0, 0x1000, 255, managers.BOX_OUT, 1),
        (0, 0x1002, 256, managers.BOX_OUT, 1),
        (0, 0x1000, 256, managers.BOX_IN, 1),
        (0, 0x1000, 256, managers.UNWATCHED, 1),
        (0, 0x1000, 256, managers.BOX_OUT, 0),
        (1, 0x1100, 128, managers.BOX_IN, 1),
        (1, 0x1100, 256, managers.BOX_OUT, 1),
        (1, 0x1100, 256, managers.BOX_IN, 0),
    ],
)
def test_wrong_mailbox__0016(fault):
    host = Host()
    host.mailboxes()
    host.manager(*fault)
    assert host.ask(PREOP) == (INIT | ERROR, 0x0016)


def test_boot__needs_the_bootstrap_mailbox_and_leaves_with_it():
    host = Host()
    host.manager(0, 0x1000, 256, managers.BOX_OUT)
    assert host.ask(BOOT) == (INIT | ERROR, 0x0015)
    host.manager(1, 0x1100, 256, managers.BOX_IN)
    assert host.ask(BOOT) == (INIT | ERROR, 0x0015)  # not acknowledged
    assert host.ask(BOOT | ERROR) == (BOOT, 0)
    host.manager(0, 0x1000, 128, managers.BOX_OUT)
    host.background()
    assert host.status == (INIT | ERROR, 0x0015)


def test_boot__has_no_coe_and_comes_back_to_op():
    host = in_state(BOOT)
    host.send(struct.pack("<HBHB4x", 2 << 12, 0x40, 0x1000, 0))
    host.background()
    assert host.receive() == (0, struct.pack("<HH", 1, 2))
    assert host.ask(INIT) == (INIT, 0)
    assert host.to_op().get(0x1000) == 0xFFFF0192


RX, TX = DEVICE.bytes("rx"), DEVICE.bytes("tx")


@pytest.mark.parametrize(
    ("fault", "code"),
    [
        ((2, 0x1200, RX - 1, managers.OUTPUTS, 1), 0x001D),
        ((2, 0x1200, RX + 1, managers.OUTPUTS, 1), 0x001D),
        ((2, 0x1204, RX, managers.OUTPUTS, 1), 0x001D),
        ((2, 0x1200, RX, managers.WATCHED_INPUTS, 1), 0x001D),
        ((2, 0x1200, RX, managers.BOX_OUT, 1), 0x001D),
        ((2, 0x1200, RX, managers.OUTPUTS, 0), 0x001D),
        ((3, 0x1800, TX + 4, managers.INPUTS, 1), 0x001E),
        ((3, 0x1800, TX, managers.UNWATCHED, 1), 0x001E),
        ((3, 0x1800, TX, managers.INPUTS, 0), 0x001E),
    ],
)
def test_wrong_process_data__001d_001e(fault, code):
    host = in_state(PREOP)
    host.process_managers()
    host.manager(*fault)
    assert host.ask(SAFEOP) == (PREOP | ERROR, code)
    host.process_managers()
    assert host.ask(SAFEOP | ERROR) == (SAFEOP, 0)


def test_mailbox_changed_before_safeop__back_to_init():
    host = in_state(PREOP)
    host.manager(0, 0x1000, 200, managers.BOX_OUT)
    host.background()
    assert host.status == (INIT | ERROR, 0x0016)


def test_clock__0030_without_sync0_0035_with_a_wrong_cycle():
    host = in_state(PREOP)
    host.process_managers()
    host.put(0x1C32, 1, 2)  # SYNC0
    assert host.ask(SAFEOP) == (PREOP | ERROR, 0x0030)
    host.write(0x09A0, struct.pack("<I", 1_050_000))
    host.write(0x0981, b"\x03")
    assert host.ask(SAFEOP | ERROR) == (PREOP | ERROR, 0x0035)
    host.write(0x09A0, struct.pack("<I", 1_000_000))
    assert host.ask(SAFEOP | ERROR) == (SAFEOP, 0)


def test_op__waits_for_outputs_and_gives_up_with_0019():
    host = in_state(SAFEOP)
    assert host.ask(OP) == (SAFEOP, 0)
    host.outputs()
    host.cycle()
    host.background()
    assert host.status == (OP, 0)

    host = in_state(SAFEOP)
    assert host.ask(OP) == (SAFEOP, 0)
    host.cycle(90_100)
    assert host.status == (SAFEOP | ERROR, 0x0019)


def test_init__acknowledges_an_error_and_a_lower_state_keeps_it():
    host = in_state(SAFEOP)
    assert host.ask(BOOT) == (SAFEOP | ERROR, 0x0011)
    assert host.ask(PREOP) == (PREOP | ERROR, 0x0011)
    assert host.ask(INIT) == (INIT, 0)
    assert host.ask(PREOP) == (PREOP, 0)


IDENTIFY, IDENTIFIED = AL_CONTROL.word(identification=1), AL_STATUS.word(identification=1)


@pytest.mark.parametrize("state", [INIT, PREOP, SAFEOP, OP])
def test_identification__is_the_code_while_it_is_asked_for(state):
    host = Host().to_preop()
    host.put(0x2021, 0, 0xA5C3)
    host.ask(INIT)
    {INIT: lambda: None, PREOP: host.to_preop, SAFEOP: host.to_safeop, OP: host.to_op}[state]()
    assert host.ask(state | IDENTIFY) == (state | IDENTIFIED, 0xA5C3)
    assert host.ask(state) == (state, 0)


def test_identification__is_no_error_and_comes_with_a_change_of_state():
    host = Host()
    host.mailboxes()
    assert host.ask(PREOP | IDENTIFY) == (PREOP | IDENTIFIED, 0)  # none was given
    host.put(0x2021, 0, 7)
    host.process_managers()
    assert host.ask(SAFEOP | IDENTIFY) == (SAFEOP | IDENTIFIED, 7)  # unacknowledged: not an error


def test_identification__error_has_the_code_first():
    host = in_state(PREOP)
    host.put(0x2021, 0, 7)
    assert host.ask(OP | IDENTIFY) == (PREOP | ERROR, 0x0011)
    assert host.ask(PREOP | IDENTIFY) == (PREOP | ERROR, 0x0011)
    assert host.ask(PREOP | IDENTIFY | ERROR) == (PREOP | IDENTIFIED, 7)
    host.manager(0, 0x1000, 200, managers.BOX_OUT)
    host.background()
    assert host.status == (INIT | ERROR, 0x0016)


def test_manager_that_the_device_does_not_use__0017():
    for manager in range(4, 8):
        host = in_state(PREOP)
        host.process_managers()
        host.manager(manager, 0x1F00, 16, managers.UNWATCHED)
        assert host.ask(SAFEOP) == (PREOP | ERROR, 0x0017)
        host.write(esc_regmap.SM_ACTIVATE.at(manager), b"\0")
        assert host.ask(SAFEOP | ERROR) == (SAFEOP, 0)


def test_object_that_the_master_would_write_twice__0025():
    """Both maps are right by themselves."""
    host = in_state(PREOP)
    host.process_managers()
    host.put(0x1610, 0, 0)
    host.put(0x1610, 1, 0x60400010)  # the controlword of the first axis instead of the second
    host.put(0x1610, 0, 8)
    assert host.ask(SAFEOP) == (PREOP | ERROR, 0x0025)
    host.put(0x1610, 0, 0)
    host.put(0x1610, 1, 0x68400010)
    host.put(0x1610, 0, 8)
    assert host.ask(SAFEOP | ERROR) == (SAFEOP, 0)


def test_watchdog__falls_to_safeop_with_001b():
    host = in_state(OP)
    host.put(0x10F1, 2, 0)
    for _ in range(20):
        host.outputs()
        host.cycle(900)
        assert host.status == (OP, 0)
    host.cycle(200)
    assert host.status == (SAFEOP | ERROR, 0x001B)
    # Outputs of before do not count for the way back.
    assert host.ask(OP | ERROR) == (SAFEOP, 0)
    host.cycle(100)
    assert host.status == (SAFEOP, 0)
    host.outputs()
    host.cycle()
    assert host.status == (OP, 0)


def test_lost_outputs__001a_by_their_limit_unless_it_runs_free():
    for kind, cycles, wanted in (
        (1, 200, (OP, 0)),
        (1, 220, (SAFEOP | ERROR, 0x001A)),
        (0, 900, (OP, 0)),
        (0, 1100, (SAFEOP | ERROR, 0x001B)),
    ):
        host = in_state(OP)
        host.put(0x1C32, 1, kind)
        host.cycle(cycles)
        assert host.status == wanted
        assert host.get(0x1C32, 0x0B) == (20 if kind and cycles < 210 else 21 if kind else 0)
        assert host.get(0x1C32, 0x20) == (wanted[1] == 0x001A)


def test_cycle_time__measured_or_of_sync0():
    host = in_state(OP)
    for _ in range(3):
        host.outputs()
        host.cycle(20)
    assert host.get(0x1C32, 2) == 2_000_000 == host.get(0x1C33, 2)
    host.write(0x09A0, struct.pack("<I", 1_000_000))
    host.write(0x0981, b"\3")
    host.put(0x1C32, 1, 2)
    host.outputs()
    host.cycle()
    assert host.get(0x1C32, 2) == 1_000_000 == host.get(0x1C33, 2)


def with_sync0(state: int) -> Host:
    """The device with 1C32:01 = 2 and SYNC0 of 1 ms."""
    host = in_state(PREOP)
    host.process_managers()
    host.put(0x1C32, 1, 2)
    host.write(0x09A0, struct.pack("<I", 1_000_000))
    host.write(0x0981, b"\3")
    assert host.ask(SAFEOP) == (SAFEOP, 0)
    if state == OP:
        assert host.ask(OP) == (SAFEOP, 0)
        host.outputs()
        host.cycle()
        assert host.status == (OP, 0)
    return host


@pytest.mark.parametrize(
    ("address", "value"), [(0x0981, b"\0"), (0x0981, b"\1"), (0x0981, b"\2"), (0x09A0, b"\7\0\0\0")]
)
def test_sync0_lost_in_op__falls_with_002c_and_the_axes_fault(address, value):
    host = with_sync0(OP)
    host.write(address, value)
    host.cycle()
    assert host.status == (SAFEOP | ERROR, 0x002C) and host.get(0x1C32, 0x20) == 1
    assert host.get(0x603F) == 0x7500


def test_sync0_without_pulses_in_op__falls_with_002c_after_two_cycles():
    host = with_sync0(OP)
    for _ in range(50):  # as it is on, with outputs
        host.outputs()
        host.cycle(10)
    assert host.status == (OP, 0)
    host.library.double_sync0(False)
    host.cycle(9 + 10)  # none of the last one's cycle is missing yet
    assert host.status == (OP, 0)
    host.cycle(3)
    assert host.status == (SAFEOP | ERROR, 0x002C) and host.get(0x603F) == 0x7500


def test_op__waits_for_sync0_and_gives_up_with_002d():
    """Its start time may be a while ahead when the master asks for OP."""
    for comes, wanted in ((True, (OP, 0)), (False, (SAFEOP | ERROR, 0x002D))):
        host = with_sync0(SAFEOP)
        host.library.double_sync0(False)
        assert host.ask(OP) == (SAFEOP, 0)
        host.outputs()
        host.cycle(80_000)
        assert host.status == (SAFEOP, 0)
        host.library.double_sync0(comes)
        host.outputs()
        host.cycle(12 if comes else 12_000)
        assert host.status == wanted


def test_sync0_lost_in_op__counts_only_where_it_is_asked_for():
    host = with_sync0(OP)
    host.put(0x1C32, 1, 1)
    host.write(0x0981, b"\0")
    host.cycle()
    assert host.status == (OP, 0)


def test_sync0_off_in_safeop__op_is_refused_with_002d():
    host = with_sync0(SAFEOP)
    host.write(0x0981, b"\0")
    assert host.ask(OP) == (SAFEOP | ERROR, 0x002D)
    host.write(0x0981, b"\3")
    host.ask(OP | ERROR)
    host.outputs()
    host.cycle()
    assert host.status == (OP, 0)


def test_process_data_changed_in_op__falls_with_its_code():
    for manager, code in ((2, 0x001D), (3, 0x001E)):
        host = in_state(OP)
        host.write(esc_regmap.SM_ACTIVATE.at(manager), b"\0")
        host.background()
        assert host.status == (PREOP | ERROR, code)


def test_changed_mapping__is_what_safeop_asks_for():
    host = in_state(PREOP)
    host.put(0x1C12, 0, 0)
    host.put(0x1C12, 1, 0x1610)
    host.put(0x1C12, 0, 1)
    host.put(0x1C13, 0, 0)
    host.process_managers(outputs=20)
    host.manager(3, 0, 0, 0, 0)
    assert host.ask(SAFEOP) == (SAFEOP, 0)
    data = struct.pack("<Hbxiihih", 6, 8, -5, 7, 300, -1, 2)
    host.write(0x1200, data)
    host.cycle()
    assert host.ask(OP) == (OP, 0)
    host.write(0x1200, data)
    host.cycle()
    assert host.get(0x6840) == 6 and host.get(0x687A) == -5 and host.get(0x68B2) == 2
    assert host.get(0x6040) == 0


def test_halt__each_state_is_refused_with_its_code():
    host = Host().to_preop()
    host.library.al_halt(0x8001)
    assert host.status == (INIT | ERROR, 0x8001)
    for wanted in (PREOP, PREOP | ERROR):
        assert host.ask(wanted) == (INIT | ERROR, 0x8001)
    assert host.ask(BOOT | ERROR) == (BOOT, 0)  # for another program
    assert host.ask(INIT) == (INIT, 0)
    assert host.ask(PREOP) == (INIT | ERROR, 0x8001)
    host.power_on()
    assert host.to_preop().status == (PREOP, 0)
