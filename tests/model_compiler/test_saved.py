# SPDX-License-Identifier: Apache-2.0
"""Saved functions from a stranger: nothing of them runs, whatever they hold."""

from __future__ import annotations

import os
import socket
import subprocess
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from asip_asm.model.confined import Confined, confined
from asip_asm.model.read import ModelError
from asip_asm.model.saved import inspect, load_saved
from sim.laws.asip_model.__main__ import main

CODE = """
#include <fcntl.h>
__attribute__((constructor)) static void run(void) { open("%s", O_CREAT, 0600); }
"""
RECORD = """
title = "hostile"
[[input]]
names = ["x"]
unit = "1"
meaning = "number"
[[output]]
names = ["y"]
unit = "1"
safe = 0
meaning = "number"
"""
SHELL = {
    "jit": True,
    "compiler": "shell",
    "jit_serialize": "source",
    "jit_options": {"compiler": "date >> PWNED; gcc"},
}
X, MX = ca.SX.sym("x"), ca.MX.sym("x")


def plain(options: dict | None = None) -> ca.Function:
    return ca.Function("f", [X], [ca.sin(X)], ["x"], ["y"], options or {})


def around(inner: ca.Function) -> ca.Function:
    return ca.Function("g", [MX], [inner(MX)], ["x"], ["y"])


def external(folder: Path) -> ca.Function:
    source = plain().generate("f.c")
    text = CODE % (folder / "PWNED") + Path(source).read_text()
    Path("x.c").write_text(text)
    subprocess.run(["cc", "-shared", "-fPIC", "x.c", "-o", "x.so", "-lm"], check=True)
    return ca.external("f", "./x.so")


def importer(_: Path) -> ca.Function:
    plain().generate("f.c")
    return ca.external("f", ca.Importer("f.c", "shell"))


class Callback(ca.Callback):
    def __init__(self) -> None:
        ca.Callback.__init__(self)
        self.construct("c", {})

    def eval(self, arguments):
        return arguments


def in_map(folder: Path) -> ca.Function:
    many = external(folder).map(2)
    return ca.Function("g", [MX], [many(ca.horzcat(MX, MX))[0]], ["x"], ["y"])


def in_switch(folder: Path) -> ca.Function:
    index = ca.MX.sym("i")
    chosen = ca.Function.conditional("s", [external(folder)], plain(SHELL))
    return ca.Function("g", [MX, index], [chosen(index, MX)], ["x", "i"], ["y"])


def solver(_: Path) -> ca.Function:
    problem = {"x": X, "g": ca.sin(X) - 0.5}
    return ca.rootfinder("r", "newton", problem)


CALLBACKS: list[Callback] = []


def callback(_: Path) -> ca.Function:
    CALLBACKS.append(Callback())
    return around(CALLBACKS[-1])


HOSTILE: dict[str, tuple[Callable[[Path], ca.Function], str]] = {
    "jit": (lambda _: plain(SHELL), "has the option jit"),
    "jit, no options": (lambda _: plain({"jit": True, "compiler": "shell"}), "the option jit"),
    "options alone": (lambda _: plain({"jit_options": {"flags": "-O3"}}), "jit_options"),
    "jit of a link": (lambda _: plain(SHELL | {"jit_serialize": "link"}), "compiled by jit"),
    "jit of a binary": (lambda _: plain(SHELL | {"jit_serialize": "embed"}), "compiled by jit"),
    "jit in a call": (lambda _: around(plain(SHELL)), "the option jit"),
    "jit of MX": (lambda _: ca.Function("g", [MX], [MX], ["x"], ["y"], SHELL), "the option jit"),
    "jit in a fold": (lambda _: plain(SHELL).mapaccum(3), "the option jit"),
    "jit in a map": (lambda _: plain(SHELL).map(3), "the option jit"),
    "library": (external, "holds 'External': an external library"),
    "library in a call": (lambda folder: around(external(folder)), "holds 'External'"),
    "library in a map": (in_map, "holds 'External'"),
    "library in a switch": (in_switch, "holds 'External'"),
    "importer": (importer, "holds '(External|ShellCompiler)'"),
    "importer in a call": (lambda folder: around(importer(folder)), "holds "),
    "callback": (callback, "holds 'CallbackInternal': a callback"),
    "solver": (solver, "holds 'Rootfinder': a solver"),
    "interpolant": (
        lambda _: ca.interpolant("i", "linear", [[0, 1, 2]], [0, 1, 4]),
        "holds 'Interpolant'",
    ),
}


@pytest.fixture
def saved(tmp_path, monkeypatch) -> Callable[[str], bytes]:
    """Bytes of a hostile file, made in a folder in which nothing has run afterwards."""
    monkeypatch.chdir(tmp_path)

    def make(name: str) -> bytes:
        HOSTILE[name][0](tmp_path).save("law.casadi")
        Path("PWNED").unlink(missing_ok=True)
        Path("law.toml").write_text(RECORD)
        return Path("law.casadi").read_bytes()

    return make


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_refused_by_name_before_casadi_opens_it(name, saved, capsys):
    content = saved(name)
    files = sorted(os.listdir())
    with pytest.raises(ModelError, match=HOSTILE[name][1]):
        inspect(Path("law.casadi"), content)
    assert main(["law.casadi", "law.toml"]) == 1
    assert "law.casadi: " in capsys.readouterr().err
    assert sorted(os.listdir()) == files and "PWNED" not in files


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_does_nothing_without_the_inspection(name, saved, monkeypatch):
    """The child alone holds what the inspection would let through: a hidden name, for instance."""
    saved(name)
    files = sorted(os.listdir())
    monkeypatch.setattr("asip_asm.model.saved.inspect", lambda *_: None)
    try:
        load_saved(Path("law.casadi"))
    except ModelError as error:
        assert "law.casadi" in str(error)
    assert sorted(os.listdir()) == files and "PWNED" not in files


def test_plain_functions_are_read_whatever_they_are_made_of(tmp_path):
    pair = ca.MX.sym("p", 2)
    inverse = ca.solve(2 * ca.MX.eye(2) + pair @ pair.T, pair, "symbolicqr")
    for k, function in enumerate(
        (
            plain(),
            around(plain()),
            plain().map(3),
            plain().mapaccum(3),
            ca.Function.if_else("s", plain(), plain()),
            ca.Function("h", [pair], [inverse], ["p"], ["y"]),
        )
    ):
        file = tmp_path / f"{k}.casadi"
        function.save(str(file))
        assert load_saved(file).scalars.instructions


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nothing", "not a file of casadi.Function.save"),
        ("", "not a file of casadi.Function.save"),
        ("jhpnnagiieahaaaadaaaaaaaaaaaaaaaaaaaaaaaa", "not a file of casadi.Function.save"),
        ("debug", "saved with the option debug"),
        ("matrix", "not a law"),
    ],
)
def test_what_is_no_saved_function_is_refused(text, message, tmp_path):
    file = tmp_path / "x.casadi"
    if text == "debug":
        plain().save(str(file), {"debug": True})
    elif text == "matrix":
        ca.DM([1, 2]).to_file(str(tmp_path / "m.mtx"))
        serializer = ca.FileSerializer(str(file))
        serializer.pack(ca.DM([1, 2]))
        del serializer
    else:
        file.write_text(text)
    with pytest.raises(ModelError, match=message):
        load_saved(file)


FORBIDDEN: dict[str, Callable[[], object]] = {
    "program": lambda: os.execv("/bin/true", ["true"]),
    "shell": lambda: os.system("true"),
    "process": os.fork,
    "socket": socket.socket,
    "signal": lambda: os.kill(os.getppid(), 0),
}


@pytest.mark.parametrize("name", FORBIDDEN)
def test_the_confined_child_ends_at(name):
    with pytest.raises(Confined, match="tried to start a program or a process, or to open a conn"):
        confined(lambda: str(FORBIDDEN[name]()).encode())


def test_the_confined_child_opens_no_file_and_makes_no_code(tmp_path):
    import mmap

    for work in (
        lambda: open("/etc/passwd", "rb").read(),
        lambda: (tmp_path / "new").write_text("x"),
        lambda: os.unlink(__file__),
        lambda: mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_EXEC),
    ):
        with pytest.raises(Confined, match="Operation not permitted"):
            confined(lambda work=work: bytes(work() and b"done"))
    assert confined(lambda: np.ones(3).tobytes()) == np.ones(3).tobytes()


def test_the_confined_child_has_limits_of_memory_and_its_error_is_said():
    with pytest.raises(Confined, match="MemoryError"):
        confined(lambda: bytes(1 << 30))
    with pytest.raises(Confined, match="by zero"):
        confined(lambda: bytes(1 // 0))


def test_the_confined_child_has_a_limit_of_time():
    def for_ever() -> bytes:
        while True:
            pass

    with pytest.raises(Confined, match="takes more than 1 s"):
        confined(for_ever, seconds=1)


def test_the_confined_child_has_no_file_of_its_parent(tmp_path, capfd):
    """Not one with a high number either, and what it prints goes nowhere."""
    (tmp_path / "secret").write_text("secret")
    with (tmp_path / "secret").open() as file:
        numbers = [file.fileno(), os.dup2(file.fileno(), 300), os.dup2(file.fileno(), 19_999)]
        for number in numbers:
            with pytest.raises(Confined, match="Bad file descriptor"):
                confined(lambda number=number: os.pread(number, 6, 0))
        for number in numbers[1:]:
            os.close(number)
    assert confined(lambda: str(os.write(1, b"said") + os.write(2, b"said")).encode()) == b"8"
    assert confined(lambda: b"-" + os.read(0, 1)) == b"-"
    assert capfd.readouterr() == ("", "")
