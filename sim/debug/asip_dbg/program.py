# SPDX-License-Identifier: Apache-2.0
"""The program under the debugger: image, debug map, and the lines of its sources."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from asip_asm.assemble import build_program, encode
from asip_asm.debug_map import FILE_BYTES, DebugMap, Finder, Value, map_path
from asip_asm.debug_values import debug_map
from asip_asm.disassemble import bundle_text, decode_bundle
from asip_asm.files import read_bytes
from asip_asm.image import SourceEntry
from asip_asm.ir import ZERO
from asip_asm.isa import default_isa
from sim.debug.asip_run.inputs import image_of_file


class ProgramError(Exception):
    """The program cannot be debugged; the message names file, cause and cure."""


@dataclass(frozen=True)
class Call:
    """A macro call: its name, file and line."""

    name: str
    file: str
    line: int


class DebuggedProgram:
    """A program with its map.

    Raises AssemblyError, ImageError, DebugMapError, ProgramError, UserError, OSError.
    """

    def __init__(
        self,
        path: Path,
        configuration: str | None = None,
        optimise: bool = True,
        function: str | None = None,
    ) -> None:
        self.path = path
        if path.suffix == ".json":
            self.image = image_of_file(path, configuration)
            beside = map_path(path)
            if self.image.functions and function is None:
                names = ", ".join(function.name for function in self.image.functions)
                raise ProgramError(f"{path} holds several functions; --function one of: {names}")
            if function is not None:
                self.image = self.image.function(function)
                beside = beside.with_name(beside.name.replace(".asip.", f".{function}.asip.", 1))
            if not beside.exists():
                raise ProgramError(
                    f"{beside}: not there; asip-as and asip-model write it next to the image: "
                    "build the program again, or give its source in place of the image"
                )
            self.map = DebugMap.load(beside, self.image)
        else:
            if function is not None:
                raise ProgramError(f"{path}: --function is for an image of several functions")
            program, machine = build_program(path, configuration=configuration, optimise=optimise)
            self.image = encode(program, machine, path)
            self.map = debug_map(program, machine, self.image)
        self.finder = Finder(self.map)
        self.bundles = self.map.bundles
        self.main = next(iter(self.map.files), "")
        self._lines: dict[str, list[str]] = {}

    # ------------------------------------------------------------------ bundles
    def entries(self, bundle: int) -> list[SourceEntry]:
        """Operations of a bundle as the sources wrote them; none for an address outside."""
        return self.image.sources[bundle] if 0 <= bundle < self.bundles else []

    def primary(self, bundle: int) -> SourceEntry | None:
        """The operation that represents a bundle: that of the lowest slot."""
        return min(self.entries(bundle), key=lambda entry: entry.slot, default=None)

    def calls(self, bundle: int, slot: int) -> list[Call]:
        """Macro calls that an operation comes from, innermost first."""
        found = []
        for text in self.map.calls.get(f"{bundle}.{slot}", ()):
            name, _, place = text.partition(" at ")
            file, _, line = place.rpartition(":")
            found.append(Call(name, file, int(line) if line.isdecimal() else 0))
        return found

    def cycle(self, bundle: int) -> int | None:
        """Cycle in which a bundle issues in a run without branches."""
        branches = any(follow != [self.bundles] for follow in self.map.follow.values())
        return self.map.cycles[bundle] if not branches and bundle < self.bundles else None

    def text(self, bundle: int) -> str:
        """A bundle as the disassembler writes it."""
        isa = default_isa()
        decoded = decode_bundle(int(self.image.bundles[bundle], 16), self.image.configuration, isa)
        labels = {address: name for name, address in self.image.labels.items()}
        names = {a: labels.get(a, str(a)) for a in range(isa.program_bundles)}
        return bundle_text(decoded, isa, names)

    def is_vector(self, value: Value) -> bool:
        """Whether an operation in all lanes of its pipe writes this value."""
        return any((write.bundle, write.slot) in self._vectors for write in value.writes)

    @cached_property
    def _vectors(self) -> set[tuple[int, int]]:
        """Bundles and slots of operations that write a register in all lanes."""
        isa, found = default_isa(), set()
        vectors = {op.name for op in isa.of_unit("lanes") if "lane" not in op.operands}
        for bundle, word in enumerate(self.image.bundles):
            slots = decode_bundle(int(word, 16), self.image.configuration, isa).slots
            for slot, operation in enumerate(slots):
                if operation is not None and operation.mnemonic in vectors:
                    found.add((bundle, slot))
        return found

    def stores(self, address: int) -> list[int]:
        """Bundles with a store that may write a data word: its address is this or is computed."""
        isa, found = default_isa(), []
        for bundle, word in enumerate(self.image.bundles):
            slots = decode_bundle(int(word, 16), self.image.configuration, isa).slots
            for operation in filter(None, slots):
                if isa.operations[operation.mnemonic].control.get("store"):
                    if operation.b != ZERO or operation.imm == address:
                        found.append(bundle)
        return found

    # ------------------------------------------------------------------ sources
    def lines(self, file: str) -> list[str]:
        """Lines of a source; none if it cannot be read."""
        if file not in self._lines:
            text = self._read(file).decode("utf-8-sig", errors="replace")
            self._lines[file] = text.splitlines()
        return self._lines[file]

    def source_path(self, file: str) -> Path:
        """Where a source is, or would be."""
        return self._found(file) or Path(file)

    def _found(self, file: str) -> Path | None:
        """A source: its path was written in the folder of the assembly, which may be this one, that
        of the image, or the one above it.

        An image from a stranger may name any file: one in another place counts as missing.
        """
        if self.path.suffix != ".json":
            return Path(file)  # the program's own text named it
        here = self.path.resolve().parent
        inside = [Path.cwd(), here]
        if ".." not in Path(file).parts and not os.path.isabs(file):
            inside.append(here.parent)
        for folder in (Path(), here, here.parent):
            real = (folder / file).resolve()
            if real.is_file() and any(real.is_relative_to(each) for each in inside):
                return folder / file
        return None

    def _read(self, file: str) -> bytes:
        """Content of a source; none if it cannot be read."""
        found = self._found(file)
        try:
            return b"" if found is None else read_bytes(found, FILE_BYTES, "a source")
        except OSError:
            return b""

    def changed_files(self) -> list[str]:
        """Sources that are not what was assembled any more, missing ones included."""
        changed = []
        for file, digest in self.map.files.items():
            if hashlib.sha256(self._read(file)).hexdigest() != digest:
                changed.append(file)
        return changed

    def file_of(self, name: str) -> str | None:
        """The source that a user names by path, or by its last parts."""
        wanted = Path(name)
        for file in self.map.files:
            if file == name or self.source_path(file).resolve() == wanted.resolve():
                return file
        parts = wanted.parts
        ends = [f for f in self.map.files if Path(f).parts[-len(parts) :] == parts]
        return ends[0] if len(ends) == 1 else None

    def code_lines(self, file: str) -> dict[int, list[int]]:
        """By line of a source, the first bundle of each of its appearances.

        An operation of a macro belongs to its own line and to those of the calls. A line of several
        bundles, as a call is, counts with its first; a macro's line counts once per call.
        """
        found: dict[int, dict[tuple[Call, ...], int]] = {}
        for bundle in range(self.bundles):
            for entry in self.entries(bundle):
                calls = self.calls(bundle, entry.slot)
                places = [(entry.file, entry.line), *((call.file, call.line) for call in calls)]
                for depth, (where, line) in enumerate(places):
                    if where == file:
                        found.setdefault(line, {}).setdefault(tuple(calls[depth:]), bundle)
        return {line: sorted(set(ways.values())) for line, ways in found.items()}

    def equations(self) -> dict[str, list[int]]:
        """By equation, the bundles with an operation of it, in order of address."""
        found: dict[str, list[int]] = {}
        for bundle in range(self.bundles):
            for name in dict.fromkeys(entry.equation for entry in self.entries(bundle)):
                for part in name.split(","):
                    if part.strip():
                        found.setdefault(part.strip(), []).append(bundle)
        return found
