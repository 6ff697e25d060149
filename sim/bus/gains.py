# SPDX-License-Identifier: Apache-2.0
"""Gains of the law on the ASIP, changed while it runs: objects 2000 to 2002 of the device.

The program has one gain for the three legs and one for both axes of the table, so that an element
of x, y or z is that of all legs, one of tilt or rotation that of both; the last one written counts.
A changed gain is put into the program's text; what then differs in bank K are the words to write:
the integrator's constants follow. A word that by chance is that of another constant would become
one with it, and the program another one: such a gain is taken two units of its last place greater.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from pathlib import Path

from asip_asm.assemble import assemble
from asip_asm.diagnostics import AssemblyError, SourceError
from asip_asm.files import write_text
from asip_asm.image import Image

KINDS = {0x2000: "KP", 0x2001: "KV", 0x2002: "KI"}
LEGS = 3  # elements up to this one are of the tool
NEAR = (1.0, 1 + 2.0**-22, 1 + 2.0**-21)


class GainError(ValueError):
    """The program cannot have this gain; the text says why."""


class Gains:
    """Gains of a tracking program. image: as assembled from `source` with its own gains."""

    def __init__(self, source: Path, image: Image, defines: Mapping[str, float]) -> None:
        self._source, self._defines = source, dict(defines)
        self._shape = self._shape_of(image)
        self._words = self._words_of(image)
        self._changed: dict[str, float] = {}

    @staticmethod
    def _shape_of(image: Image) -> tuple[list[str], list[int]]:
        return image.bundles, [entry.index for entry in image.constants]

    @staticmethod
    def _words_of(image: Image) -> dict[int, int]:
        return {entry.index: int(entry.bits, 16) for entry in image.constants}

    def change(self, index: int, element: int, value: float) -> dict[int, int]:
        """Words of bank K that become others by this write to the dictionary; 0: the program's own.

        Raises GainError for a gain with which the program would be another one; nothing has changed
        then.
        """
        name = f"{KINDS[index]}_{'legs' if element <= LEGS else 'table'}"
        for factor in NEAR:
            changed = self._changed | {name: value * factor}
            if not value:
                del changed[name]
            words = self._words_with(changed)
            if words is not None:
                break
        else:
            raise GainError(f"with {name} = {value:g} the program itself is another one")
        different = {place: word for place, word in words.items() if self._words[place] != word}
        self._words, self._changed = words, changed
        return different

    def _texts(self) -> dict[str, str]:
        """Text of the program and of the files that it includes, by name."""
        text = self._source.read_text(encoding="utf-8")
        included = re.findall(r'(?m)^\.include\s+"([^"]+)"', text)
        files = [self._source, *(self._source.parent / name for name in included)]
        return {file.name: file.read_text(encoding="utf-8") for file in files}

    def _words_with(self, gains: Mapping[str, float]) -> dict[int, int] | None:
        """None: the program is another one."""
        texts = self._texts()
        for name, value in gains.items():
            line, found = rf"(?m)^(\.const\s+{name}\s*=).*$", 0
            for file, text in texts.items():
                texts[file], here = re.subn(line, rf"\g<1> {value!r}", text)
                found += here
            if found != 1:
                named = " and ".join(texts)
                raise GainError(f"{named}: {found} constants {name}, not one")
        with tempfile.TemporaryDirectory() as folder:
            for file, text in texts.items():
                write_text(Path(folder, file), text)
            copy = Path(folder, self._source.name)
            try:
                image = assemble(
                    copy,
                    configuration="fast",
                    defines=self._defines,
                    include_path=[self._source.parent],
                )
            except (AssemblyError, SourceError) as error:
                raise GainError(str(error)) from None
        return self._words_of(image) if self._shape_of(image) == self._shape else None
