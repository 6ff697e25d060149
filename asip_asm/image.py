# SPDX-License-Identifier: Apache-2.0
"""Program images: the JSON file that every tool reads.

An image file is read by one loader, `Image.load`: limit of size, schema (the types below), checksum
(SHA-256 of the JSON data without the checksum, keys sorted, no spaces), then the rules between
entries.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from asip_asm.expression import literal_name
from asip_asm.files import read_bytes, write_text
from asip_asm.isa import STREAM_BITS, STREAM_PINS, Isa, default_isa

FORMAT = "microtick-asip-image"
VERSION = 2
FILE_BYTES = 8 << 20
"""Largest image file; a full program of 1024 bundles with its source lines takes about 1 MiB."""
CURE = "assemble the program again"

_ISA = default_isa()
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*")
Name = Annotated[str, Meta(pattern=r"\A[A-Za-z_][A-Za-z0-9_.]*\Z", max_length=16384)]
Text = Annotated[str, Meta(pattern=r"\A[^\x00-\x1f\x7f]*\Z", max_length=16384)]
Title = Annotated[str, Meta(pattern=r"\A[^\x00-\x1f\x7f]*\Z", max_length=16384)]
Word = Annotated[str, Meta(pattern=r"\A[0-9a-f]{8}\Z")]
Type = Annotated[str, Meta(pattern=r"\A(float|int)\Z")]
RegisterName = Annotated[str, Meta(pattern=r"\A[abck](0|[1-9][0-9]{0,2})\Z")]
Count = Annotated[int, Meta(ge=0, le=(1 << 32) - 1)]
ConstantIndex = Annotated[int, Meta(ge=0, lt=_ISA.banks["K"].size)]
Address = Annotated[int, Meta(ge=0, lt=_ISA.program_bundles)]


class ImageError(ValueError):
    """The file is no program image; the message names the file, what is wrong and the cure."""


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Entry of an image: a name and where it is."""


class SourceEntry(Entry, frozen=True):
    """Operation of a bundle as the source wrote it."""

    slot: Annotated[int, Meta(ge=0, le=2)]
    op: Name
    text: Text
    file: Text
    line: Count
    equation: Text


class ConstantEntry(Entry, frozen=True):
    """Constant of bank K: type 'float' or 'int', bits in hexadecimal."""

    name: Text
    index: ConstantIndex
    type: Type
    bits: Word


class InputEntry(Entry, frozen=True):
    """Input of bank K."""

    name: Name
    index: ConstantIndex
    type: Type


class OutputEntry(Entry, frozen=True):
    """Output word; `safe` are the bits in hexadecimal that it takes after a fault."""

    name: Name
    index: Annotated[int, Meta(ge=0, lt=_ISA.outputs)]
    safe: Word


class StateEntry(Entry, frozen=True):
    """State register and the bits that the host presets."""

    name: Name
    register: RegisterName
    type: Type
    bits: Word


class ExportEntry(Entry, frozen=True):
    """Register that the host can read after a run; of bank K: an input."""

    name: Name
    register: RegisterName


class StreamEntry(Entry, frozen=True):
    """Block of the stream of a multiply-add pipe: first address, words in hexadecimal; of vectors
    those of the first lane, and as many of each further one.
    """

    name: Name
    pin: Annotated[str, Meta(pattern=r"\A[AB]\Z")]
    address: Annotated[int, Meta(ge=0, lt=1 << STREAM_BITS)]
    words: Annotated[list[Word], Meta(min_length=1, max_length=1 << STREAM_BITS)]
    lanes: list[list[Word]] = []


class FunctionEntry(Entry, frozen=True):
    """One of several functions: first bundle, watchdog, outputs it must write, cycles of a run."""

    name: Name
    entry: Address
    watchdog: Annotated[int, Meta(ge=1, le=(1 << 32) - 1)]
    output_mask: Annotated[int, Meta(ge=0, lt=1 << _ISA.outputs)]
    cycles: Count | None


class Image(msgspec.Struct, forbid_unknown_fields=True):
    """Program image. `bundles` are hexadecimal words, `sources` the operations of each bundle,
    `cycles` the estimated cycles of a run without branches (None with branches), `parameters` the
    constants that a host may change between runs, `streams` the blocks of each pipe's constant
    memory. `functions`: several programs in one image
    (link.py), whose names are `function.name`; `entry`, `watchdog`, `output_mask` are the first's.
    """

    title: Title
    configuration: str
    bundles: Annotated[
        list[Annotated[str, Meta(pattern=r"\A[0-9a-f]+\Z")]],
        Meta(min_length=1, max_length=_ISA.program_bundles),
    ]
    sources: list[list[SourceEntry]]
    entry: Address = 0
    constants: list[ConstantEntry] = []
    inputs: list[InputEntry] = []
    outputs: list[OutputEntry] = []
    states: list[StateEntry] = []
    exports: list[ExportEntry] = []
    data: Annotated[list[Word], Meta(max_length=_ISA.data_words)] = []
    data_names: dict[Name, Annotated[int, Meta(ge=0, lt=_ISA.data_words)]] = {}
    labels: dict[Name, Address] = {}
    watchdog: Annotated[int, Meta(ge=1, le=(1 << 32) - 1)] = 10000
    output_mask: Annotated[int, Meta(ge=0, lt=1 << _ISA.outputs)] = 0
    cycles: Count | None = None
    parameters: list[Name] = []
    functions: list[FunctionEntry] = []
    streams: list[StreamEntry] = []

    @property
    def registers(self) -> dict[str, str]:
        """Register of each export and state."""
        found = {entry.name: entry.register for entry in self.exports}
        return found | {state.name: state.register for state in self.states}

    @property
    def types(self) -> dict[str, str]:
        """Type of each input and state."""
        found = {entry.name: entry.type for entry in self.inputs}
        return found | {state.name: state.type for state in self.states}

    def function(self, name: str) -> Image:
        """The image with one of its functions, by that function's own names; it holds the others'
        bundles, constants and data too. Raises ImageError for an unknown name.
        """
        found = next((f for f in self.functions if f.name == name), None)
        if found is None:
            there = ", ".join(f.name for f in self.functions) or "none"
            raise ImageError(f"{self.title}: no function '{name}'; there are {there}")

        def own(entries: list[Any]) -> list[Any]:
            return [
                msgspec.structs.replace(e, name=e.name.partition(".")[2])
                for e in entries
                if e.name.startswith(f"{name}.")
            ]

        return msgspec.structs.replace(
            self,
            entry=found.entry,
            watchdog=found.watchdog,
            output_mask=found.output_mask,
            cycles=found.cycles,
            inputs=own(self.inputs),
            outputs=own(self.outputs),
            states=own(self.states),
            exports=own(self.exports),
            functions=[],
        )

    def to_json(self) -> dict[str, Any]:
        """The image as JSON data, with its checksum."""
        head = {"format": FORMAT, "version": VERSION, "checksum": "", "title": self.title}
        head |= {"configuration": self.configuration, "entry": self.entry}
        data: dict[str, Any] = head | msgspec.to_builtins(self)
        for name in ("parameters", "functions", "streams"):
            if not data[name]:
                del data[name]
        data["checksum"] = checksum(data)
        return data

    @classmethod
    def from_json(cls, data: Any, name: str = "image", *, sealed: bool = True) -> Image:
        """Image of JSON data; `sealed`: the checksum must be right. Raises ImageError."""
        if not isinstance(data, Mapping) or data.get("format") != FORMAT:
            raise ImageError(f"{name}: not a program image (no format '{FORMAT}')")
        if data.get("version") != VERSION:
            raise ImageError(
                f"{name}: image version {str(data.get('version')):.20}, this tool reads {VERSION}; "
                + CURE
            )
        content = {k: v for k, v in data.items() if k not in ("format", "version", "checksum")}
        try:
            image = msgspec.convert(content, cls)
        except msgspec.ValidationError as error:
            raise ImageError(f"{name}: damaged image: {error}; {CURE}") from None
        if sealed and data.get("checksum") != checksum(data):
            raise ImageError(
                f"{name}: checksum differs: the image was edited or damaged; {CURE}, or take it as "
                "it is: asip-objdump --reseal"
            )
        image._check_rules(name)
        return image

    def check(self, name: str = "image") -> None:
        """Raises ImageError for an image that no assembler writes; for images made in Python."""
        try:
            msgspec.convert(msgspec.to_builtins(self), Image)
        except msgspec.ValidationError as error:
            raise ImageError(f"{name}: damaged image: {error}; {CURE}") from None
        self._check_rules(name)

    def _check_rules(self, name: str) -> None:
        if found := next(_problems(self, _ISA), ""):
            raise ImageError(f"{name}: damaged image: {found}; {CURE}")

    def save(self, path: Path) -> None:
        """Write the JSON file."""
        write_text(path, self.dumps())

    def dumps(self) -> str:
        """JSON text with one line per entry."""
        data = self.to_json()
        return json_rows(data, [key for key, value in data.items() if isinstance(value, list)])

    @classmethod
    def load(cls, path: Path, *, sealed: bool = True) -> Image:
        """Read a JSON file; `sealed`: its checksum must be right. Raises ImageError, OSError."""
        try:
            data = msgspec.json.decode(read_bytes(path, FILE_BYTES, "an image"))
        except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
            raise ImageError(f"{path}: not a JSON file: {error}") from None
        return cls.from_json(data, str(path), sealed=sealed)

    def stream(self, pin: str, lane: int = 0) -> list[int]:
        """Words of the stream of pipe 'A' or 'B' in a lane, all its blocks together; those of
        blocks without vectors are 0 in further lanes.
        """
        blocks = [entry for entry in self.streams if entry.pin == pin]
        found: list[int] = []
        for entry in blocks:
            words = (entry.words, *entry.lanes)[lane:][:1]
            found += [int(word, 16) for word in words[0]] if words else [0] * len(entry.words)
        return found

    def words(self) -> Iterator[tuple[int, int]]:
        """32-bit words of program memory: (4*bundle + lane, word), lane 0 lowest."""
        lanes = _ISA.lanes(self.configuration)
        for address, bundle in enumerate(self.bundles):
            value = int(bundle, 16)
            for lane in range(lanes):
                yield 4 * address + lane, (value >> (32 * lane)) & 0xFFFFFFFF


def json_rows(data: Mapping[str, Any], lists: Collection[str]) -> str:
    """JSON text with one line per entry, in these lists one per item."""
    rows = []
    for key, value in data.items():
        if value and key in lists:
            items = ",\n".join("    " + json.dumps(item) for item in value)
            text = f"[\n{items}\n  ]"
        else:
            text = json.dumps(value)
        rows.append(f"  {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(rows) + "\n}\n"


def checksum(data: Mapping[str, Any]) -> str:
    """Checksum of the JSON data of an image, the checksum itself left out."""
    content = {key: value for key, value in data.items() if key != "checksum"}
    text = msgspec.json.encode(content, order="sorted")
    return f"sha256:{hashlib.sha256(text).hexdigest()}"


def _problems(image: Image, isa: Isa) -> Iterator[str]:
    """Rules between several entries that the image breaks, in words."""
    configuration = isa.configurations.get(image.configuration)
    if configuration is None:
        yield f"unknown configuration '{image.configuration:.40}'"
        return
    digits = isa.bundle_width(image.configuration) // 4
    for i, bundle in enumerate(image.bundles):
        if len(bundle) != digits:
            yield f"bundle {i} is not {digits} hexadecimal digits"
    if len(image.sources) != len(image.bundles):
        yield f"{len(image.sources)} sources for {len(image.bundles)} bundles"
    for i, entries in enumerate(image.sources):
        if any(entry.slot >= len(configuration.slots) for entry in entries):
            yield f"a source of bundle {i} is in a slot that '{image.configuration}' has not"
    places = {"entry": image.entry} | {f"label '{k}'": v for k, v in image.labels.items()}
    places |= {f"entry of function '{f.name}'": f.entry for f in image.functions}
    for what, address in places.items():
        if address >= len(image.bundles):
            yield f"{what} is {address}, the program has {len(image.bundles)} bundles"
    for name, address in image.data_names.items():
        if address >= len(image.data):
            yield f"data name '{name}' is {address}, the image has {len(image.data)} data words"
    for pin in STREAM_PINS:
        room, end = configuration.stream_words, 0
        for block in (block for block in image.streams if block.pin == pin):
            if block.address != end:
                yield f"stream '{block.name}' is at {block.address}, the words before end at {end}"
            end = block.address + len(block.words)
            if block.lanes and [len(block.words)] * configuration.lanes != [*map(len, block.lanes)]:
                yield f"stream '{block.name}' has not {1 + configuration.lanes} equal lanes"
        if end > room:
            yield f"the stream of pipe {pin} has {end} words, '{configuration.name}' holds {room}"
    yield from _bank_k(image)
    yield from _twice("index of an output", (o.index for o in image.outputs))
    yield from _twice("register of a state", (s.register for s in image.states))
    for what in ("inputs", "outputs", "states", "exports", "functions", "streams"):
        yield from _twice(f"name in {what}", (entry.name for entry in getattr(image, what)))
    held: list[StateEntry | ExportEntry] = [*image.states, *image.exports]
    for entry in held:
        bank = isa.banks[entry.register[0].upper()]
        if int(entry.register[1:]) >= bank.size or (
            bank.name == "B" and configuration.fma_pipes < 2
        ):
            yield f"'{entry.name}' is in register {entry.register}, which does not exist"
    for state in image.states:
        if state.register[0] == "k":
            yield f"state '{state.name}' is in bank K, which programs cannot write"
    outputs = sum(1 << output.index for output in image.outputs)
    masks = [image.output_mask, *(f.output_mask for f in image.functions)]
    if any(mask & ~outputs for mask in masks):
        yield f"output_mask {max(masks):08x} asks for outputs that are not declared"


def _bank_k(image: Image) -> Iterator[str]:
    """A word of bank K holds one input or one constant, which may have several names."""
    yield from _twice("index of an input", (entry.index for entry in image.inputs))
    for name in image.parameters:
        if name not in {constant.name for constant in image.constants}:
            yield f"parameter '{name}' is no constant"
    owner: dict[int, Any] = {entry.index: entry for entry in image.inputs}
    for constant in image.constants:
        other = owner.setdefault(constant.index, constant)
        if (getattr(other, "bits", None), other.type) != (constant.bits, constant.type):
            yield f"k{constant.index} holds '{other.name}' and '{constant.name}'"
        if constant.name in image.parameters and other is not constant:
            yield f"k{constant.index} holds '{other.name}' and the parameter '{constant.name}'"
        value = literal_name(int(constant.bits, 16), constant.type)
        if constant.name != value and not _NAME.fullmatch(constant.name):
            yield f"constant k{constant.index} is named '{constant.name:.40}', its value is {value}"


def _twice(what: str, items: Iterable[int | str]) -> Iterator[str]:
    seen: set[int | str] = set()
    for item in items:
        if item in seen:
            yield f"{what} {item!r} appears twice"
        seen.add(item)
