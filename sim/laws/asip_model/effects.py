# SPDX-License-Identifier: Apache-2.0
"""Programs of one law under several sets of the compiler's options: which is the shortest, and what
each option does to cycles and to error bounds. Every figure is that of a program that was built.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path

import numpy as np

from asip_asm.diagnostics import AssemblyError
from asip_asm.model.bound import bounds
from asip_asm.model.compiler import SINES, Compiled, Options, compile_law, without_idle
from asip_asm.model.exact import Array
from asip_asm.model.law import Law
from asip_asm.model.program import Built, build
from asip_asm.model.read import ModelError
from asip_asm.pace import Pace
from sim.laws.prove_program import draw_ticks

POINTS = 200


@dataclass
class Forms:
    """Programs of a law by their options, each built once; `refused` has why one does not fit."""

    law: Law
    built: dict[Options, Built] = field(default_factory=dict)
    refused: dict[Options, AssemblyError | ModelError] = field(default_factory=dict)

    def build(self, options: Options) -> Built | None:
        """The program under these options; None if it does not fit the core."""
        if options not in self.built and options not in self.refused:
            try:
                acting = without_idle(self.law, options)
                one = self._program(acting) if acting == options else self.build(acting)
                if one is not None:
                    self.built[options] = replace(
                        one, compiled=replace(one.compiled, options=options)
                    )
                else:
                    self.refused[options] = self.refused[acting]
            except (AssemblyError, ModelError) as error:
                self.refused[options] = error
        return self.built.get(options)

    def _program(self, options: Options) -> Built:
        compiled = compile_law(self.law, options)
        with tempfile.TemporaryDirectory(prefix="microtick-") as folder:
            pace = Pace(f"{self.law.title}: schedules", 0)
            return build(compiled, Path(folder) / "law.s", lambda p: pace.at(p.tried, p.effort))

    def ranked(
        self, allowed: list[Options], progress: Callable[[str], None] = lambda _: None
    ) -> list[Built]:
        """The programs that fit, the shortest first; of programs as short, the one earlier in
        `allowed`. Raises ModelError, AssemblyError if none fits.
        """
        found = []
        for number, options in enumerate(allowed, 1):
            built = self.build(options)
            cycles = f"{built.cycles} cycles" if built else "does not fit"
            progress(f"{number} of {len(allowed)}: {words(options)}: {cycles}")
            found += [built] if built else []
        if not found:
            raise self.refused[allowed[0]]
        return sorted(found, key=lambda one: one.cycles)


def allowed_sets(
    options: Options, reassociate: bool | None, reciprocal: bool | None, sine: str | None
) -> list[Options]:
    """Every set of options with those given; None leaves one free. Sets that change fewer
    roundings come first.
    """
    both = (False, True)
    free = product(
        both if reassociate is None else (reassociate,),
        both if reciprocal is None else (reciprocal,),
        SINES if sine is None else (sine,),
    )
    return [replace(options, reassociate=a, reciprocal=b, sine=c) for a, b, c in free]


def words(options: Options) -> str:
    """The options as a command line has them."""
    flags = [f"--{name}" for name in ("reassociate", "reciprocal") if getattr(options, name)]
    return " ".join([*flags, f"--sine {options.sine}"])


def effects(built: Built, seed: int, forms: Forms | None = None) -> str:
    """Table: the program compared with those with one option changed.

    Bounds are means over drawn inputs, as multiples of this program's, over all results.
    """
    compiled = built.compiled
    law, options = compiled.law, compiled.options
    forms = forms or Forms(law)
    forms.built[options] = built
    inputs = _inputs(law, np.random.default_rng(seed))
    own = _means(compiled, inputs)
    lines = [f"{'options':<24}{'cycles':>8}  bounds of the results beside this program's"]
    for name, changed in _changed(options):
        form = forms.build(changed)
        if form is None:
            lines.append(f"{name:<24}{'-':>8}  does not fit: {_reason(forms.refused[changed])}")
            continue
        means = _means(form.compiled, inputs)
        ratios = [means[key] / own[key] for key in own if own[key] > 0] or [1.0]
        lines.append(f"{name:<24}{form.cycles:>8}  {min(ratios):.2f} to {max(ratios):.2f}")
    on_pipes = sum(mark.endswith("_turns") for mark, _ in compiled.graph.functions.values())
    unit = sum(node.op in ("fsin", "fcos") for _, node in compiled.graph.operations())
    lines.append(f"sines and cosines: {unit} on the sine unit, {on_pipes} on the pipes")
    return "\n".join(lines) + "\n"


def _changed(options: Options) -> Iterator[tuple[str, Options]]:
    """The options, and those with one changed, by name."""
    yield "this program", options
    for name, on, other_way in (
        ("reassociate", options.reassociate, replace(options, reassociate=not options.reassociate)),
        ("reciprocal", options.reciprocal, replace(options, reciprocal=not options.reciprocal)),
    ):
        yield f"{'without' if on else 'with'} --{name}", other_way
    other = "unit" if options.sine == "balanced" else "balanced"
    yield f"--sine {other}", replace(options, sine=other)


def _reason(error: Exception) -> str:
    """Last part of an error's first line: what is missing, without the place."""
    return str(error).splitlines()[0].rsplit(" error: ", 1)[-1]


def _inputs(law: Law, rng: np.random.Generator) -> dict[str, Array]:
    inputs, states = draw_ticks(law, POINTS, rng)
    for name, value in states.items():
        inputs[name] = np.full(POINTS, value[0])
    for port in law.of_kind("parameter"):
        inputs[port.name] = np.full(POINTS, port.initial, np.float32)
    return inputs


def _means(compiled: Compiled, inputs: dict[str, Array]) -> dict[str, float]:
    """Mean bound of each result."""
    _, limits = bounds(compiled.graph, inputs)
    return {name: float(np.mean(limit)) for name, limit in limits.items()}
