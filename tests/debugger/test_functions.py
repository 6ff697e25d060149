# SPDX-License-Identifier: Apache-2.0
"""Programs of asip-model under the debugger, alone and several in one image."""

from __future__ import annotations

import numpy as np
import pytest

from asip_asm.debug_map import Finder
from asip_asm.link import link, link_maps
from asip_asm.model.compiler import compile_law
from asip_asm.model.program import build
from sim.core.backends import IssBackend
from sim.debug.asip_dbg.__main__ import main as asip_dbg
from sim.debug.asip_dbg.program import DebuggedProgram, ProgramError
from sim.laws.asip_model.__main__ import main
from sim.laws.prove_program import draw_ticks
from tests.model_compiler.laws import mixed, sample
from tests.model_compiler.test_several import write_laws

LAWS = {"fast": mixed, "slow": sample}


def seen(image, debug_map, inputs) -> list[dict[tuple[str, int], int | str]]:
    """By position of a tick, the word of each value, or the words that say why there is none."""
    target, finder = IssBackend(), Finder(debug_map)
    target.load(image)
    words = {name: int(value[0].view(np.uint32)) for name, value in inputs.items()}
    target.begin(words, hold=True)
    first = image.entry
    found = []
    while (status := target.poll(0)).kind.name == "HALTED":
        now = {}
        for value in debug_map.values:
            where = finder.where(value, status.position)
            key = value.name, value.version
            now[key] = (
                target.read(where.place)
                if where.place
                else where.text.split(" at ")[0].split(" in ")[0]
            )
        found.append(now | {("bundle", 0): status.position - first})
        target.step()
    assert status.kind.name == "IDLE", status
    return found


def test_values_of_a_function_in_an_image_of_several_are_those_that_it_has_alone(tmp_path):
    built = {n: build(compile_law(law()), tmp_path / f"{n}.s") for n, law in LAWS.items()}
    images = {name: one.image for name, one in built.items()}
    image = link("both", images)
    maps = link_maps(image, images, {name: one.map for name, one in built.items()})
    for name, one in built.items():
        inputs, _ = draw_ticks(one.compiled.law, 1, np.random.default_rng(1))
        inputs = {
            k: v.astype(np.int32 if v.dtype.kind in "iu" else np.float32) for k, v in inputs.items()
        }
        alone = seen(one.image, one.map, inputs)
        assert len(alone) == len(one.image.bundles)
        assert sum(isinstance(word, int) for now in alone for word in now.values()) > 200
        assert seen(image.function(name), maps[name], inputs) == alone


def test_command__a_law_by_its_expressions__and_one_of_several(tmp_path, capsys):
    files = write_laws(tmp_path, ["quick", "slow"])
    stem = tmp_path / "both"
    assert main([*files, "-o", str(stem)]) == 0
    assert main([*files[:2], "-o", str(tmp_path / "one")]) == 0
    capsys.readouterr()
    script = ["-ex", "break y", "-ex", "run", "-ex", "list", "-ex", "finish", "--set", "x=1.5"]
    shown = {}
    for name, options in (
        ("one", [str(tmp_path / "one.asip.json")]),
        ("quick", [f"{stem}.asip.json", "--function", "quick"]),
        ("slow", [f"{stem}.asip.json", "--function", "slow"]),
    ):
        assert asip_dbg([*options, "--iss", "--batch", *script]) == 0
        shown[name] = capsys.readouterr().out
    assert "(x*s, " in shown["one"] and "(x*s, " in shown["quick"], "the law's expression"
    assert "y       1 " in shown["slow"] and "y       0 " in shown["quick"]


def test_function__missing_or_of_no_image__is_refused_with_the_cure(tmp_path):
    main([*write_laws(tmp_path, ["quick", "slow"]), "-o", str(tmp_path / "both")])
    both = tmp_path / "both.asip.json"
    with pytest.raises(ProgramError, match="--function one of: quick, slow"):
        DebuggedProgram(both)
    with pytest.raises(ValueError, match="no function 'odd'; there are quick, slow"):
        DebuggedProgram(both, function="odd")
    with pytest.raises(ProgramError, match="--function is for an image of several"):
        DebuggedProgram(tmp_path / "both.quick.s", function="quick")
    (tmp_path / "both.slow.asip.map.json").unlink()
    with pytest.raises(ProgramError, match="both.slow.asip.map.json: not there; asip-as and"):
        DebuggedProgram(both, function="slow")
