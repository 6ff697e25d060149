# SPDX-License-Identifier: Apache-2.0
"""`nios-run --gdb` as a server: its place, one debugger after the other, its end."""

from __future__ import annotations

import socket
import threading

import pytest

from sim.debug.gdb.server import Connection, Server, ServerError, place_of, serve
from sim.debug.gdb.system import NiosSystem
from sim.debug.nios_run import main
from sim.rtl.nios_image import IMAGES, read_elf
from sim.rtl.nios_rtl import NiosRtl
from tests.gdb.client import TIMEOUT, Client, framed, listening, stopped_at, system

HELLO = read_elf(IMAGES / "run/demo_hello_fpga2.elf")


def test_place__host_and_port():
    assert place_of(":1234") == place_of("1234") == ("127.0.0.1", 1234)
    assert place_of("0.0.0.0:1") == ("0.0.0.0", 1)


@pytest.mark.parametrize("place", ["", "host", ":x", ":70000", "host:-1"])
def test_wrong_place_is_refused_with_the_form(place, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--gdb", place, "hello.elf"])
    assert ended.value.code == 2
    assert f"'{place}' is no [HOST]:PORT, and not -" in capsys.readouterr().err


def test_program_is_needed_without_gdb_and_no_profile_with_it(capsys):
    for arguments, text in (([], "required: program"), (["--gdb", "0", "--profile"], "not with")):
        with pytest.raises(SystemExit) as ended:
            main(arguments)
        assert ended.value.code == 2
        assert text in capsys.readouterr().err


def test_port_that_is_taken_is_an_error_with_its_cure():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        place = f":{taken.getsockname()[1]}"
        with pytest.raises(ServerError, match="cannot listen at 127.0.0.1.*choose another"):
            serve(NiosRtl("fpga2", debug=True), HELLO, place, print)


def test_two_debuggers_one_after_the_other_over_tcp():
    """The first goes without a word, the second detaches, the program ends by itself."""
    server, said, status = listening(NiosRtl("fpga2", debug=True), HELLO, ":0")
    host, _, port = said[0].rpartition(" ")[2].partition(":")
    main_at = HELLO.address("main")
    with socket.create_connection((host, int(port))) as peer:
        gdb = Client(peer)
        gdb.ok(f"Z1,{main_at:x},4")
        assert stopped_at(gdb.go()) == main_at
        gdb.ok(f"Z0,{main_at + 4:x},4")
    with socket.create_connection((host, int(port))) as peer:
        gdb = Client(peer)
        assert stopped_at(gdb.ask("?")) == main_at
        assert "breakpoint 0: free" in gdb.monitor("comparators"), "of the one before"
        gdb.ok("D")
    server.join(TIMEOUT)
    assert status == [0] and any("connection lost" in text for text in said)


def test_first_packet_sent_again_while_the_server_starts__is_answered_once():
    """GDB repeats a packet every two seconds; two answers would shift all that follow."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.sendall(b"+" + 3 * framed(b"qSupported:swbreak+"))
        server = Server(NiosSystem(system(), HELLO), print)
        fd = theirs.fileno()
        thread = threading.Thread(target=server.serve, args=(Connection(fd, fd, False),))
        thread.start()
        gdb = Client(ours)
        assert gdb.byte() == b"+" and gdb.packet().startswith(b"PacketSize=")
        assert gdb.ask("vMustReplyEmpty") == b""
        gdb.ok("D")
        thread.join(TIMEOUT)
        assert not thread.is_alive()
