# SPDX-License-Identifier: Apache-2.0
"""A session as a client of the Debug Adapter Protocol sees it: frames, scopes, variables, code."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from asip_asm.isa import default_isa
from sim.debug.asip_dbg.session import Session
from sim.debug.asip_dbg.values import Reading, ValueMissing, text_of

THREAD = 1
"""The core, the only thread."""
SCOPES = ("Values", "Inputs", "States", "Outputs", "Constants", "Registers")
"""Scopes; a variablesReference is a place in this list, from 1 on."""

Body = dict[str, Any]


class Views:
    """Answers for clients; what is in them is read when it is requested."""

    def __init__(self, session: Session, lines_from: int = 1, columns_from: int = 1) -> None:
        self.session = session
        self.program = session.program
        self._lines_from, self._columns_from = lines_from, columns_from

    def line(self, number: int) -> int:
        """Number of a source line, from 1, as the client counts them."""
        return number - 1 + self._lines_from

    def own_line(self, number: int) -> int:
        """Number, from 1, of a line that the client names."""
        return number + 1 - self._lines_from

    def own_column(self, number: int) -> int:
        """Number, from 1, of a column that the client names."""
        return number + 1 - self._columns_from

    # ------------------------------------------------------------------ stack
    def source(self, file: str) -> Body:
        """A source of the program."""
        return {"name": Path(file).name, "path": str(self.program.source_path(file).resolve())}

    def frames(self) -> list[Body]:
        """The bundle that issues next, then the macro calls around its operation."""
        bundle = self.session.position
        entry = self.program.primary(min(bundle, self.program.bundles - 1))
        name = f"bundle {bundle}" if bundle < self.program.bundles else "end of the tick"
        if entry is None:
            return [{"id": 1, "name": name, "line": 0, "column": 0}]  # No source: no line.
        if entry.equation and bundle < self.program.bundles:
            name += f" ({entry.equation})"
        calls = self.program.calls(bundle, entry.slot)
        places = [(name, entry.file, entry.line)]
        places += [(f"macro {call.name}", call.file, call.line) for call in calls]
        frames: list[Body] = [
            {
                "id": depth,
                "name": name,
                "source": self.source(file),
                "line": self.line(line),
                "column": self._columns_from,
            }
            for depth, (name, file, line) in enumerate(places, 1)
        ]
        frames[0]["instructionPointerReference"] = f"0x{bundle:x}"
        return frames

    # ------------------------------------------------------------------ variables
    def scopes(self) -> list[Body]:
        """All scopes; the registers are slow to read over a serial line."""
        return [
            {
                "name": name,
                "variablesReference": number,
                "expensive": name == "Registers",
                "presentationHint": "registers" if name == "Registers" else "locals",
            }
            for number, name in enumerate(SCOPES, 1)
        ]

    def variables(self, reference: int, form: str = "") -> list[Body]:
        """Variables of a scope. Raises ValueMissing for one that is none."""
        if not 1 <= reference <= len(SCOPES):
            raise ValueMissing(f"there is no scope {reference}")
        scope = SCOPES[reference - 1]
        shown = self._output if scope == "Outputs" else self.variable
        return [shown(name, form) for name in self._names(scope)]

    def _names(self, scope: str) -> list[str]:
        image = self.program.image
        states = [state.name for state in image.states]
        outputs = [output.name for output in image.outputs]
        if scope == "Registers":
            isa = default_isa()
            banks = "abc" if isa.configurations[image.configuration].fma_pipes > 1 else "ac"
            return [f"{bank}{i}" for bank in banks for i in range(isa.banks[bank.upper()].size)]
        if scope == "Constants":
            names = [constant.name for constant in image.constants]
            return [name for name in names if name[:1].isalpha() or name[:1] == "_"]
        if scope == "Values":
            return [name for name in self.program.map.names() if name not in (*states, *outputs)]
        return {"Inputs": list(self.session.values.inputs), "States": states, "Outputs": outputs}[
            scope
        ]

    def variable(self, name: str, form: str = "") -> Body:
        """A variable; one without a value says why."""
        try:
            return self._shown(self.session.values.read(name), form)
        except ValueMissing as error:
            text = str(error).removeprefix(f"{name}: ")
            return {
                "name": name,
                "value": f"<{text}>",
                "variablesReference": 0,
                "presentationHint": {"attributes": ["readOnly"]},
            }

    def _output(self, name: str, form: str) -> Body:
        """An output as the host reads it: that of the last tick that ended well."""
        index = next(o.index for o in self.program.image.outputs if o.name == name)
        word = self.session.target.read(f"o{index}")
        return self._shown(Reading(name, "float", word, f"o{index}"), form)

    @staticmethod
    def _shown(reading: Reading, form: str) -> Body:
        return {
            "name": reading.name,
            "value": text_of(reading, form),
            "type": f"{reading.type} in {reading.place}",
            "evaluateName": reading.name,
            "variablesReference": 0,
        }

    # ------------------------------------------------------------------ code
    def instructions(self, first: int, count: int) -> list[Body]:
        """Bundles from an address on; those outside the program are marked."""
        found = []
        for bundle in range(first, first + count):
            row: Body = {"address": f"0x{max(bundle, 0):x}", "instruction": "outside the program"}
            if 0 <= bundle < self.program.bundles:
                row["instruction"] = self.program.text(bundle)
                row["instructionBytes"] = self.program.image.bundles[bundle]
                entry = self.program.primary(bundle)
                if entry is not None:
                    row |= {"location": self.source(entry.file), "line": self.line(entry.line)}
            else:
                row["presentationHint"] = "invalid"
            found.append(row)
        return found
