# SPDX-License-Identifier: Apache-2.0
"""Several programs in one image: own entries, states and outputs, shared constants."""

from __future__ import annotations

from pathlib import Path

import pytest

from asip_asm.c_image import to_c
from asip_asm.cli_objdump import header
from asip_asm.image import Image, ImageError
from asip_asm.link import LinkError, link
from sim.core.api import Core
from sim.debug.asip_run.__main__ import main as asip_run
from tests.asip.core_bench import assembled
from tests.asip.test_driver import build, execute

FAST = """\
.program "sum"
.input   x
.const   limit = 100.0
.state   total = 1.0
.data    step = 2.0
.output  F, safe = -1.0
        ld      s, step
        fmadd   total, x, s, total
        fsat    F, total, -100.0, limit
        halt
"""
# Counts down n, so that its branch shows whether it was moved.
SLOW = """\
.program "product"
.param   gain = 3.0
.input   n : int
.state   product = 1.0
.data    other = 7.0, 0.5
.output  product_out, safe = -2.0
        mov     left, n
again:  fmul    product, product, gain
        iadd    left, left, -1
        bnz     left, again
        ld      half, other+1
        fmul    t, product, half
        fsat    product_out, t, -100.0, 100.0
        halt
"""


def programs(configuration: str = "fast") -> dict[str, Image]:
    texts = {"fast": FAST, "slow": SLOW}
    found = {name: assembled(text, configuration, optimise=True) for name, text in texts.items()}
    found["slow"].parameters = ["gain"]
    return found


@pytest.fixture
def image(configuration) -> Image:
    return link("both", programs(configuration))


def expected():
    """Outputs of five ticks of fast with 0.5, one of slow with 3, three times."""
    total, product = 1.0, 1.0
    for _ in range(3):
        for _ in range(5):
            total += 1.0
            yield "fast", {"x": 0.5}, total
        product *= 27.0
        yield "slow", {"n": 3}, min(100.0, product / 2)


@pytest.mark.parametrize("backend", ("rtl", "iss"))
def test_functions_keep_their_states_between_one_another(image, backend):
    with Core(image, backend=backend) as core:
        assert core.inputs == ("x",) and core.states == ("total",)
        for name, inputs, want in expected():
            core.select(name)
            assert list(core.tick(inputs).values()) == [want]
        core.select("fast")
        assert core.read("total") == 16.0
        with pytest.raises(ImageError, match="both: no function 'third'; there are fast, slow"):
            core.select("third")


def test_image_with_functions_is_written_and_read_again(image, tmp_path):
    image.save(tmp_path / "both.asip.json")
    again = Image.load(tmp_path / "both.asip.json")
    assert again == image and [f.name for f in again.functions] == ["fast", "slow"]
    assert len({c.index for c in image.constants if c.bits == "42c80000"}) == 1  # 100.0
    assert image.parameters == ["slow.gain"]
    registers = [s.register for s in image.states]
    assert len(set(registers)) == 2
    assert f"  slow         entry {image.functions[1].entry}, cycles None" in header(image)
    assert "functions" not in programs()["fast"].to_json()


def test_a_damaged_function_is_refused(image):
    data = image.to_json()
    data["functions"][1]["entry"] = 900
    with pytest.raises(ImageError, match="entry of function 'slow' is 900"):
        Image.from_json(data, sealed=False)
    data = image.to_json()
    data["functions"][1]["output_mask"] = 4
    with pytest.raises(ImageError, match="output_mask 00000004 asks for outputs"):
        Image.from_json(data, sealed=False)


def test_c_driver_runs_the_functions(image, tmp_path, configuration):
    main = Path(__file__).with_name("two_functions.c")
    status, lines = execute(build(tmp_path, configuration, main, {"both.asip.h": to_c(image)}))
    rows = [want for _, _, want in expected()]
    wanted = [
        " ".join(f"{w:g}" for w in rows[6 * i : 6 * i + 5]) + f" | {rows[6 * i + 5]:g}"
        for i in range(3)
    ]
    assert status == 0 and lines == [*wanted, "2 | 100"]


def test_asip_run_asks_for_the_function(image, tmp_path, capsys):
    path = tmp_path / "both.asip.json"
    image.save(path)
    assert asip_run([str(path), "--iss"]) == 2
    assert "holds the functions fast, slow; choose one with --function" in capsys.readouterr().err
    assert asip_run([str(path), "--iss", "--function", "slow", "--set", "n=2"]) == 0
    assert "product_out = 4.5" in capsys.readouterr().out
    assert asip_run([str(path), "--iss", "--function", "none"]) == 1
    assert "no function 'none'; there are fast, slow" in capsys.readouterr().err


def many(lines: list[str]) -> Image:
    return assembled("\n".join([*lines, "        halt", ""]), optimise=True)


def test_what_does_not_fit_is_named_with_its_cure():
    outputs = [f".output o_{i}, safe = 0.0" for i in range(20)]
    outputs += [f"        mov o_{i}, zero" for i in range(20)]
    wide = many(outputs)
    with pytest.raises(LinkError, match=r"40 outputs \(a 20, b 20\), the core has 32; export"):
        link("x", {"a": wide, "b": wide})
    states = [f".state s_{i} = 0.0, pin C" for i in range(40)]
    states += [f"        fabs s_{i}, s_{i}" for i in range(40)]
    full = many(states)
    with pytest.raises(LinkError, match="states and exports of all functions 80; the bank has 64"):
        link("x", {"a": full, "b": full})
    inputs = [f".input i_{i}" for i in range(70)] + [".output o, safe = 0.0"]
    inputs += ["        mov o, i_0"]
    wide_k = many(inputs)
    with pytest.raises(LinkError, match="140 inputs and 0 constants .* bank K holds 128"):
        link("x", {"a": wide_k, "b": wide_k})
    with pytest.raises(LinkError, match="different configurations"):
        link("x", {"a": programs()["fast"], "b": programs("small")["slow"]})
    with pytest.raises(LinkError, match="'a b' cannot name a function"):
        link("x", {"a b": wide, "c": wide})
