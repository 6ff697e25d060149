# SPDX-License-Identifier: Apache-2.0
"""Elements of an XML file, read strictly.

The XML is read by expat without a DTD, so no entity is ever expanded, and with bounds on size and
depth. Every word of an element is used, refused with file, line and cure, or counted as not used.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from asip_asm.diagnostics import closest

Matrix = NDArray[np.float64]
BYTES = 16 << 20
"""Largest file."""
DEPTH = 64
"""Deepest element."""
LARGEST = 1e30
"""Largest number of a URDF: beyond it a product leaves binary32."""
SHOWN = 60
"""Characters of a word that a message shows."""
EXPAND = "expand it: xacro FILE > robot.urdf"
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?", re.ASCII)


class RobotError(ValueError):
    """A robot description that no law can be made for; the text says where, why and the cure."""


@dataclass
class Element:
    """An element of the file; line: of its start tag."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""


def read_elements(path: Path) -> tuple[Element, str]:
    """Root element of a file, and its text. Raises RobotError, OSError."""
    if not path.is_file():
        raise RobotError(f"{path}: no such file")
    with path.open("rb") as file:
        data = file.read(BYTES + 1)
    if len(data) > BYTES:
        raise RobotError(f"{path}: larger than {BYTES >> 20} MiB; meshes belong in other files")
    return _parse(data, str(path))


def _parse(data: bytes, file: str) -> tuple[Element, str]:
    """Root element, and the text in Unicode."""
    parser = expat.ParserCreate()
    parser.buffer_text = True
    open_elements: list[Element] = []
    roots: list[Element] = []
    encoding = ["utf-8"]

    def declared(version: str, name: str | None, standalone: int) -> None:
        encoding[0] = name or encoding[0]

    def doctype(*_: object) -> NoReturn:
        raise RobotError(
            f"{file}:{parser.CurrentLineNumber}: <!DOCTYPE: a URDF needs none; delete it, and "
            "write its entities out"
        )

    def start(tag: str, attributes: dict[str, str]) -> None:
        line = parser.CurrentLineNumber
        if len(open_elements) >= DEPTH:
            raise RobotError(f"{file}:{line}: elements deeper than {DEPTH}")
        if tag.startswith("xacro:"):
            raise RobotError(
                f"{file}:{line}: <{tag:.{SHOWN}}> is xacro, which is no URDF yet; {EXPAND}"
            )
        element = Element(tag, attributes, line)
        (open_elements[-1].children if open_elements else roots).append(element)
        open_elements.append(element)

    def characters(text: str) -> None:
        open_elements[-1].text += text

    parser.XmlDeclHandler = declared
    parser.StartDoctypeDeclHandler = doctype
    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_elements.pop()
    parser.CharacterDataHandler = characters
    try:
        parser.Parse(data, True)
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else encoding[0])
    except expat.ExpatError as error:
        message = expat.errors.messages[error.code]
        cure = _cure(data, error)
        raise RobotError(f"{file}:{error.lineno}: no XML: {message}{cure}") from None
    except (UnicodeError, LookupError) as error:
        raise RobotError(f"{file}: not readable as {encoding[0]}: {error}; save as UTF-8") from None
    return roots[0], text.removeprefix("\ufeff")


def _cure(data: bytes, error: expat.ExpatError) -> str:
    """What helps against an error of the XML."""
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return '; it is not in UTF-8: save it so, or declare its encoding: <?xml version="1.0" \
encoding="ISO-8859-1"?>'
    if error.code == expat.errors.codes[expat.errors.XML_ERROR_UNDEFINED_ENTITY]:
        return "; write the entity out"
    return ""


class Reader:
    """Takes the elements of one file apart. unused: what nothing reads, by name."""

    KNOWN_UNUSED: frozenset[str] = frozenset()
    """Elements and attributes that need no look for a slip of the pen."""
    REFUSED: Mapping[str, str] = {}
    """Elements that no reader can leave out, with what they are."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.unused: Counter[str] = Counter()
        self.warnings: list[str] = []

    def fail(self, where: Element, what: str) -> NoReturn:
        raise RobotError(f"{self.file}:{where.line}: {what}")

    # Words and numbers.

    def _plain(self, element: Element, text: str, what: str) -> str:
        if not text or not text.isprintable():
            self.fail(element, f"{what} {text[:SHOWN]!r} is empty or has unprintable characters")
        return text

    def _name(self, element: Element, what: str, key: str = "name") -> str:
        if key not in element.attributes:
            self.fail(element, f"{what}: <{element.tag}> has no attribute {key}")
        return self._plain(element, element.attributes[key], f"{what}: {key}")

    def _numbers(self, element: Element, key: str, count: int, where: str) -> Matrix:
        text = element.attributes[key]
        words = text.split()
        if "${" in text or "$(" in text:
            word = text[:SHOWN]
            self.fail(element, f"{where}: {key}='{word}' is xacro, which is no URDF yet; {EXPAND}")
        for word in words:
            if not NUMBER.fullmatch(word):
                self.fail(element, f"{where}: {element.tag} {key} '{word[:SHOWN]}' is no number")
            if not abs(float(word)) <= LARGEST:
                self.fail(element, f"{where}: {element.tag} {key} '{word[:SHOWN]}' is too large")
        if len(words) != count:
            have = f"{len(words)} number{'s' * (len(words) != 1)}"
            self.fail(element, f"{where}: {element.tag} {key} has {have}, it needs {count}")
        return np.array([float(word) for word in words])

    def _number(self, element: Element, key: str, where: str) -> float:
        if key not in element.attributes:
            self.fail(element, f"{where}: <{element.tag}> has no attribute {key}")
        return float(self._numbers(element, key, 1, where)[0])

    def _optional(self, element: Element, key: str, where: str, default: float) -> float:
        return self._number(element, key, where) if key in element.attributes else default

    def _attributes(self, element: Element, known: tuple[str, ...], where: str) -> None:
        """Counts the attributes that nothing reads; one that looks like a known one is refused."""
        for key in element.attributes:
            if key in known or key.startswith("xmlns"):
                continue
            near = closest(key, known)
            if near and key not in self.KNOWN_UNUSED:
                self.fail(
                    element, f"{where}: <{element.tag}> has an attribute {key[:SHOWN]}; {near}"
                )
            self.unused[f"{element.tag} {key}"[:SHOWN]] += 1

    def _other(self, element: Element, known: tuple[str, ...], where: str) -> None:
        """Counts an element that nothing reads; one that looks like a known one is refused."""
        place = f"{where}: " if where else ""
        if element.tag in self.REFUSED:
            self.fail(element, f"{place}<{element.tag}> {self.REFUSED[element.tag]}")
        if element.tag not in self.KNOWN_UNUSED:
            near = closest(element.tag, known)
            if near:
                self.fail(element, f"{place}unknown element <{element.tag[:SHOWN]}>; {near}")
        self.unused[element.tag[:SHOWN]] += 1

    def _parts(self, element: Element, known: tuple[str, ...], where: str) -> dict[str, Element]:
        """Children by tag, each at most once; the others are counted."""
        found: dict[str, Element] = {}
        for child in element.children:
            if child.tag not in known:
                self._other(child, known, where)
            elif child.tag in found:
                self.fail(child, f"{where}: a second <{child.tag}>; delete one")
            else:
                found[child.tag] = child
        return found
