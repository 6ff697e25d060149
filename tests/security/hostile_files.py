# SPDX-License-Identifier: Apache-2.0
"""Hostile files for every reader, and what is observed while a command opens one.

Each file tries to start a command that makes the file PWNED, to open the canary (the kernel
reports that, whatever program or library does it), or to bring the canary's text to the output.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import io
import json
import os
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from asip_asm import cli_as, cli_objdump
from asip_asm.assembly_text import quoted
from asip_asm.image import checksum
from sim.bench.run import __main__ as main_job
from sim.debug import nios_run
from sim.debug.asip_dbg import __main__ as asip_dbg
from sim.debug.asip_run import __main__ as asip_run
from sim.laws.asip_model import __main__ as asip_model
from sim.robot.parameters import ROBOT_TOML
from sim.rtl.nios_image import IMAGES
from tests.model_compiler.robot_text import ARM
from tests.model_compiler.test_saved import HOSTILE, RECORD, plain

SECRET = "the-canary-sings"
MARK = "PWNED"
RUN = f"touch {MARK}"
IN_OPEN = 0x20
SOURCE = '.program "x"\n.input x\n.output F, safe = 0.0\n fmul y, x, x\n mov F, y\n halt\n'
PATH = "G21 G90 G64 P0.01\nG1 X4 A2 F1200\nX8 Y3 C6\n{}\nM2\n"


@dataclass(frozen=True)
class Case:
    """A file of a reader. `make` writes it into the working folder; `open` gives it to a command.

    refused: whether the command must end with an error; the others may take the file as data.
    """

    name: str
    make: Callable[[Path], object]
    open: Callable[[], object]
    refused: bool = False


@dataclass(frozen=True)
class Seen:
    """What a case did: commands that ran, opened canaries, its text in an output."""

    executed: bool
    read: bool
    shown: bool
    status: object


class Watch:
    """Counts how often any process opens a file, by inotify."""

    def __init__(self, file: Path) -> None:
        libc = ctypes.CDLL(None, use_errno=True)
        self._descriptor = libc.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        if self._descriptor < 0 or libc.inotify_add_watch(
            self._descriptor, os.fsencode(file), IN_OPEN
        ) < 0:  # fmt: skip
            raise OSError(ctypes.get_errno(), "inotify", str(file))

    def opened(self) -> bool:
        """Whether it was opened since the last call."""
        try:
            return bool(os.read(self._descriptor, 1 << 16))
        except BlockingIOError:
            return False

    def close(self) -> None:
        os.close(self._descriptor)


def observe(case: Case, folder: Path) -> Seen:
    """Open a case in an empty folder."""
    work = folder / "work"
    work.mkdir(parents=True)
    canary = folder / "canary.inc"
    canary.write_text(f"{SECRET}\n")
    watch, said = Watch(canary), io.StringIO()
    with contextlib.chdir(work):
        case.make(canary)
        Path(MARK).unlink(missing_ok=True)
        watch.opened()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            try:
                status = case.open()
            except SystemExit as stop:
                status = stop.code
        read = watch.opened()
        watch.close()
        texts = [path.read_bytes() for path in folder.rglob("*") if _output(path, canary)]
        shown = SECRET in said.getvalue() or any(SECRET.encode() in text for text in texts)
        executed = any(path.name == MARK for path in folder.rglob("*"))
    return Seen(executed, read, shown, status)


def _output(path: Path, canary: Path) -> bool:
    return path.is_file() and path != canary


# ---------------------------------------------------------------------- readers
def _write(name: str, text: str | Callable[[Path], str]) -> Callable[[Path], object]:
    def make(canary: Path) -> None:
        content = text if isinstance(text, str) else text(canary)
        Path(name).write_text(content, encoding="utf-8")

    return make


def _saved(name: str) -> Case:
    def make(_: Path) -> None:
        HOSTILE[name][0](Path.cwd()).save("law.casadi")
        Path("law.toml").write_text(RECORD)

    return Case(f"saved function: {name}", make, _model("law.casadi", "law.toml"), True)


def _model(*words: str) -> Callable[[], object]:
    return lambda: asip_model.main([*words, "-o", "out"])


def _interface(name: str, change: Callable[[str, Path], str], refused: bool = False) -> Case:
    def make(canary: Path) -> None:
        plain().save("law.casadi")
        Path("law.toml").write_text(change(RECORD, canary), encoding="utf-8")

    return Case(f"interface record: {name}", make, _model("law.casadi", "law.toml"), refused)


def _urdf(name: str, change: Callable[[str, Path], str], refused: bool = False) -> Case:
    return Case(
        f"URDF: {name}",
        _write("arm.urdf", lambda canary: change(ARM, canary)),
        _model("arm.urdf", "--law", "gravity_compensation"),
        refused,
    )


def _doctype(inside: str, use: str = "") -> Callable[[str, Path], str]:
    def change(text: str, canary: Path) -> str:
        head, _, rest = text.partition("\n")
        rest = rest.replace('name="arm">', f'name="arm">{use}', 1)
        return f"{head}\n<!DOCTYPE robot {inside.format(canary=canary)}>\n{rest}"

    return change


def _geometry(inner: str) -> Callable[[str, Path], str]:
    box = '<box size="1 1 1"/>'
    return lambda text, canary: text.replace(box, inner.format(canary=canary))


def _in_link(inner: str) -> Callable[[str, Path], str]:
    base = '<link name="base"/>'
    return lambda text, canary: text.replace(base, base + inner.format(canary=canary))


def _source(name: str, line: str) -> Case:
    def make(canary: Path) -> None:
        Path("x.s").write_text(line.format(canary=canary) + "\n" + SOURCE)

    return Case(f"assembly: {name}", make, lambda: cli_as.main(["x.s", "-o", "x.json"]), True)


def _image(name: str, command: Callable[[], object], **fields: str) -> Case:
    """An image and its debug map, with right checksums, that name the canary as their source."""

    def make(canary: Path) -> None:
        Path("x.s").write_text(SOURCE)
        assert cli_as.main(["x.s", "-o", "x.asip.json"]) == 0
        texts = {key: text.format(canary=canary) for key, text in fields.items()}
        image = _named(json.loads(Path("x.asip.json").read_text()), texts)
        Path("x.asip.json").write_text(json.dumps(image | {"checksum": checksum(image)}))
        digest = hashlib.sha256(canary.read_bytes()).hexdigest()
        known = json.loads(Path("x.asip.map.json").read_text())
        known = _named(known, texts) | {"image": checksum(image)}
        known["files"] = {str(canary): digest}
        Path("x.asip.map.json").write_text(json.dumps(known))
        Path("x.s").unlink()

    return Case(f"image: {name}", make, command)


def _named(data: object, fields: dict[str, str]) -> object:
    """The data with each text field of these names replaced, at any depth."""
    if isinstance(data, dict):
        return {
            key: fields[key] if key in fields and isinstance(value, str) else _named(value, fields)
            for key, value in data.items()
        }
    return [_named(value, fields) for value in data] if isinstance(data, list) else data


def _elf(name: str, content: Callable[[], bytes], refused: bool) -> Case:
    def make(_: Path) -> None:
        Path("x.elf").write_bytes(content())
        Path("x.elf").chmod(0o755)

    return Case(f"ELF: {name}", make,
                lambda: nios_run.main(["--max-cycles", "2000", "x.elf"]), refused)  # fmt: skip


def _gcode(name: str, line: str) -> Case:
    def make(canary: Path) -> None:
        Path("part.ngc").write_text(PATH.format(line.format(canary=canary)))
        for program in ("M101", "user.ngc", "sub.ngc"):
            Path(program).write_text(f"#!/bin/sh\n{RUN}\n")
            Path(program).chmod(0o755)

    return Case(f"G-code: {name}", make, lambda: main_job.main(["part.ngc", "--plan-only"]))


def _job(name: str, file: str, option: str, text: Callable[[Path], str]) -> Case:
    def make(canary: Path) -> None:
        Path("part.ngc").write_text(PATH.format("T1 M6 G43"))
        Path(file).write_text(text(canary), encoding="utf-8")

    return Case(name, make, lambda: main_job.main(["part.ngc", option, file, "--plan-only"]), True)


def _table(name: str, text: str) -> Case:
    def make(canary: Path) -> None:
        Path("x.s").write_text(SOURCE)
        Path("x.csv").write_text(text.format(canary=canary))

    return Case(f"table of inputs: {name}", make,
                lambda: asip_run.main(["x.s", "--iss", "--inputs", "x.csv"]), True)  # fmt: skip


def _capture(name: str, content: bytes) -> Case:
    def make(_: Path) -> None:
        Path("x.json").write_bytes(content)

    return Case(f"recording as image: {name}", make, lambda: cli_objdump.main(["x.json"]), True)


def _dump() -> object:
    return cli_objdump.main(["x.asip.json"])


def _debug() -> object:
    Path("script.dbg").write_text("run\nlist\ninfo values\nquit\n")
    return asip_dbg.main(["x.asip.json", "--iss", "-x", "script.dbg", "--batch"])


def _profile() -> object:
    gantt = ["--profile", "--gantt", "g.html", "--konata", "k.log"]
    return asip_run.main(["x.asip.json", *gantt])


PICKLE = b"cposix\nsystem\n(S'" + RUN.encode() + b"'\ntR."
ENTITY = '[<!ENTITY x SYSTEM "file://{canary}">]'
CASES = (
    *(_saved(name) for name in HOSTILE),
    _interface("directive in title",
               lambda t, c: t.replace('"hostile"', json.dumps(f'x"\n.include "{c}"\n;'))),
    _interface("directive in meaning",
               lambda t, c: t.replace('"number"', json.dumps(f'x\n.include "{c}"'))),
    _interface("directive in unit",
               lambda t, c: t.replace('"1"', json.dumps(f'1\n.include "{c}"'))),
    _interface("directive in name",
               lambda t, c: t.replace('["x"]', json.dumps([f'x\n.include "{c}"'])), True),
    _interface("unknown include", lambda t, c: f"source = {quoted(str(c))}\n{t}", True),
    _urdf("external entity", _doctype(ENTITY, "&x;"), True),
    _urdf("parameter entity", _doctype('[<!ENTITY % x SYSTEM "file://{canary}"> %x;]'), True),
    _urdf("external document type", _doctype('SYSTEM "file://{canary}"'), True),
    _urdf("entity in an attribute", _doctype(ENTITY, '<link name="&x;"/>'), True),
    _urdf("mesh of a file", _geometry('<mesh filename="file://{canary}"/>')),
    _urdf("mesh of a path", _geometry('<mesh filename="{canary}"/>')),
    _urdf("mesh of a package", _geometry('<mesh filename="package://../{canary}"/>')),
    _urdf("texture", _in_link('<material name="m"><texture filename="{canary}"/></material>')),
    _urdf("xinclude", _in_link('<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" '
                               'href="file://{canary}" parse="text"/>')),
    _urdf("xacro include", _in_link('<xacro:include xmlns:xacro="http://www.ros.org/wiki/xacro" '
                                    'filename="{canary}"/>')),
    _urdf("style sheet", lambda t, c: t.replace("?>\n", f'?>\n<?xml-stylesheet href="{c}"?>\n', 1)),
    _urdf("plugin", _in_link('<gazebo><plugin name="p" filename="{canary}"/></gazebo>')),
    _urdf("directive in a name",
          lambda t, c: t.replace('"shoulder"', f'"a&#10;.include &quot;{c}&quot;"')),
    _source("include of a path", '.include "{canary}"'),
    _source("include of a folder above", '.include "../canary.inc"'),
    _source("parameters of a path", '.params "{canary}"'),
    _source("interface of a path", '.interface "{canary}"'),
    _image("source of another file, dump", _dump, file="{canary}", source="{canary}"),
    _image("source of another file, debugger", _debug, file="{canary}", source="{canary}"),
    _image("source of another file, profile", _profile, file="{canary}", source="{canary}"),
    _image("command in its texts", _dump, text=f"$({RUN})", title=f"`{RUN}`"),
    _capture("pickle", PICKLE),
    _capture("parquet", b"PAR1" + PICKLE + b"PAR1"),
    _capture("nested", b"[" * 100_000),
    _elf("script", lambda: f"#!/bin/sh\n{RUN}\n".encode(), True),
    _elf("program of this machine", lambda: Path(shutil.which("true") or "").read_bytes(), True),
    _elf("cut", lambda: (IMAGES / "tests/sieve.elf").read_bytes()[:3000], True),
    _gcode("program by M101", "M101 P1 Q2"),
    _gcode("subroutine of a file", "o<sub> call"),
    _gcode("subroutine of a path", "o<{canary}> call"),
    _gcode("log file", "(LOGOPEN,{canary})\n(LOG,x)"),
    _gcode("probe file", "(PROBEOPEN {canary})"),
    _job("tool table: path", "tool.tbl", "--tools", lambda c: f"include {c}\nT1 P1 Z$({RUN})\n"),
    _job("robot: unknown field", "robot.toml", "--robot",
         lambda c: f'include = "{c}"\n' + ROBOT_TOML.read_text(encoding="utf-8")),
    _job("robot: formula", "robot.toml", "--robot",
         lambda c: ROBOT_TOML.read_text(encoding="utf-8").replace(
             "value = ", f"value = \"__import__('os').system('{RUN}')\" # ", 1)),
    _table("formula", "x\n=cmd|'{canary}'!A0\n"),
    _table("code", f"x\n__import__('os').system('{RUN}')\n"),
)  # fmt: skip
LEAST = 40


def outcomes(folder: Path) -> Iterator[tuple[Case, Seen]]:
    """Every case in a folder of its own."""
    for n, case in enumerate(CASES):
        yield case, observe(case, folder / str(n))
