# SPDX-License-Identifier: Apache-2.0
"""Mailbox and CANopen over EtherCAT: transfers, abort codes, information, emergencies, wrong input.

Independent of us: the SDO client of python-canopen, which frames its requests by itself.
"""

from __future__ import annotations

import random
import struct
import subprocess

import pytest
from canopen.sdo import SdoAbortedError, SdoClient

from sim.bus.coe.dictionary import TYPES
from tests.ethercat import managers
from tests.ethercat.canopen_client import client_of
from tests.ethercat.host import (
    AXES,
    DEVICE,
    HERE,
    OP,
    PREOP,
    SAFEOP,
    AbortedError,
    Host,
    build,
)


@pytest.fixture
def host() -> Host:
    return Host().to_preop()


@pytest.fixture
def client(host) -> SdoClient:
    return client_of(host)


def aborts(code: int, kind: type[Exception] = AbortedError) -> pytest.RaisesExc:
    """A context that must end with this abort code."""
    return pytest.raises(kind, check=lambda error: error.code == code)


# -------------------------------------------------------------------- transfers


def test_every_entry__reads_its_default(host):
    state = {0x6041, 0x1001, 0x608F, 0x6092}  # the scale of each axis: test_scale
    assert host.get(0x1010, 1) == 1 != DEVICE.object(0x1010).entry(1).default  # it has a flash
    for one in DEVICE.objects:
        for entry in one.entries:
            if (one.index - 0x6000) % 0x800 + 0x6000 not in state and one.index != 0x1010:
                assert host.upload(one.index, entry.subindex) == entry.data(), hex(one.index)


def test_canopen_client__reads_and_writes_every_plain_entry(client):
    for one in DEVICE.objects:
        for entry in one.entries:
            if entry.type in ("string", "octets") or one.index in (0x1010, 0x1011):
                continue
            data = client.upload(one.index, entry.subindex)
            assert len(data) == entry.bytes
            if entry.access == "rw":
                client.download(one.index, entry.subindex, data)
                assert client.upload(one.index, entry.subindex) == data


@pytest.mark.parametrize("size", [5, 7, 8, 14, 100, 480])
def test_canopen_client__downloads_in_segments(client, host, size):
    text = bytes(65 + n % 26 for n in range(size))
    with client.open(0x2020, 0, "wb", size=size, buffering=0) as stream:
        at = 0
        while at < size:
            at += stream.write(text[at:])
    assert host.upload(0x2020) == text


@pytest.mark.parametrize("size", [0, 1, 4, 5, 239, 240, 241, 247, 248, 479, 480])
@pytest.mark.parametrize("segment", [0, 7, 8, 100])
def test_every_size__comes_back_as_it_went(host, size, segment):
    text = bytes(33 + n % 90 for n in range(size))
    if size:
        host.download(0x2020, 0, text, segment=segment)
    assert host.upload(0x2020) == text


def test_whole_object__up_and_down(host):
    expected = b"\x06\x00" + struct.pack("<6H", *range(0x1600, 0x1660, 0x10))
    assert host.upload(0x1C12, 0, complete=True) == expected
    assert host.upload(0x1C12, 1, complete=True) == expected[2:]
    shorter = b"\x02\x00" + struct.pack("<2H", 0x1650, 0x1600)
    host.download(0x1C12, 0, shorter, complete=True)
    assert host.upload(0x1C12, 0) == b"\x02" and host.upload(0x1C12, 1) == b"\x50\x16"
    gains = struct.pack("<5f", 1, 2, 3, 4, 5)
    host.download(0x2000, 1, gains, complete=True)
    assert host.upload(0x2000, 1, complete=True) == gains


@pytest.mark.parametrize("index", [0x1C12, 0x1C13, 0x1600, 0x1A50])
def test_whole_list_without_its_count__only_while_the_count_is_0(host, index):
    before = host.upload(index, 0, complete=True)
    with aborts(0x06010003):
        host.download(index, 1, before[2:], complete=True)
    assert host.upload(index, 0, complete=True) == before
    host.put(index, 0, 0)
    host.download(index, 1, before[2:], complete=True)
    assert host.upload(index, 0) == b"\0"
    host.put(index, 0, before[0])
    assert host.upload(index, 0, complete=True) == before


@pytest.mark.parametrize("first", [0x1600, 0x1A00])
def test_map_in_a_list__may_not_grow_beyond_the_process_data(host, first):
    """512 bytes; the list was counted while its maps were short."""
    for n in range(5):
        host.put(first + 0x10 * n, 0, 0)
        for entry in range(10):
            host.put(first + 0x10 * n, entry + 1, 248)  # 31 bytes of padding
    host.put(first, 0, 10)
    host.put(first + 0x10, 0, 6)  # 496 bytes, and one of digital inputs or outputs
    with aborts(0x06040042):
        host.put(first + 0x20, 0, 1)
    assert host.get(first + 0x20) == 0


# -------------------------------------------------------------------- abort codes

ABORTS = {
    "no object": (0x06020000, lambda h: h.upload(0x3000)),
    "no object of a sixth axis": (0x06020000, lambda h: h.upload(0x8841)),
    "no subindex": (0x06090011, lambda h: h.upload(0x1018, 5)),
    "no subindex of a variable": (0x06090011, lambda h: h.upload(0x6041, 1)),
    "read only": (0x06010002, lambda h: h.download(0x6041, 0, b"\0\0")),
    "constant": (0x06010002, lambda h: h.download(0x1000, 0, bytes(4))),
    "name": (0x06010002, lambda h: h.download(0x1008, 0, b"other name")),
    "short": (0x06070010, lambda h: h.download(0x607A, 0, b"\0\0")),
    "long": (0x06070010, lambda h: h.download(0x6040, 0, bytes(4))),
    "long string": (0x06070012, lambda h: h.download(0x2020, 0, bytes(481))),
    "value": (0x06090030, lambda h: h.put(0x6060, 0, 7)),
    "limit": (0x06090030, lambda h: h.put(0x6081, 0, 0)),
    "not a number": (0x06090030, lambda h: h.put(0x2000, 1, float("nan"))),
    "beyond a limit": (0x06090030, lambda h: h.put(0x2000, 1, -1.0)),
    "count of a list": (0x06090030, lambda h: h.put(0x1C12, 0, 7)),
    "list in use": (0x06010003, lambda h: h.put(0x1C12, 1, 0x1600)),
    "map in use": (0x06010003, lambda h: h.put(0x1600, 1, 0x60400010)),
    "no such PDO": (0x06040041, lambda h: (h.put(0x1C12, 0, 0), h.put(0x1C12, 1, 0x1A00))),
    "PDO twice": (
        0x06040041,
        lambda h: (h.put(0x1C12, 0, 0), h.put(0x1C12, 2, 0x1600), h.put(0x1C12, 0, 2)),
    ),
    "not to be mapped": (0x06040041, lambda h: (h.put(0x1600, 0, 0), h.put(0x1600, 1, 0x60410010))),
    "mapped with a wrong length": (
        0x06040041,
        lambda h: (h.put(0x1600, 0, 0), h.put(0x1600, 1, 0x60400020)),
    ),
    "mapped in bits": (0x06040041, lambda h: (h.put(0x1600, 0, 0), h.put(0x1600, 1, 1))),
    "mapped object missing": (
        0x06020000,
        lambda h: (h.put(0x1600, 0, 0), h.put(0x1600, 1, 0x30000010)),
    ),
    "limits the wrong way round, most": (
        0x06090036,
        lambda h: (h.put(0x607D, 1, 5), h.put(0x607D, 2, 4)),
    ),
    "limits the wrong way round, least": (
        0x06090036,
        lambda h: (h.put(0x687D, 2, -5), h.put(0x687D, 1, -4)),
    ),
    "segment without a transfer": (0x05040001, lambda h: h.sdo(struct.pack("<B7x", 0x60))),
    "data without a transfer": (0x05040001, lambda h: h.sdo(struct.pack("<B7x", 0x00))),
    "no such command": (0x05040001, lambda h: h.sdo(struct.pack("<B7x", 0xE0))),
    "read only as a whole object": (
        0x06010002,
        lambda h: h.download(0x1018, 0, b"\x04\0" + bytes(16), complete=True),
    ),
    "read only from subindex 1 on": (
        0x06010002,
        lambda h: h.download(0x1018, 1, bytes(16), complete=True),
    ),
    "no type of inputs but theirs": (0x06090030, lambda h: h.put(0x1C33, 1, 2)),
    "variable as a whole object": (0x06090011, lambda h: h.upload(0x6041, 0, complete=True)),
}


@pytest.mark.parametrize("what", ABORTS)
def test_abort__tells_its_code(host, what):
    code, provoke = ABORTS[what]
    with aborts(code):
        provoke(host)
    assert host.upload(0x1000) == bytes.fromhex("9201ffff")  # it goes on serving


def test_abort__longer_than_the_process_data(host):
    for n in range(6):
        host.put(0x1600 + 0x10 * n, 0, 0)
        for entry in range(10):
            host.put(0x1600 + 0x10 * n, entry + 1, 248 if entry else 0x60400010)
    host.put(0x1C12, 0, 0)
    for n in range(6):
        host.put(0x1600 + 0x10 * n, 0, 10)
    with aborts(0x06040042):
        host.put(0x1C12, 0, 6)
    host.put(0x1C12, 0, 1)
    host.process_managers(outputs=2 + 9 * 31)
    assert host.ask(4) == (4, 0)


# Objects of an axis with their bits: words, halves and bytes, more of each than are copied at once.
MAPPED = {
    "rx": [(0x6040, 16), (0x607A, 32), (0x6060, 8), (0x60FF, 32), (0x6071, 16), (0x60B1, 32)],
    "tx": [(0x6041, 16), (0x6064, 32), (0x6061, 8), (0x606C, 32), (0x6077, 16), (0x60FD, 32)],
}


@pytest.mark.parametrize("lead", range(4))
def test_process_data__at_any_place_in_the_image(host, lead):
    """`lead` bytes of padding before the objects of each axis, and one byte after the first map."""
    places: dict[str, list[tuple[int, struct.Struct, int]]] = {}
    for side, first, lists in (("rx", 0x1600, 0x1C12), ("tx", 0x1A00, 0x1C13)):
        host.put(lists, 0, 0)
        places[side], at = [], 0
        for axis in range(AXES):
            entries = [(0, 8 * lead)] if lead else []
            entries += [(index + 0x800 * axis, bits) for index, bits in MAPPED[side]]
            entries += [(0, 8)] if axis == 0 else []
            host.put(first + 0x10 * axis, 0, 0)
            for n, (index, bits) in enumerate(entries):
                host.put(first + 0x10 * axis, n + 1, index << 16 | bits)
                if index:
                    number = struct.Struct(f"<{DEVICE.object(index).entry(0).format[-1]}")
                    places[side].append((at, number, index))
                at += bits // 8
            host.put(first + 0x10 * axis, 0, len(entries))
            host.put(lists, axis + 1, first + 0x10 * axis)
        host.put(lists, 0, AXES)
        area = (
            (2, 0x1200, at, managers.OUTPUTS) if side == "rx" else (3, 0x1800, at, managers.INPUTS)
        )
        host.manager(*area)
        size = at
    rng = random.Random(lead)
    values = {index: rng.randrange(1 << 7) for _, _, index in places["rx"]}
    data = bytearray(rng.randbytes(size))
    for at, number, index in places["rx"]:
        values[index] = 8 if index & 0x7FF == 0x060 else rng.randrange(1 << 8 * number.size - 1)
        number.pack_into(data, at, values[index])
    assert host.ask(SAFEOP) == (SAFEOP, 0)
    for _ in range(2):
        host.write(0x1200, bytes(data))
        for axis in host.feedback.axis:
            axis.position += rng.randrange(1 << 16)
            axis.torque, axis.switches = rng.randrange(1 << 8), rng.randrange(8)
        host.cycle()
        host.ask(OP)
    image = host.read(0x1800, size)
    assert {index: host.get(index) for index in values} == values
    for at, number, index in places["tx"]:
        assert number.unpack_from(image, at)[0] == host.get(index), hex(index)


def test_abort__mapping_in_op_is_the_wrong_state():
    host = Host().to_op()
    for index in (0x1C12, 0x1C13, 0x1600, 0x1A50):
        with aborts(0x08000022):
            host.put(index, 0, 0)


def test_abort__toggle_bit_and_length_in_segments(host):
    text = bytes(300)
    head = struct.pack("<BHBI", 0x21, 0x2020, 0, len(text))
    host.sdo(head + text[:240])
    with aborts(0x05030000):
        host.sdo(bytes([0x10]) + text[:60])
    host.sdo(head + text[:240])
    with aborts(0x06070012):
        host.sdo(bytes([0x00]) + text[:61])
    host.sdo(head + text[:240])
    with aborts(0x06070013):
        host.sdo(bytes([0x01]) + text[:59])
    host.download(0x2020, 0, bytes(65 for _ in range(480)))
    host.sdo(struct.pack("<BHB4x", 0x40, 0x2020, 0))
    with aborts(0x05030000):
        host.sdo(struct.pack("<B7x", 0x70))


def test_abort__is_raised_by_the_canopen_client(client):
    with aborts(0x06020000, SdoAbortedError):
        client.upload(0x3000, 0)
    with aborts(0x06010002, SdoAbortedError):
        client.download(0x6041, 0, b"\0\0")


# -------------------------------------------------------------------- information


def information(host: Host, opcode: int, data: bytes) -> bytes:
    """The answer's data, all fragments of it."""
    answer = host.coe(8, struct.pack("<BBH", opcode, 0, 0) + data)
    found, left = answer[4:], struct.unpack_from("<H", answer, 2)[0]
    assert answer[0] & 0x7F == opcode + 1, answer.hex()
    while left:
        assert answer[0] & 0x80
        host.background()
        kind, message = host.receive()
        answer = message[2:]
        assert kind == 3 and struct.unpack_from("<H", answer, 2)[0] == left - 1
        left -= 1
        found += answer[4:]
    assert not answer[0] & 0x80
    host.background()
    return found


def object_list(host: Host, kind: int) -> list[int]:
    data = information(host, 1, struct.pack("<H", kind))
    assert struct.unpack_from("<H", data)[0] == kind
    return list(struct.unpack(f"<{len(data) // 2 - 1}H", data[2:]))


def test_lists__every_object_and_those_to_map(host):
    assert object_list(host, 1) == [o.index for o in DEVICE.objects]
    for kind, direction in ((2, "rx"), (3, "tx")):
        wanted = [o.index for o in DEVICE.objects if any(e.pdo == direction for e in o.entries)]
        assert object_list(host, kind) == wanted
    wanted = [o.index for o in DEVICE.objects if any(e.stored for e in o.entries)]
    assert object_list(host, 4) == wanted
    lengths = object_list(host, 0)
    assert lengths == [len(object_list(host, kind)) for kind in range(1, 6)]


def test_descriptions__of_every_object_and_entry(host):
    kinds = {"var": 7, "array": 8, "record": 9}
    for one in DEVICE.objects:
        data = information(host, 3, struct.pack("<H", one.index))
        index, _, last, kind = struct.unpack_from("<HHBB", data)
        assert (index, last, kind) == (one.index, one.entries[-1].subindex, kinds[one.kind])
        assert data[6:].decode() == one.name
        for entry in one.entries:
            data = information(host, 5, struct.pack("<HBB", one.index, entry.subindex, 0))
            index, sub, values, code, bits, access = struct.unpack_from("<HBBHHH", data)
            assert (index, sub, values) == (one.index, entry.subindex, 0)
            assert (code, bits) == (TYPES[entry.type].code, entry.bits)
            write = {"rw": 0x38, "preop": 0x08}.get(entry.access, 0)
            mapped = {"rx": 0x40, "tx": 0x80, "": 0}[entry.pdo]
            assert access == 7 | write | mapped | 0x100 * entry.stored
            assert data[10:].decode() == entry.name


def test_description__with_default_and_limits(host):
    data = information(host, 5, struct.pack("<HBB", 0x6081, 0, 0x70))
    assert data[3] == 0x70
    assert struct.unpack_from("<3I", data, 10) == (5_000_000, 1, 2_000_000_000)
    assert data[22:] == b"Profile velocity"


@pytest.mark.parametrize(
    ("request_data", "code"),
    [
        (struct.pack("<BBHH", 3, 0, 0, 0x3000), 0x06020000),
        (struct.pack("<BBHHBB", 5, 0, 0, 0x1018, 9, 0), 0x06090011),
        (struct.pack("<BBHH", 1, 0, 0, 6), 0x06010000),
        (struct.pack("<BBHH", 2, 0, 0, 0), 0x05040001),
        (struct.pack("<BBH", 3, 0, 0), 0x05040001),
        (b"", 0x05040001),
    ],
)
def test_information__refused_with_a_code(host, request_data, code):
    answer = host.coe(8, request_data)
    assert answer[0] == 7 and struct.unpack_from("<I", answer, 4)[0] == code


# -------------------------------------------------------------------- emergencies, wrong input


def test_emergency__tells_error_register_and_axis():
    host = Host().to_op()
    host.feedback.axis[3].fault = 0x5441
    host.cycle(2)
    kind, data = host.receive()
    assert kind == 3
    head, code, register, axis = struct.unpack_from("<HHBB", data)
    assert (head >> 12, code, register, axis) == (1, 0x5441, 0x21, 3)
    assert host.get(0x783F) == 0x5441 and host.upload(0x1001) == b"\x21"


def emergencies(host: Host) -> list[tuple[int, int, int]]:
    """Code, error register and axis of all that wait."""
    found = []
    host.background()
    while message := host.receive():
        found.append(struct.unpack_from("<xxHBB", message[1]))
        host.background()
    return found


def test_emergency__0000_at_the_reset_with_what_is_left():
    host = Host().to_op()
    for axis in (1, 4):
        host.feedback.axis[axis].fault = 0x5441
    host.outputs()
    host.cycle(3)
    assert emergencies(host) == [(0x5441, 0x21, 1), (0x5441, 0x21, 4)]
    host.outputs({(0x6840, 0): 0x80})
    host.cycle(3)
    assert emergencies(host) == []  # it lasts
    host.feedback.axis[1].fault = 0
    for control in (0, 0x80):
        host.outputs({(0x6840, 0): control})
        host.cycle(3)
    assert emergencies(host) == [(0x0000, 0x21, 1)]
    host.feedback.axis[4].fault = 0
    host.outputs({(0x8040, 0): 0x80})
    host.cycle(3)
    assert emergencies(host) == [(0x0000, 0x00, 4)] and host.upload(0x1001) == b"\0"


def test_emergency__lost_outputs_are_an_error_of_communication():
    host = Host().to_op()
    host.cycle(1100)
    assert emergencies(host) == [(0x7500, 0x11, axis) for axis in range(5)]
    assert host.upload(0x1001) == b"\x11"
    host.feedback.axis[2].fault = 0x5441  # the first error stays
    host.cycle()
    assert emergencies(host) == []


def test_lost_answer__is_repeated_even_when_another_message_has_come():
    host = Host().to_op()
    host.send(struct.pack("<H", 2 << 12) + struct.pack("<BHB4x", 0x40, 0x1018, 1))
    host.background()
    first = host.receive()
    host.feedback.axis[0].fault = 0x5441
    host.cycle(2)  # now an emergency is in the mailbox
    host.write(0x80E, b"\x03")
    host.background()
    assert host.read(0x80F, 1) == b"\x02"
    assert host.receive() == first
    host.background()
    assert host.receive()[1][1] >> 4 == 1
    host.write(0x80E, b"\x01")
    host.background()
    assert host.receive()[1][1] >> 4 == 1


def test_message_sent_twice__is_served_once(host):
    message = struct.pack("<H", 2 << 12) + struct.pack("<BHBi", 0x23, 0x607A, 0, 5)
    assert host.send(message, counter=3)
    host.background()
    assert host.receive() is not None
    assert host.send(message, counter=3)
    host.background()
    assert host.receive() is None


def test_mailbox__is_full_until_it_is_taken(host):
    assert host.receive() is None
    request = struct.pack("<H", 2 << 12) + struct.pack("<BHB4x", 0x40, 0x1000, 0)
    assert host.send(request) and not host.send(request)
    host.background()
    assert host.send(request)  # taken; the answer is still there
    host.background()
    assert not host.send(request)
    assert host.receive() and host.receive() is None


@pytest.mark.parametrize(
    ("kind", "data", "detail"),
    [
        (2, bytes(10), 2),
        (5, bytes(10), 2),
        (0, bytes(10), 2),
        (3, b"\0", 6),
        (3, struct.pack("<H", 2 << 12) + bytes(7), 6),
        (3, struct.pack("<H", 9 << 12) + bytes(8), 4),
    ],
)
def test_wrong_message__gets_a_mailbox_error(host, kind, data, detail):
    host.send(data, kind=kind)
    host.background()
    assert host.receive() == (0, struct.pack("<HH", 1, detail))
    assert len(host.upload(0x1000)) == 4


def test_message_longer_than_the_mailbox__gets_a_mailbox_error(host):
    host.write(0x1000, struct.pack("<HHBB", 251, 0, 0, 0x13) + bytes(250))
    host.background()
    assert host.receive() == (0, struct.pack("<HH", 1, 8))


def test_flood_in_op__does_not_disturb_the_cycle():
    host = Host().to_op()
    rng = random.Random(17)
    for _ in range(1000):
        host.outputs()
        host.send(rng.randbytes(rng.randrange(1, 60)), kind=rng.choice((3, 3, 3, 1)), counter=0)
        host.cycle()
        host.receive()
    assert host.status == (OP, 0)
    host.ask(PREOP)
    while host.receive():
        host.background()
    assert len(host.upload(0x1000)) == 4


def fuzz(messages: int, seed: int) -> None:
    sanitize = "-fsanitize=address,undefined"
    program = build("fuzz", sanitize, "-fno-sanitize-recover=all", extra=(HERE / "fuzz_mailbox.c",))
    done = subprocess.run(
        [program, str(messages), str(seed)], capture_output=True, text=True, timeout=3000
    )
    assert done.returncode == 0, f"replay: {program} {messages} {seed}\n{done.stderr[-3000:]}"
    assert int(done.stdout) > messages // 4


def test_random_messages__never_read_or_write_beyond_and_never_hang():
    fuzz(40_000, 17)


@pytest.mark.full
def test_random_messages__many():
    for seed in range(20):
        fuzz(2_000_000, seed)
