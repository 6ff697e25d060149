# SPDX-License-Identifier: Apache-2.0
"""Faults of the core in words: cause, place and the source lines that the image keeps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from asip_asm.gen.asip_regmap import REGMAP
from asip_asm.image import Image

NO_FAULT = "NONE"
NOT_FINITE_CAUSES = (
    ({"fsin", "fcos"}, "sine or cosine of more than 256 rad (NaN)"),
    ({"fsqrt"}, "square root of a negative number (NaN)"),
    ({"fdiv"}, "division by 0"),
)


@dataclass(frozen=True)
class Fault:
    """Cause by name, the bundle it names (None: an output), and the output's index."""

    cause: str
    bundle: int | None = None
    output: int | None = None

    @classmethod
    def of(cls, cause: str, info: int) -> Fault:
        """The fault of a cause and of the register FAULT_INFO."""
        return cls(cause, output=info) if cause == "NOT_FINITE" else cls(cause, bundle=info)


def fault_text(image: Image, fault: Fault, inputs: Mapping[str, int] | None = None) -> str:
    """Cause, place and source lines of a fault. inputs: words of the run that ended with it."""
    meaning = REGMAP.faults[fault.cause].doc
    rows = [f"{fault.cause}: {meaning}"]
    bundles: list[int] = []
    if fault.output is not None:
        name = {o.index: o.name for o in image.outputs}.get(fault.output, f"o{fault.output}")
        rows[0] += f", output {name}"
        names = (name, f"o{fault.output}")
        bundles = [
            address
            for address, entries in enumerate(image.sources)
            if any(destination(entry.text) in names for entry in entries)
        ]
    elif fault.bundle is not None:
        rows[0] += f", bundle {fault.bundle}"
        bundles = [fault.bundle] if fault.bundle < len(image.sources) else []
        if not bundles:
            rows[0] += " (outside the program)"
    for address in bundles:
        for entry in image.sources[address]:
            if fault.output is None or destination(entry.text) in names:
                rows.append(f"  {entry.file}:{entry.line}: {entry.text}")
    return "\n".join(rows + not_finite_causes(image, fault, inputs or {}))


def not_finite_causes(image: Image, fault: Fault, inputs: Mapping[str, int]) -> list[str]:
    """What may have given NaN or infinity: an input, else what the program's operations got."""
    if fault.cause != "NOT_FINITE":
        return []
    floats = {entry.name for entry in image.inputs if entry.type == "float"}
    given = [n for n, word in inputs.items() if n in floats and word >> 23 & 0xFF == 0xFF]
    if given:
        return [f"  cause: NaN or infinity in the input {', '.join(given)}"]
    used = {entry.op for entries in image.sources for entry in entries}
    causes = [text for operations, text in NOT_FINITE_CAUSES if used & operations]
    return [f"  possible causes: {'; '.join([*causes, 'a result above 3.4e38'])}"]


def destination(text: str) -> str:
    """First operand of an operation's text."""
    words = text.split(None, 1)
    return words[1].split(",")[0].strip() if len(words) > 1 else ""
