# SPDX-License-Identifier: Apache-2.0
"""Image files: what is written is read back, damaged files are refused, memory formats agree."""

import json
from pathlib import Path

import pytest

from asip_asm.cli_objdump import main as asip_objdump
from asip_asm.image import (
    ConstantEntry,
    Image,
    ImageError,
    checksum,
)
from asip_asm.memory_formats import to_intel_hex, to_mif, to_readmemh
from sim.core.iss import Iss
from tests.asm.annotated import FOLDER, run


@pytest.fixture(scope="module", params=["ok_bundles.s", "ok_small.s"])
def image(request: pytest.FixtureRequest) -> Image:
    return run(FOLDER / request.param)


def memory(image: Image) -> dict[int, int]:
    """Bytes of program memory by byte address, from the bundles alone: lanes little endian."""
    lanes = -(-len(image.bundles[0]) // 8)
    result = {}
    for address, bundle in enumerate(image.bundles):
        data = int(bundle, 16).to_bytes(4 * lanes, "little")
        result.update({16 * address + i: byte for i, byte in enumerate(data)})
    return result


def test_save_and_load__give_the_same_image(image: Image, tmp_path: Path) -> None:
    path = tmp_path / "x.asip.json"
    image.save(path)
    assert Image.load(path) == image


def test_json__has_the_published_keys_in_order(image: Image) -> None:
    keys = "format version checksum title configuration entry bundles sources constants inputs "
    keys += "outputs states exports data data_names labels watchdog output_mask cycles"
    assert list(json.loads(image.dumps())) == keys.split()


def test_intel_hex__checksums_are_zero_and_bytes_are_the_program(image: Image) -> None:
    found = {}
    rows = to_intel_hex(image).splitlines()
    for row in rows:
        assert row[0] == ":" and row == row.upper()
        record = bytes.fromhex(row[1:])
        assert sum(record) & 0xFF == 0
        assert len(record) == record[0] + 5
        start = int.from_bytes(record[1:3], "big")
        if record[3] == 0:
            found.update({start + i: byte for i, byte in enumerate(record[4:-1])})
    assert rows[-1] == ":00000001FF"
    assert found == memory(image)


def test_readmemh__is_one_bundle_per_line(image: Image) -> None:
    assert to_readmemh(image).split() == image.bundles


def test_mif__states_width_depth_and_every_bundle(image: Image) -> None:
    rows = to_mif(image).splitlines()
    width = {"fast": 128, "small": 48}[image.configuration]
    assert rows[:2] == [f"WIDTH={width};", f"DEPTH={len(image.bundles)};"]
    content = rows[rows.index("CONTENT BEGIN") + 1 : rows.index("END;")]
    assert [row.strip(" ;").split(" : ") for row in content] == [
        [f"{i:x}", bundle] for i, bundle in enumerate(image.bundles)
    ]


def entry(kind: str, **changes: object) -> list[dict[str, object]]:
    """The entries of the kind in the test's image, the first one changed."""
    entries = run(FOLDER / "ok_leg_length.s").to_json()[kind]
    return [entries[0] | changes, *entries[1:]]


def twice(kind: str, **changes: object) -> list[dict[str, object]]:
    """The first entry of the kind, and the same with changes."""
    return [entry(kind)[0], *entry(kind, **changes)[:1]]


DAMAGED = "damaged image: "
BUNDLE = "0" * 32


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "other"}, "not a program image (no format 'microtick-asip-image')"),
        ({"version": 1}, "image version 1, this tool reads 2; assemble the program again"),
        ({"configuration": "huge"}, DAMAGED + "unknown configuration 'huge'"),
        ({"bundles": ["12"], "sources": [[]]}, DAMAGED + "bundle 0 is not 32 hexadecimal digits"),
        ({"bundles": [], "sources": []}, DAMAGED + "Expected `array` of length >= 1"),
        ({"bundles": [BUNDLE] * 1025}, DAMAGED + "Expected `array` of length <= 1024"),
        ({"bundles": ["G" * 32]}, DAMAGED + "Expected `str` matching regex"),
        ({"sources": []}, DAMAGED + "0 sources for 8 bundles"),
        ({"inputs": [{"name": "x"}]}, DAMAGED + "Object missing required field `index`"),
        ({"colour": 1}, DAMAGED + "Object contains unknown field `colour`"),
        ({"constants": entry("constants", index=-1)}, "Expected `int` >= 0 - at `$.constants[0]"),
        ({"constants": entry("constants", index=128)}, "Expected `int` <= 127"),
        ({"constants": entry("constants", index=0)}, "k0 holds 'x' and"),
        ({"constants": entry("constants", bits="1")}, "Expected `str` matching regex"),
        ({"constants": entry("constants", type="double")}, "Expected `str` matching regex"),
        ({"constants": entry("constants", name="7 8")}, "is named '7 8', its value is"),
        ({"inputs": twice("inputs", name="y")}, "index of an input 0 stands twice"),
        ({"outputs": twice("outputs", name="G")}, "index of an output 0 stands twice"),
        ({"outputs": twice("outputs", index=1)}, "name in outputs 'F1' stands twice"),
        ({"outputs": []}, "output_mask 00000001 asks for outputs that are not declared"),
        ({"outputs": entry("outputs", index=32)}, "Expected `int` <= 31"),
        ({"states": entry("states", register="c64")}, "is in register c64, which does not exist"),
        ({"states": entry("states", register="k3")}, "is in bank K, which programs cannot write"),
        ({"states": twice("states", name="q")}, "register of a state 'c0' stands twice"),
        ({"watchdog": 0}, "Expected `int` >= 1 - at `$.watchdog`"),
        ({"watchdog": 1e400}, "not a JSON file: JSON is malformed"),
        ({"watchdog": "10"}, "Expected `int`, got `str` - at `$.watchdog`"),
        ({"entry": 8}, DAMAGED + "entry is 8, the program has 8 bundles"),
        ({"labels": {"again": 9}}, DAMAGED + "label 'again' is 9, the program has 8 bundles"),
        (
            {"data_names": {"table": 0}, "data": []},
            DAMAGED + "data name 'table' is 0, the image has 0",
        ),
        ({"data": ["00000000"] * 1025}, DAMAGED + "Expected `array` of length <= 1024"),
        ({"title": "a\nb"}, DAMAGED + "Expected `str` matching regex"),
    ],
)
def test_load__damaged_file__is_refused_with_the_reason(
    change: dict[str, object], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "x.asip.json"
    data = run(FOLDER / "ok_leg_length.s").to_json() | change
    path.write_text(json.dumps(data | {"checksum": checksum(data)}), encoding="utf-8")
    with pytest.raises(ImageError) as caught:
        Image.load(path)
    assert str(caught.value).startswith(f"{path}: ") and message in str(caught.value)


def test_load__edited_by_hand__is_refused_until_sealed_again(tmp_path: Path, capsys) -> None:
    path = tmp_path / "x.asip.json"
    run(FOLDER / "ok_leg_length.s").save(path)
    text = path.read_text(encoding="utf-8")
    assert '"watchdog": 10000' in text
    path.write_text(text.replace('"watchdog": 10000', '"watchdog": 10001'), encoding="utf-8")
    with pytest.raises(ImageError) as caught:
        Image.load(path)
    assert str(caught.value) == (
        f"{path}: checksum differs: the image was edited or damaged; assemble the program again, "
        "or take it as it is: asip-objdump --reseal"
    )
    assert asip_objdump(["--reseal", str(path)]) == 0
    assert f"{path}: sealed with sha256:" in capsys.readouterr().out
    assert Image.load(path).watchdog == 10001


def test_load__constant_that_is_not_finite__is_read_and_shown(tmp_path: Path, capsys) -> None:
    image = run(FOLDER / "ok_leg_length.s")
    image.constants = [ConstantEntry("nan", 4, "float", "7fc00000"), *image.constants[1:]]
    image.save(tmp_path / "x.asip.json")
    assert asip_objdump(["-d", "-t", str(tmp_path / "x.asip.json")]) == 0
    assert "float 7fc00000 0f7fc00000" in capsys.readouterr().out


def test_check__image_made_in_python__is_refused_like_a_file() -> None:
    image = run(FOLDER / "ok_leg_length.s")
    image.check()
    image.output_mask = 1 << 7
    with pytest.raises(ImageError, match="output_mask 00000080 asks for outputs that are not"):
        image.check()
    with pytest.raises(ImageError, match="output_mask 00000080 asks for outputs that are not"):
        Iss(image)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"; source\n", "not a JSON file"),
        (b"", "not a JSON file"),
        (b"\xff\xfe{\0}\0", "not a JSON file"),
        (b'{"title": "\\ud800"}', "not a JSON file"),
        (b"[" * 100_000, "not a JSON file"),
        (b"[" + b"1," * 3 + b"1]", "not a program image"),
        (b"7", "not a program image"),
    ],
)
def test_load__no_image__is_refused(data: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "x.asip.json"
    path.write_bytes(data)
    with pytest.raises(ImageError, match=message):
        Image.load(path)
