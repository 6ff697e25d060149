# SPDX-License-Identifier: Apache-2.0
"""GDB's protocol on the Verilated system: every packet, by a client that knows the manual alone."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator

import pytest

from sim.rtl.n2_lockstep_isa import default_isa
from tests.gdb.client import PC, STATUS, Client, Debugged, framed, program, stopped_at, system

ISA = default_isa()
DTCM, CONSOLE = 0x1004_0000, 0x2000_005C
# Registers of the feature org.gnu.gdb.nios2.cpu, in the order of GDB 13's features/nios2-cpu.xml.
GDB_NAMES = (
    "zero at r2 r3 r4 r5 r6 r7 r8 r9 r10 r11 r12 r13 r14 r15 r16 r17 r18 r19 r20 r21 r22 r23 "
)
GDB_NAMES += "et bt gp sp fp ea sstatus ra pc status estatus bstatus ienable ipending cpuid ctl6 "
GDB_NAMES += "exception pteaddr tlbacc tlbmisc eccinj badaddr config mpubase mpuacc"


def debugged(name: str = "run/demo_hello_fpga2") -> Debugged:
    """A server with a program that is at its reset vector."""
    return Debugged(system(), program(name))


@pytest.fixture
def gdb() -> Iterator[Client]:
    """A debugger of such a server."""
    with debugged() as client:
        yield client


def code(name: str, *operands: int) -> bytes:
    """An instruction as it is in memory."""
    return struct.pack("<I", ISA.instructions[name].encode(*operands))


def test_greeting__features_and_one_thread(gdb):
    features = gdb.ask("qSupported:swbreak+;hwbreak+").split(b";")
    assert b"qXfer:features:read+" in features and b"swbreak+" in features
    assert gdb.ask("vMustReplyEmpty") == b"" and gdb.ask("qSomethingNew") == b""
    assert gdb.ask("qfThreadInfo") == b"m1" and gdb.ask("qsThreadInfo") == b"l"
    gdb.ok("Hg0")
    assert stopped_at(gdb.ask("?")) == 0x1000_0000
    gdb.ok("QStartNoAckMode")
    gdb.peer.sendall(framed(b"qC"))
    assert gdb.packet() == b"QC1"


def document(gdb: Client, name: str, piece: int) -> ElementTree.Element:
    """A document in pieces of so many bytes, parsed."""
    text, more = b"", b"m"
    while more == b"m":
        answer = gdb.ask(f"qXfer:{name}:{len(text):x},{piece:x}")
        more, text = answer[:1], text + answer[1:]
    return ElementTree.fromstring(text)


def test_target_description__registers_as_gdb_wants_them(gdb):
    target = document(gdb, "features:read:target.xml", 100)
    assert target.findtext("architecture") == "nios2"
    cpu, custom = target.findall("feature")
    assert cpu.get("name") == "org.gnu.gdb.nios2.cpu"
    assert [reg.get("name") for reg in cpu] == GDB_NAMES.split()
    assert len(custom) == 64 and {reg.get("type") for reg in custom} == {"ieee_single"}
    memory = document(gdb, "memory-map:read:", 4000)
    assert [int(m.get("start"), 16) for m in memory] == [0x1000_0000, DTCM, 0x2000_0000]
    assert gdb.ask("qXfer:features:read:other.xml:0,10") == b"E00"


def test_registers__written_and_read_back_alone_and_together(gdb):
    values = {n: 0x1111_0000 + n for n in [*range(1, 24), 24, 25, 26, 27, 28, 29, 31]}
    for number, value in values.items():
        gdb.set_register(number, value)
    assert {n: gdb.register(n) for n in values} == values
    both = gdb.registers()
    assert {n: both[n] for n in values} == values and both[0] == 0 and both[PC] == 0x1000_0000
    gdb.ok("G" + struct.pack(f"<{PC}I", *(2 * n for n in range(PC))).hex())
    again = gdb.registers()
    assert [again[n] for n in values] == [2 * n for n in values] and again[0] == 0
    gdb.set_register(36, 1)  # ienable
    gdb.set_register(34, 1)  # estatus
    assert gdb.register(36) == 1 and gdb.register(34) == 1
    gdb.set_register(STATUS, 1)
    assert gdb.register(STATUS) == 1
    assert gdb.ask("p200") == b"E0e" and gdb.ask("P20=01000000") == b"E0e"


def test_registers_of_a_custom_instruction(gdb):
    """The bounds of fsat: what the debugger writes, the program's instruction uses."""
    low, high = (struct.unpack("<I", struct.pack("<f", v))[0] for v in (-2.0, 3.0))
    gdb.set_register(49 + 2 * 5, low)
    gdb.set_register(49 + 2 * 5 + 1, high)
    gdb.set_register(49 + 2 * 6, high)
    assert [gdb.register(49 + 2 * 5 + i) for i in (0, 1, 2)] == [low, high, high]
    gdb.set_register(2, struct.unpack("<I", struct.pack("<f", 17.0))[0])
    # custom 244, r3, r2, c5: r2 limited to the bounds in register 5
    word = ISA.instructions["custom"].encode(244, 3, 2, 5, readrb=0)
    gdb.write(0x1000_0100, struct.pack("<I", word))
    gdb.set_register(PC, 0x1000_0100)
    assert stopped_at(gdb.go("s")) == 0x1000_0104
    assert gdb.register(3) == high


def test_memory__bytes_at_every_alignment(gdb):
    data = bytes(range(1, 40))
    for shift in range(4):
        for length in (0, 1, 2, 3, 4, 5, 7, 39):
            gdb.write(DTCM + 0x400, bytes(48))
            gdb.write(DTCM + 0x400 + shift, data[:length])
            want = (bytes(shift) + data[:length]).ljust(48, b"\0")
            assert gdb.read(DTCM + 0x400, 48) == want
            assert gdb.read(DTCM + 0x400 + shift, length) == data[:length]
    special = b"}$#*\x03+-" * 3
    packet = b"X%x,%x:" % (DTCM + 0x500, len(special))
    escaped = b"".join(bytes([0x7D, b ^ 0x20]) if b in b"}$#*" else bytes([b]) for b in special)
    gdb.ok(packet + escaped)
    assert gdb.read(DTCM + 0x500, len(special)) == special


@pytest.mark.parametrize(
    ("packet", "answer"),
    [
        ("m0,4", b"E0e"),
        (f"m{DTCM + 0xFFFC:x},8", b"E0e"),
        ("m20000054,2", b"E0e"),  # half a register of the I/O block
        ("mfffffffc,4", b"E0e"),
        ("m10000000", b"E16"),
        ("m-1,4", b"E0e"),
        ("mxyz,4", b"E16"),
        (f"M{DTCM:x},4:1234", b"E16"),
        (f"M{DTCM:x},2:12g4", b"E16"),
        (f"X{DTCM:x},9:abc", b"E16"),
        ("P0", b"E16"),
        ("p", b"E16"),
        ("G123", b"E16"),
        ("Z0,10000001,4", b"E0e"),
        ("Z1,10040000,4", b"E0e"),
        ("Z2,10040000,0", b"E0e"),
        ("Z9,10000000,4", b""),
        ("Z0", b"E16"),
        ("vCont;t", b"E16"),
        ("qRcmd,6", b"E16"),
        ("qXfer:memory-map:read::0", b"E16"),
        ("\xff\xfe", b""),
    ],
)
def test_what_cannot_be_done_is_an_error_and_nothing_else(gdb, packet, answer):
    assert gdb.ask(packet.encode("latin-1")) == answer
    assert stopped_at(gdb.ask("?")) == 0x1000_0000


def test_damaged_packet_is_asked_for_again(gdb):
    gdb.peer.sendall(b"$?#00")
    assert gdb.byte() == b"-"
    reply = gdb.ask("?")
    gdb.peer.sendall(b"-")  # the answer was damaged: once more
    assert gdb.packet() == reply


@pytest.mark.parametrize("kind", [0, 1])
def test_breakpoint__every_time_and_not_after_its_removal(gdb, kind):
    main = program("run/demo_hello_fpga2").address("main")
    before = gdb.read(main, 16)
    gdb.ok(f"Z{kind},{main:x},4")
    gdb.ok(f"Z{kind},{main:x},4")  # twice is once
    reply = gdb.go()
    assert stopped_at(reply) == main and (b"hwbreak" if kind else b"swbreak") in reply
    assert gdb.read(main, 16) == before, "the breakpoint shows in the program"
    gdb.set_register(PC, main)
    assert stopped_at(gdb.go("s")) == main + 4, "a step from a breakpoint leaves it"
    gdb.set_register(PC, main)
    gdb.ok(f"z{kind},{main:x},4")
    gdb.ok(f"z{kind},{main:x},4")
    assert gdb.go() == b"W00"


def test_writing_under_a_breakpoint_changes_the_program_and_keeps_the_breakpoint(gdb):
    gdb.write(0x1000_0100, code("addi", 2, 0, 1) * 4)
    gdb.ok("Z0,10000104,4")
    gdb.write(0x1000_0104, code("addi", 3, 0, 77))
    assert gdb.read(0x1000_0104, 4) == code("addi", 3, 0, 77)
    gdb.set_register(PC, 0x1000_0100)
    assert stopped_at(gdb.go()) == 0x1000_0104
    assert stopped_at(gdb.go("s")) == 0x1000_0108
    assert gdb.register(3) == 77


def test_four_comparators_and_no_fifth(gdb):
    for n in range(4):
        gdb.ok(f"Z1,{0x10000040 + 4 * n:x},4")
    assert gdb.ask("Z1,10000080,4") == b"E0e"
    gdb.ok("z1,10000044,4")
    gdb.ok("Z1,10000080,4")
    assert "breakpoint 1: 0x10000080" in gdb.monitor("comparators")


LOAD, STORE = ("ldw", "ldh", "ldhu", "ldb", "ldbu"), ("stw", "sth", "stb")


@pytest.mark.parametrize("kind", ["watch", "rwatch", "awatch"])
def test_watchpoint__stops_behind_the_access_it_names(gdb, kind):
    """Each size at each byte of two words, against what the access touches."""
    size = {"w": 4, "h": 2, "b": 1}
    number = {"watch": 2, "rwatch": 3, "awatch": 4}[kind]
    gdb.write(0x1000_0100, code("addi", 2, 0, 0) * 8)
    gdb.set_register(4, DTCM + 0x600)
    gdb.ok(f"Z{number},{DTCM + 0x602:x},3")
    for name in (*LOAD, *STORE):
        width = size[name[2]]
        for offset in range(0, 8, width):
            gdb.write(0x1000_0104, code(name, 5, offset, 4))
            gdb.ok("Z1,10000110,4")
            gdb.set_register(PC, 0x1000_0100)
            reply = gdb.go()
            touched = offset < 5 and offset + width > 2
            wanted = kind == "awatch" or (kind == "watch") == (name in STORE)
            hit = touched and wanted
            assert stopped_at(reply) == (0x1000_0108 if hit else 0x1000_0110), (name, offset)
            assert (b"%s:%x;" % (kind.encode(), DTCM + 0x602) in reply) == hit
    gdb.ok(f"z{number},{DTCM + 0x602:x},3")
    assert "watchpoint 0: free" in gdb.monitor("comparators")


def test_watchpoint_of_a_whole_array_takes_one_comparator(gdb):
    gdb.ok(f"Z2,{DTCM + 0x800:x},400")
    assert gdb.monitor("comparators").count("watch 0x10040800, 1024 bytes") == 1
    assert gdb.ask(f"Z2,{DTCM + 0x7FD:x},412") == b"E0e"  # needs too many
    gdb.write(0x1000_0100, code("stw", 5, 0x3FC, 4) + code("stw", 5, 0x400, 4) * 3)
    gdb.set_register(4, DTCM + 0x800)
    gdb.set_register(PC, 0x1000_0100)
    assert stopped_at(gdb.go()) == 0x1000_0104
    gdb.ok("Z1,10000108,4")
    assert b"hwbreak" in gdb.go(), "the word behind the array is not watched"


def test_ctrl_c_halts_a_program_that_runs_on_and_on(gdb):
    gdb.write(0x1000_0100, code("br", -4))
    gdb.set_register(PC, 0x1000_0100)
    gdb.send(b"c")
    gdb.peer.sendall(b"\x03")
    reply = gdb.packet()
    assert reply.startswith(b"T02") and stopped_at(reply) == 0x1000_0100


@pytest.mark.parametrize("name", ["ldw", "stb"])
def test_access_outside_memory__stops_the_program(gdb, name):
    """As nios-run without GDB ends there with status 139."""
    gdb.write(0x1000_0100, code("addi", 2, 0, 1) + code(name, 5, 4, 4) + code("br", -4))
    gdb.set_register(4, 0x3000_0000)
    gdb.set_register(PC, 0x1000_0100)
    reply = gdb.go()
    assert reply.startswith(b"T0b") and 0x1000_0104 <= stopped_at(reply) <= 0x1000_0110
    gdb.set_register(4, DTCM)
    gdb.set_register(PC, 0x1000_0100)
    gdb.ok("Z1,10000108,4")
    assert stopped_at(gdb.go()) == 0x1000_0108, "and goes on"


def test_single_steps_follow_branches_calls_and_exceptions(gdb):
    at = [0x1000_0000]
    for _ in range(40):
        at.append(stopped_at(gdb.go("s")))
    assert at[1] == 0x1000_0004 and any(b != a + 4 for a, b in zip(at, at[1:], strict=False))
    gdb.write(0x1000_0100, code("trap", 0))
    gdb.set_register(PC, 0x1000_0100)
    assert stopped_at(gdb.go("vCont;s:1")) == 0x1000_0020, "into the exception handler"
    assert gdb.register(40) == 3 << 2  # exception: cause 3
    assert gdb.register(29) == 0x1000_0104  # ea


def test_break_of_the_program_stops_it_once(gdb):
    gdb.write(0x1000_0100, code("break", 5) + code("addi", 2, 0, 9) + code("br", -4))
    gdb.set_register(PC, 0x1000_0100)
    reply = gdb.go()
    assert stopped_at(reply) == 0x1000_0100 and b"swbreak" not in reply
    gdb.ok("Z1,10000108,4")
    assert stopped_at(gdb.go()) == 0x1000_0108


def test_end_of_the_program_with_its_status_and_text():
    session = debugged()
    with session as gdb:
        assert gdb.go() == b"W00"
        assert gdb.console.startswith(b"square root of 2 on FPGA2: 1.4142135, 27 cycles")
        with pytest.raises(EOFError):
            gdb.byte()
    assert session.status == 0


def test_extended__runs_again_after_its_end():
    with debugged("tests/set_jump") as gdb:
        gdb.ok("!")
        status = gdb.go()
        assert status[:1] == b"W"
        assert stopped_at(gdb.ask("vRun;")) == 0x1000_0000
        assert gdb.go() == status
        gdb.ok("vKill;1")


def test_reset_loads_the_program_again_but_not_over_another_one():
    with debugged("tests/set_jump") as gdb:
        main = program("tests/set_jump").address("main")
        gdb.ok(f"Z0,{main:x},4")
        gdb.go()
        gdb.write(DTCM, bytes(64))
        assert "set_jump is loaded" in gdb.monitor("reset")
        assert stopped_at(gdb.ask("?")) == 0x1000_0000
        assert gdb.read(DTCM, 64) == struct.pack(
            "<16I", *program("tests/set_jump").memories["dtcm"][:16]
        )
        assert stopped_at(gdb.go()) == main, "breakpoints are in the memory loaded anew"
        gdb.write(main, code("addi", 2, 0, 0))
        assert "`load` again" in gdb.monitor("reset")
        assert gdb.read(main, 4) == code("addi", 2, 0, 0)


def test_monitor__help_and_wrong_words(gdb):
    assert "monitor reset" in gdb.monitor("help")
    assert "no command 'fly'" in gdb.monitor("fly")
    assert "usage: monitor freeze [on|off]" in gdb.monitor("freeze never")
    assert "usage: monitor tick" in gdb.monitor("tick now")
    assert "a halted core stop" in gdb.monitor("freeze") and "continue" in gdb.monitor("freeze off")
    assert "takes interrupts" in gdb.monitor("interrupts on")
    assert "0 instructions since reset" in gdb.monitor("counters")
    gdb.go("s")
    assert "1 instructions since reset" in gdb.monitor("counters")


def test_connection_that_breaks_leaves_the_program_halted_for_the_next():
    session = debugged()
    with session as gdb:
        gdb.write(0x1000_0100, code("br", -4))
        gdb.set_register(PC, 0x1000_0100)
        gdb.send(b"c")  # and away, in the middle of a packet
        gdb.peer.sendall(b"$m1000")
    assert session.status is None and "connection lost" in session.said[-1]
    with session as gdb:
        assert stopped_at(gdb.ask("?")) == 0x1000_0100


def test_detached_program_runs_on_without_breakpoints():
    session = debugged()
    with session as gdb:
        gdb.ok(f"Z0,{program('run/demo_hello_fpga2').address('main'):x},4")
        gdb.ok("Z1,10000008,4")
        gdb.ok("D")
        with pytest.raises(EOFError):
            gdb.byte()
    assert session.status is None and session.server.running
    status = None
    while status is None:
        status = session.server.run_alone()
    assert status == 0


@pytest.mark.parametrize("packet", ["qCRCx", "qCx", "qAttachedx", "vContx", "vKillx", "vRunx"])
def test_packet_whose_name_begins_as_a_known_one__has_the_empty_answer(gdb, packet):
    assert gdb.ask(packet) == b""


def test_checksum_of_memory__as_gdb_computes_it(gdb):
    """The check value of this CRC is that of the catalogues for the text 123456789."""
    gdb.write(DTCM + 0x701, b"123456789")
    assert gdb.ask(f"qCRC:{DTCM + 0x701:x},9") == b"C0376e6e7"
    assert gdb.ask("qCRC:0,4") == b"E0e" and gdb.ask("qCRC:x") == b"E16"
    assert gdb.ask("qC") == b"QC1"
