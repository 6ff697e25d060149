# SPDX-License-Identifier: Apache-2.0
"""Program images: the JSON file that every tool reads, and memory formats of the program alone."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from asip_asm.isa import Isa, default_isa

FORMAT = "microtick-asip-image"
VERSION = 1
HEX_RECORD_BYTES = 16


class ImageError(ValueError):
    """The file is no program image; the message names the file and what is wrong."""


@dataclass(frozen=True)
class SourceEntry:
    """Operation of a bundle as the source wrote it."""

    slot: int
    op: str
    text: str
    file: str
    line: int
    equation: str


@dataclass(frozen=True)
class ConstantEntry:
    """Constant of bank K: type 'float' or 'int', bits in hexadecimal."""

    name: str
    index: int
    type: str
    bits: str


@dataclass(frozen=True)
class InputEntry:
    """Input of bank K."""

    name: str
    index: int
    type: str


@dataclass(frozen=True)
class OutputEntry:
    """Output word; `safe` are the bits in hexadecimal that it takes after a fault."""

    name: str
    index: int
    safe: str


@dataclass(frozen=True)
class StateEntry:
    """State register and the bits that the host presets."""

    name: str
    register: str
    type: str
    bits: str


@dataclass(frozen=True)
class ExportEntry:
    """Register that the host can read after a run; of bank K: an input."""

    name: str
    register: str


ENTRY_TYPES: dict[str, Any] = {
    "constants": ConstantEntry,
    "inputs": InputEntry,
    "outputs": OutputEntry,
    "states": StateEntry,
    "exports": ExportEntry,
}


@dataclass
class Image:
    """Program image. `bundles` are hexadecimal words, `sources` the operations of each bundle,
    `cycles` the estimated cycles of a run without branches (None with branches).
    """

    title: str
    configuration: str
    bundles: list[str]
    sources: list[list[SourceEntry]]
    entry: int = 0
    constants: list[ConstantEntry] = field(default_factory=list)
    inputs: list[InputEntry] = field(default_factory=list)
    outputs: list[OutputEntry] = field(default_factory=list)
    states: list[StateEntry] = field(default_factory=list)
    exports: list[ExportEntry] = field(default_factory=list)
    data: list[str] = field(default_factory=list)
    data_names: dict[str, int] = field(default_factory=dict)
    labels: dict[str, int] = field(default_factory=dict)
    watchdog: int = 10000
    output_mask: int = 0
    cycles: int | None = None

    def to_json(self) -> dict[str, Any]:
        """The image as JSON data."""
        head = {"format": FORMAT, "version": VERSION, "title": self.title}
        head |= {"configuration": self.configuration, "entry": self.entry}
        return head | {k: v for k, v in asdict(self).items() if k not in head}

    @classmethod
    def from_json(cls, data: Any, name: str = "image") -> Image:
        """Image of JSON data. Raises ImageError."""
        if not isinstance(data, dict) or data.get("format") != FORMAT:
            raise ImageError(f"{name}: not a program image (no format '{FORMAT}')")
        if data.get("version") != VERSION:
            raise ImageError(
                f"{name}: image version {data.get('version')}, this tool reads {VERSION}"
            )
        fields = {k: v for k, v in data.items() if k not in ("format", "version")}
        try:
            for key, entry in ENTRY_TYPES.items():
                fields[key] = [entry(**item) for item in fields[key]]
            fields["sources"] = [[SourceEntry(**op) for op in ops] for ops in fields["sources"]]
            image = cls(**fields)
        except (TypeError, KeyError) as error:
            raise ImageError(f"{name}: damaged image: {error}") from None
        image.check(name)
        return image

    def check(self, name: str = "image", isa: Isa | None = None) -> None:
        """Raises ImageError unless the configuration exists and every bundle has its width."""
        isa = isa or default_isa()
        if self.configuration not in isa.configurations:
            raise ImageError(f"{name}: unknown configuration '{self.configuration}'")
        digits = isa.bundle_width(self.configuration) // 4
        for i, bundle in enumerate(self.bundles):
            if len(bundle) != digits or set(bundle) - set("0123456789abcdef"):
                raise ImageError(f"{name}: bundle {i} is not {digits} hexadecimal digits")
        if len(self.sources) != len(self.bundles):
            raise ImageError(f"{name}: {len(self.sources)} sources for {len(self.bundles)} bundles")

    def save(self, path: Path) -> None:
        """Write the JSON file."""
        path.write_text(self.dumps(), encoding="utf-8")

    def dumps(self) -> str:
        """JSON text with one line per entry."""
        rows = []
        for key, value in self.to_json().items():
            if isinstance(value, list) and value:
                items = ",\n".join("    " + json.dumps(item) for item in value)
                rows.append(f"  {json.dumps(key)}: [\n{items}\n  ]")
            else:
                rows.append(f"  {json.dumps(key)}: {json.dumps(value)}")
        return "{\n" + ",\n".join(rows) + "\n}\n"

    @classmethod
    def load(cls, path: Path) -> Image:
        """Read a JSON file. Raises ImageError, OSError."""
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
        except (json.JSONDecodeError, UnicodeDecodeError) as error:
            raise ImageError(f"{path}: not a JSON file: {error}") from None
        return cls.from_json(data, str(path))

    def words(self, isa: Isa | None = None) -> Iterator[tuple[int, int]]:
        """32-bit words of program memory: (4*bundle + lane, word), lane 0 lowest."""
        lanes = (isa or default_isa()).lanes(self.configuration)
        for address, bundle in enumerate(self.bundles):
            value = int(bundle, 16)
            for lane in range(lanes):
                yield 4 * address + lane, (value >> (32 * lane)) & 0xFFFFFFFF


def to_readmemh(image: Image) -> str:
    """Program for $readmemh: one bundle per line."""
    return "".join(f"{bundle}\n" for bundle in image.bundles)


def to_intel_hex(image: Image) -> str:
    """Program in Intel HEX: byte address 4 * word address, little endian words."""
    blocks: list[tuple[int, bytearray]] = []
    for address, word in image.words():
        if not blocks or blocks[-1][0] + len(blocks[-1][1]) != 4 * address:
            blocks.append((4 * address, bytearray()))
        elif len(blocks[-1][1]) == HEX_RECORD_BYTES:
            blocks.append((4 * address, bytearray()))
        blocks[-1][1].extend(word.to_bytes(4, "little"))
    rows = [_hex_record(address, 0, bytes(data)) for address, data in blocks]
    return "\n".join([*rows, _hex_record(0, 1, b"")]) + "\n"


def _hex_record(address: int, kind: int, data: bytes) -> str:
    record = bytes([len(data), address >> 8, address & 0xFF, kind]) + data
    return f":{record.hex().upper()}{-sum(record) & 0xFF:02X}"


def to_mif(image: Image) -> str:
    """Program as a memory initialization file: one bundle per address."""
    width = 4 * len(image.bundles[0])
    rows = [
        f"WIDTH={width};",
        f"DEPTH={len(image.bundles)};",
        "ADDRESS_RADIX=HEX;",
        "DATA_RADIX=HEX;",
        "CONTENT BEGIN",
        *(f"  {i:x} : {bundle};" for i, bundle in enumerate(image.bundles)),
        "END;",
    ]
    return "\n".join(rows) + "\n"


MEMORY_FORMATS = {"readmemh": to_readmemh, "ihex": to_intel_hex, "mif": to_mif}
