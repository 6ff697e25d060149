# SPDX-License-Identifier: Apache-2.0
"""The dictionary of the device on the bus, and what is generated from it.

The SII image and the ESI file are read here by readers of their own, written from the formats, and
must describe the same device. That a master reads the image: test_masters.py.
"""

from __future__ import annotations

import re
import struct
from xml.etree import ElementTree as ET

import pytest

from scripts.gen_ethercat import generate
from sim.bus.coe import esi, sii
from sim.bus.coe.dictionary import SOURCE, DictionaryError, load
from tests.bench.copies import edited

DEVICE = load()
IMAGE = sii.image(DEVICE)
WANTED = """1000 1001 1008 1009 100A 1018 10F1 1C00 1C12 1C13 1C32 1C33 1600 1A00
603F 6040 6041 605A 605B 605C 605D 605E 6060 6061 6062 6064 6065 6066 606B 606C 6071 6074 6077
607A 607D 6081 6083 6084 6080 6087 6088 608F 6091 6092 606D 606E 606F 6070 6099 609A 60E3
60B8 60B9 60BA 60BB 60BC 60BD 60D0 60D5 60D6 60D7 60D8
60B0 60B1 60B2 60C2 60F4 60FD 60FE 60FF 6502""".split()


def categories(image: bytes) -> dict[int, bytes]:
    """Contents of the SII by category, as a master walks them."""
    found, at = {}, 0x80
    while (kind := int.from_bytes(image[at : at + 2], "little")) != 0xFFFF:
        size = 2 * int.from_bytes(image[at + 2 : at + 4], "little")
        assert kind not in found
        found[kind] = image[at + 4 : at + 4 + size]
        at += 4 + size
    return found


def strings(body: bytes) -> list[str]:
    found, at = [""], 1
    for _ in range(body[0]):
        found.append(body[at + 1 : at + 1 + body[at]].decode())
        at += 1 + body[at]
    return found


def pdos_of_sii(body: bytes, texts: list[str]) -> list[tuple]:
    found, at = [], 0
    while at < len(body):
        index, count, manager, _, name, _ = struct.unpack_from("<H4BH", body, at)
        rows = [struct.unpack_from("<H4BH", body, at + 8 + 8 * n) for n in range(count)]
        entries = [(i, sub, bits, texts[text]) for i, sub, text, _, bits, _ in rows]
        found.append((index, manager, texts[name], entries))
        at += 8 + 8 * count
    return found


def number(text: str) -> int:
    return int(text.removeprefix("#x"), 16) if text.startswith("#x") else int(text)


def pdos_of_esi(device: ET.Element, tag: str) -> list[tuple]:
    return [
        (
            number(pdo.findtext("Index")),
            int(pdo.get("Sm")),
            pdo.findtext("Name"),
            [
                (
                    number(e.findtext("Index")),
                    int(e.findtext("SubIndex", "0")),
                    int(e.findtext("BitLen")),
                    e.findtext("Name", ""),
                )
                for e in pdo.findall("Entry")
            ],
        )
        for pdo in device.findall(tag)
    ]


@pytest.fixture(scope="module")
def device() -> ET.Element:
    return ET.fromstring(esi.document(DEVICE)).find("Descriptions/Devices/Device")


def test_every_wanted_object__on_every_axis__is_there():
    indices = {o.index for o in DEVICE.objects}
    for text in WANTED:
        index = int(text, 16)
        steps = [0x800 * n for n in range(5)] if index >= 0x6000 else [0]
        if 0x1600 <= index <= 0x1AFF:
            steps = [0x10 * n for n in range(6)]
        assert {index + step for step in steps} <= indices


def test_check_sum_of_the_image__known_answer_and_any_flipped_bit():
    assert sii.crc8(b"123456789") == 0xFB
    assert IMAGE[14] == sii.crc8(IMAGE[:14])
    for bit in range(14 * 8):
        damaged = bytearray(IMAGE[:14])
        damaged[bit // 8] ^= 1 << bit % 8
        assert sii.crc8(bytes(damaged)) != IMAGE[14]


def test_fixed_words_of_the_image():
    assert struct.unpack_from("<4I", IMAGE, 16) == tuple(
        DEVICE.device[k] for k in ("vendor", "product", "revision", "serial")
    )
    assert struct.unpack_from("<5H", IMAGE, 0x30) == (0x1000, 256, 0x1100, 256, 12)
    assert IMAGE[0x28:0x30] == IMAGE[0x30:0x38]  # the bootstrap mailbox
    kilobits, version = struct.unpack_from("<2H", IMAGE, 0x7C)
    assert (kilobits + 1) * 128 == len(IMAGE) and version == 1
    found = categories(IMAGE)
    assert set(found) == {10, 30, 40, 41, 50, 51, 60}
    assert len(found[30]) == 32 and len(found[41]) == 32 and len(found[60]) == 48
    assert found[30][5] == 0x2F  # as CoE of the ESI file below
    assert found[30][9] == DEVICE.device["axes"]
    assert found[30][11] == 0x08  # as IdentificationReg134 of the ESI file below
    assert strings(found[10])[found[30][3]] == DEVICE.device["name"]


def test_sii_and_esi__tell_the_same_device(device):
    found = categories(IMAGE)
    texts = strings(found[10])
    for kind, tag in ((51, "RxPdo"), (50, "TxPdo")):
        assert pdos_of_sii(found[kind], texts) == pdos_of_esi(device, tag)
    managers = [struct.unpack_from("<2H4B", found[41], 8 * n) for n in range(4)]
    assert [(m[0], m[1], m[2]) for m in managers] == [
        tuple(number(s.get(key)) for key in ("StartAddress", "DefaultSize", "ControlByte"))
        for s in device.findall("Sm")
    ]
    kind = device.find("Type")
    assert (number(kind.get("ProductCode")), number(kind.get("RevisionNo"))) == struct.unpack_from(
        "<2I", IMAGE, 20
    )
    assert bytes.fromhex(device.findtext("Eeprom/ConfigData")) == IMAGE[:14]
    assert int(device.findtext("Eeprom/ByteSize")) == len(IMAGE)
    assert (device.findtext("Info/IdentificationReg134") == "true") == bool(found[30][11] & 0x08)
    assert bytes.fromhex(device.findtext("Eeprom/BootStrap")) == IMAGE[0x28:0x30]
    assert (device.find("Mailbox/FoE") is not None) == bool(found[30][6] & 1)
    coe = device.find("Mailbox/CoE")
    flags = ("SdoInfo", "PdoAssign", "PdoConfig", "PdoUpload", "CompleteAccess")
    assert found[30][5] == 1 | sum(
        2 << bit for bit, name in enumerate(flags) if coe.get(name) == "1"
    )
    modes = [struct.unpack_from("<3IhHh2B", found[60], 24 * n) for n in range(2)]
    assert [(texts[m[6]], m[4]) for m in modes] == [
        (m.findtext("Name"), number(m.findtext("AssignActivate")))
        for m in device.findall("Dc/OpMode")
    ]


def test_esi__every_type_is_defined_and_every_size_fits(device):
    types = {t.findtext("Name"): t for t in device.findall("Profile/Dictionary/DataTypes/DataType")}
    objects = device.findall("Profile/Dictionary/Objects/Object")
    assert len(objects) == len(DEVICE.objects)
    for one in objects:
        kind = types[one.findtext("Type")]
        assert one.findtext("BitSize") == kind.findtext("BitSize")
        items = kind.findall("SubItem")
        end = 0
        for item in items:
            bits, at = int(item.findtext("BitSize")), int(item.findtext("BitOffs"))
            assert types[item.findtext("Type")].findtext("BitSize") == str(bits)
            assert at >= end
            end = at + bits
        assert end <= int(kind.findtext("BitSize"))
        data = [d.text or "" for d in one.iter("DefaultData")]
        sizes = [int(i.findtext("BitSize")) for i in items] or [int(one.findtext("BitSize"))]
        assert [8 * len(bytes.fromhex(d)) for d in data if d] == [
            max(8, size) for size, d in zip(sizes, data, strict=True) if d
        ]


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('type = "u32"\naccess = "const"', 'type = "u33"\naccess = "const"', "1000:00: type 'u33'"),
        ("index = 0x1001", "index = 0x1000", "1000 appears twice"),
        ("default = 0x3AD", "default = 0x1000003AD", "6502:00: default"),
        ("default = 37", "default = 36", "6098:00: default 36 is not of its values"),
        ('objects = ["digital_inputs"]', 'objects = ["statuswort"]', "no object 'statuswort'"),
        ('objects = ["digital_inputs"]', 'objects = ["digital_outputs"]', "not to be mapped there"),
        ("bytes = 512", "bytes = 100", "101 bytes of outputs do not fit"),
        (
            'field = "statusword"',
            'field = "status word"',
            "6041:00: field 'status word'",
        ),
        ('field = "pose[0]"', 'field = "pose[0"', "field 'pose[0' is no C name"),
        ("[mailbox]", "[mailbocks]", "unknown table mailbocks"),
        ("[device]", "[device", "line 11"),
        ('kind = "info"', 'kind = "note"', "diagnosis FIRMWARE: kind 'note'"),
        ("cycle_us = 100", "cycle_us = 30", "cycle_us = 30: a millisecond has to be a whole"),
        ("cycle_us = 100", "cycle_us = 62.5", "1C32:05 has default = 100000, but cycle_us"),
        ("bytes = 480", "bytes = 480\nstored = true", "2020:00: stored, but not a number"),
    ],
)
def test_wrong_source__is_told_with_its_place(tmp_path, before, after, message):
    place = edited(SOURCE, tmp_path, before, after)
    with pytest.raises(DictionaryError, match=re.escape(message)) as caught:
        load(place)
    assert str(place) in str(caught.value)


def test_generated_files__hold_the_whole_image():
    rows = generate()["nios_sw/ethercat/gen/sii.hex"].splitlines()[1:]
    assert bytes.fromhex(" ".join(rows)) == IMAGE
