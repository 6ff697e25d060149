# SPDX-License-Identifier: Apache-2.0
"""Program images as C: tables for the driver of `sim/core/host/asip.h` and names of inputs, outputs
and exports as enumeration constants."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from asip_asm.diagnostics import AssemblyError, Diagnostic
from asip_asm.image import Image
from asip_asm.isa import STREAM_PINS, default_isa

WORDS_PER_LINE = 6
CODE_SPAN = 64  # registers of a bank code


def c_files(stem: str, image: Image, prefix: str = "") -> dict[str, str]:
    """Text by name of the image in C; none for one with vectors, which the driver does not load."""
    vectors = any(block.lanes for block in image.streams)
    return {} if vectors else {f"{stem}.h": to_c(image, prefix)}


def to_c(image: Image, prefix: str = "") -> str:
    """C99 text to be included by one source file; every name starts with `prefix`, an identifier,
    or without it with the program's title.

    Title "leg length", input x: `leg_length_image` and LEG_LENGTH_INPUT_X. Characters that C does
    not know become '_'; a name that is already used gets a number at its end. Exported
    inputs are left out: the host wrote them itself.
    """
    if any(block.lanes for block in image.streams):
        raise AssemblyError(
            [
                Diagnostic(
                    None,
                    f"{image.title}: an image in C has no vectors",
                    "load the JSON image, or declare the words with .stream",
                )
            ]
        )
    isa = default_isa()
    configuration = isa.configurations[image.configuration]
    prefix = prefix or identifier(image.title) or "program"
    exports = [export for export in image.exports if export.register[0] in "abc"]
    safe = [0] * (1 + max((output.index for output in image.outputs), default=-1))
    for output in image.outputs:
        safe[output.index] = int(output.safe, 16)
    tables = [
        Table("program", "uint32_t", _hex(word for _, word in image.words())),
        Table(
            "constants", "asip_word_at", _pairs((c.index, int(c.bits, 16)) for c in image.constants)
        ),
        Table("data", "uint32_t", _hex(int(word, 16) for word in image.data)),
        Table("safe", "uint32_t", _hex(safe)),
        Table(
            "states",
            "asip_word_at",
            _pairs((register_offset(s.register), int(s.bits, 16)) for s in image.states),
        ),
        Table("inputs", "uint16_t", [str(entry.index) for entry in image.inputs]),
        Table("exports", "uint16_t", [str(register_offset(e.register)) for e in exports]),
        *(
            Table(f"stream_{pin.lower()}", "uint32_t", _hex(image.stream(pin)))
            for pin in STREAM_PINS
        ),
    ]
    lines = [
        f"/* Program image '{comment(image.title)}' for configuration {image.configuration}, "
        "written by asip-as.",
        " * Include it in one source file, behind asip.h. */",
        "#include <stddef.h>",
        "",
    ]
    groups = {
        "input": [entry.name for entry in image.inputs],
        "state": [entry.name for entry in image.states],
        "export": [entry.name for entry in exports],
    }
    if image.functions:
        lines += _function_names(image, groups, prefix)
    else:
        for group, names in groups.items():
            lines += enumeration(f"{prefix}_{group}", [(name, i) for i, name in enumerate(names)])
        lines += enumeration(f"{prefix}_output", [(o.name, o.index) for o in image.outputs])
    for table in tables:
        lines += table.definition(prefix)
    fields = [
        f'"{_string(image.title)}"',
        f"{len(configuration.slots)}, {configuration.fma_pipes}, {isa.lanes(image.configuration)}",
        f"{image.entry}, {image.watchdog}u, 0x{image.output_mask:08X}u",
        str(len(image.bundles)),
        *(table.reference(prefix) for table in tables),
    ]
    lines += [
        "/* Members in the order of asip_image. */",
        f"static const asip_image {prefix}_image = {{",
        *(f"  {field}," for field in fields[:-1]),
        f"  {fields[-1]}",
        "};",
        "",
    ]
    lines += _functions(image, groups, prefix)
    return "\n".join(lines)


def _own(names: Sequence[str], function: str) -> list[tuple[str, int]]:
    """Names of a function's signals without its own, and their numbers in the image."""
    parts = ((name.partition("."), number) for number, name in enumerate(names))
    return [(own, number) for (first, _, own), number in parts if first == function]


def _function_names(image: Image, groups: dict[str, list[str]], prefix: str) -> list[str]:
    """Enumerations of each function: inputs and outputs from 0, as asip_function_tick takes them,
    states and exports by their numbers in the image.
    """
    lines = []
    outputs = [output.name for output in image.outputs]
    for function in image.functions:
        for group, names in (groups | {"output": outputs}).items():
            own = _own(names, function.name)
            if group in ("input", "output"):
                own = [(name, i) for i, (name, _) in enumerate(own)]
            lines += enumeration(f"{prefix}_{function.name}_{group}", own)
    return lines


def _functions(image: Image, groups: dict[str, list[str]], prefix: str) -> list[str]:
    """The functions of an image with several."""
    lines = []
    outputs = [output.name for output in image.outputs]
    for function in image.functions:
        fields = [f'"{function.name}"', f"{function.entry}, {function.watchdog}u, "
                  f"0x{function.output_mask:08X}u"]  # fmt: skip
        for names in (groups["input"], outputs, groups["state"]):
            own = _own(names, function.name)
            fields.append(f"{own[0][1] if own else 0}, {len(own)}")
        lines += [
            "/* Members in the order of asip_function. */",
            f"static const asip_function {prefix}_{function.name} = {{",
            ",\n".join(f"  {field}" for field in fields),
            "};",
            "",
        ]
    return lines


def register_offset(name: str) -> int:
    """Word offset of a register such as 'c12' in block `registers`."""
    return default_isa().banks[name[0].upper()].code * CODE_SPAN + int(name[1:])


def identifier(text: str) -> str:
    """Lower-case C identifier of a title: runs of other characters become one '_'."""
    name = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    return f"program_{name}" if name[:1].isdigit() else name


def enumeration(name: str, members: Sequence[tuple[str, int]]) -> list[str]:
    """Enumeration of NAME_MEMBER = value, and the number of members: NAMES."""
    taken: set[str] = set()
    rows = []
    for member, value in members:
        base = re.sub(r"\W", "_", f"{name}_{member}", flags=re.ASCII).upper()
        unique, number = base, 2
        while unique in taken:
            unique, number = f"{base}_{number}", number + 1
        taken.add(unique)
        rows.append(f"  {unique} = {value}")
    rows.append(f"  {name.upper()}S = {len(members)}")
    return ["enum {", ",\n".join(rows), "};", ""]


class Table:
    """Constant array of an image; an empty one is a null pointer, C has no empty arrays."""

    def __init__(self, name: str, kind: str, items: Sequence[str]) -> None:
        self.name, self.kind, self.items = name, kind, items

    def definition(self, prefix: str) -> list[str]:
        if not self.items:
            return []
        rows = [
            "  " + ", ".join(self.items[i : i + WORDS_PER_LINE])
            for i in range(0, len(self.items), WORDS_PER_LINE)
        ]
        head = f"static const {self.kind} {prefix}_{self.name}[{len(self.items)}] = {{"
        return [head, ",\n".join(rows), "};", ""]

    def reference(self, prefix: str) -> str:
        return f"{prefix}_{self.name}, {len(self.items)}" if self.items else "NULL, 0"


def _hex(words: Iterable[int]) -> list[str]:
    return [f"0x{word:08X}u" for word in words]


def _pairs(pairs: Iterable[tuple[int, int]]) -> list[str]:
    return [f"{{{address}, 0x{word:08X}u}}" for address, word in pairs]


def _string(text: str) -> str:
    plain = "".join(c if " " <= c <= "~" else "?" for c in text)
    return plain.replace("\\", "\\\\").replace('"', '\\"').replace("?", "\\?")


def comment(text: str) -> str:
    """Text for a comment of C, in ASCII; it neither ends the comment nor seems to begin another."""
    plain = "".join(c if " " <= c <= "~" else "?" for c in text)
    return plain.replace("*/", "* /").replace("/*", "/ *")
