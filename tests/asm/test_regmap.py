# SPDX-License-Identifier: Apache-2.0
"""Register maps: their source in SystemRDL is checked, words are put together by field."""

from pathlib import Path

import pytest

from asip_asm.gen.asip_regmap import REGMAP
from scripts.regmap_source import RegisterMapError, read_map
from tests.bench.copies import changed, edited

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "asip_asm/regmap.rdl"
CASES = {
    "offset twice": ("CONFIG @ <0x04|0x00>", "'CONFIG' at offset +0x0:0x3 overlaps"),
    "fields overlap": ("fault<[2:2]|[1:1]>", "'fault[1:1]' overlaps with field 'done[1:1]'"),
    "field too high": ("} flags<[12:8]|[32:28]>", "High bit (32) of field 'flags'"),
    "blocks overlap": ("safe @ <0x0480|0x0400>", "'safe' at offset +0x400:0x47F overlaps"),
    "block not aligned": ("registers @ <0x0800|0x0600>", "registers: base 0x0180"),
    "block size": ("mementries = <256|255>", "registers: 255 words are not a power"),
    "unknown access": ("default sw = <rw|wo>;", "Reference to 'wo' not found"),
    "reset too wide": ("= <10000|0x100000000>", "reset value (4294967296)"),
    "fault code twice": ("ADDRESS = <4'd2|4'd1>", "values must be unique"),
    "fault without text": ('<{ desc = "no fault"; }|>', "cause: NONE has no desc"),
    "no csr": ("} <csr|registers_of_the_host> @", "no regfile 'csr'"),
    "syntax": ("csr @ 0x0000<;|>", "regmap.rdl:"),
}


@pytest.mark.parametrize("name", CASES)
def test_register_map__contradiction__is_refused_by_name(name: str, tmp_path: Path) -> None:
    change, message = CASES[name]
    with pytest.raises(RegisterMapError) as caught:
        read_map(changed(SOURCE, tmp_path, change), "asip")
    assert message in str(caught.value)
    assert "regmap.rdl:" in str(caught.value)


def test_register_map__row_of_registers_not_aligned__is_refused(tmp_path: Path) -> None:
    source = ROOT / "rtl/motion/regmap.rdl"
    path = edited(source, tmp_path, "PATH_WORD[8] @ 0x60", "PATH_WORD[8] @ 0x64")
    with pytest.raises(RegisterMapError, match="PATH_WORD: so many .* multiple of 8 words"):
        read_map(path, "motion")


def test_register_map__of_the_project__gives_addresses_and_fields() -> None:
    assert REGMAP.address("STATUS") == 3
    assert REGMAP.registers["STATUS"].fields["cause"].of(0x5A) == 5
    assert REGMAP.blocks["registers"].base == 0x200


def test_word__by_field__and_refused() -> None:
    status = REGMAP.registers["STATUS"]
    assert status.word(done=1, cause=5) == 0x52
    with pytest.raises(ValueError, match="cause: 16 does not fit 4 bits"):
        status.word(cause=16)
    with pytest.raises(KeyError):
        status.word(finished=1)


def test_page_of_register_maps__names_every_source() -> None:
    page = (ROOT / "docs/registers.md").read_text(encoding="utf-8")
    folders = ("asip_asm", "rtl")
    sources = [p.relative_to(ROOT) for f in folders for p in (ROOT / f).rglob("*.rdl")]
    assert len(sources) == 10
    assert [str(p) for p in sources if f"| `{p}` |" not in page] == []
