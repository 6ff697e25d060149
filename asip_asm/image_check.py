# SPDX-License-Identifier: Apache-2.0
"""Rules of a program image that concern more than one of its entries."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from asip_asm.expression import literal_name
from asip_asm.isa import Isa

if TYPE_CHECKING:
    from asip_asm.image import Image

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*")


def problem(image: Image, isa: Isa) -> str:
    """The first rule that the image breaks, in words; empty if it breaks none."""
    return next(_problems(image, isa), "")


def _problems(image: Image, isa: Isa) -> Iterator[str]:
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
            yield f"a source of bundle {i} stands in a slot that '{image.configuration}' has not"
    places = {"entry": image.entry} | {f"label '{k}'": v for k, v in image.labels.items()}
    for what, address in places.items():
        if address >= len(image.bundles):
            yield f"{what} is {address}, the program has {len(image.bundles)} bundles"
    for name, address in image.data_names.items():
        if address >= len(image.data):
            yield f"data name '{name}' is {address}, the image has {len(image.data)} data words"
    yield from _bank_k(image)
    yield from _twice("index of an output", (o.index for o in image.outputs))
    yield from _twice("register of a state", (s.register for s in image.states))
    for what in ("inputs", "outputs", "states", "exports"):
        yield from _twice(f"name in {what}", (entry.name for entry in getattr(image, what)))
    for entry in (*image.states, *image.exports):
        bank = isa.banks[entry.register[0].upper()]
        if int(entry.register[1:]) >= bank.size or (
            bank.name == "B" and configuration.fma_pipes < 2
        ):
            yield f"'{entry.name}' is in register {entry.register}, which does not exist"
    for state in image.states:
        if state.register[0] == "k":
            yield f"state '{state.name}' is in bank K, which programs cannot write"
    outputs = sum(1 << output.index for output in image.outputs)
    if image.output_mask & ~outputs:
        yield f"output_mask {image.output_mask:08x} asks for outputs that are not declared"


def _bank_k(image: Image) -> Iterator[str]:
    """A word of bank K holds one input or one constant, which may have several names."""
    yield from _twice("index of an input", (entry.index for entry in image.inputs))
    owner: dict[int, Any] = {entry.index: entry for entry in image.inputs}
    for constant in image.constants:
        other = owner.setdefault(constant.index, constant)
        if (getattr(other, "bits", None), other.type) != (constant.bits, constant.type):
            yield f"k{constant.index} holds '{other.name}' and '{constant.name}'"
        value = literal_name(int(constant.bits, 16), constant.type)
        if constant.name != value and not _NAME.fullmatch(constant.name):
            yield f"constant k{constant.index} is named '{constant.name:.40}', its value is {value}"


def _twice(what: str, items: Iterable[int | str]) -> Iterator[str]:
    seen: set[int | str] = set()
    for item in items:
        if item in seen:
            yield f"{what} {item!r} stands twice"
        seen.add(item)
