# SPDX-License-Identifier: Apache-2.0
"""Image files: what is written is read back, damaged files are refused, memory formats agree."""

import json
from pathlib import Path

import pytest

from asip_asm.image import Image, ImageError, to_intel_hex, to_mif, to_readmemh
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
    keys = "format version title configuration entry bundles sources constants inputs outputs "
    keys += "states exports data data_names labels watchdog output_mask cycles"
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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"format": "other"}, "not a program image (no format 'microtick-asip-image')"),
        ({"version": 2}, "image version 2, this tool reads 1"),
        ({"configuration": "huge"}, "unknown configuration 'huge'"),
        ({"bundles": ["12"], "sources": [[]]}, "bundle 0 is not 32 hexadecimal digits"),
        ({"sources": []}, "0 sources for 5 bundles"),
        ({"inputs": [{"name": "x"}]}, "damaged image: "),
        ({"colour": 1}, "damaged image: "),
    ],
)
def test_load__damaged_file__is_refused_with_the_reason(
    change: dict[str, object], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "x.asip.json"
    data = run(FOLDER / "ok_bundles.s").to_json() | change
    path.write_text(json.dumps(data), encoding="utf-8")
    with pytest.raises(ImageError) as caught:
        Image.load(path)
    assert f"{path}: {message}" in str(caught.value)


def test_load__no_json__is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.asip.json"
    path.write_text("; source\n", encoding="utf-8")
    with pytest.raises(ImageError, match="not a JSON file"):
        Image.load(path)
