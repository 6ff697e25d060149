# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT slave information (ESI) file: what a configuration tool reads about the device.

Format: ETG.2000, EtherCATInfo version 1.16. Numbers in hexadecimal start with `#x`.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

from sim.coe import sii
from sim.coe.c_tables import ORIGIN
from sim.coe.dictionary import TYPES, Device, Entry, Object, Pdo

ACCESS = {"ro": "ro", "const": "ro", "rw": "rw", "preop": "rw"}


def document(device: Device) -> str:
    """The whole file."""
    head = device.device
    root = ET.Element("EtherCATInfo", {"Version": "1.16"})
    root.append(ET.Comment(f" {ORIGIN} "))
    vendor = ET.SubElement(root, "Vendor")
    put(vendor, "Id", hexadecimal(head["vendor"]))
    put(vendor, "Name", head["vendor_name"])
    descriptions = ET.SubElement(root, "Descriptions")
    group = ET.SubElement(ET.SubElement(descriptions, "Groups"), "Group")
    put(group, "Type", head["order"])
    put(group, "Name", head["group"])
    one = ET.SubElement(ET.SubElement(descriptions, "Devices"), "Device", {"Physics": "YY"})
    put(
        one,
        "Type",
        head["order"],
        ProductCode=hexadecimal(head["product"]),
        RevisionNo=hexadecimal(head["revision"]),
    )
    put(one, "Name", head["name"])
    info(one, device)
    put(one, "GroupType", head["order"])
    profile(one, device)
    for text in ("Outputs", "Inputs", "MBoxState"):
        put(one, "Fmmu", text)
    managers(one, device)
    for direction, tag, manager in (("rx", "RxPdo", 2), ("tx", "TxPdo", 3)):
        for pdo in device.direction(direction):
            process_data(one, device, pdo, tag, manager)
    mailbox = ET.SubElement(one, "Mailbox", {"DataLinkLayer": "1"})
    ET.SubElement(
        mailbox,
        "CoE",
        {"SdoInfo": "1", "PdoAssign": "1", "PdoConfig": "1", "SegmentedSdo": "1"},
    )
    clock = ET.SubElement(one, "Dc")
    for name, cycle, activate in sii.modes(device):
        mode = ET.SubElement(clock, "OpMode")
        put(mode, "Name", name)
        put(mode, "Desc", "with the outputs" if not activate else "with SYNC0")
        put(mode, "AssignActivate", hexadecimal(activate, 4))
        if activate:
            put(mode, "CycleTimeSync0", str(cycle), Factor="0")
            put(mode, "ShiftTimeSync0", "0")
    image = sii.image(device)
    eeprom = ET.SubElement(one, "Eeprom")
    put(eeprom, "ByteSize", str(len(image)))
    put(eeprom, "ConfigData", image[:14].hex().upper())
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def put(parent: ET.Element, tag: str, text: str, **attributes: str) -> ET.Element:
    found = ET.SubElement(parent, tag, attributes)
    found.text = text
    return found


def hexadecimal(value: int, digits: int = 8) -> str:
    return f"#x{value:0{digits}X}"


def info(one: ET.Element, device: Device) -> None:
    machine = ET.SubElement(ET.SubElement(one, "Info"), "StateMachine")
    timeout = ET.SubElement(machine, "Timeout")
    process = device.process_data
    put(timeout, "PreopTimeout", str(process["timeout_preop_ms"]))
    put(timeout, "SafeopOpTimeout", str(process["timeout_safeop_op_ms"]))
    put(timeout, "BackToInitTimeout", str(process["timeout_back_ms"]))
    put(timeout, "BackToSafeopTimeout", str(process["timeout_back_ms"]))


def managers(one: ET.Element, device: Device) -> None:
    mailbox, process = device.mailbox, device.process_data
    rows = [
        ("MBoxOut", mailbox["out"], mailbox["bytes"], 0x26),
        ("MBoxIn", mailbox["in"], mailbox["bytes"], 0x22),
        ("Outputs", process["outputs"], device.bytes("rx"), 0x64),
        ("Inputs", process["inputs"], device.bytes("tx"), 0x20),
    ]
    for text, start, size, control in rows:
        put(
            one,
            "Sm",
            text,
            DefaultSize=str(size),
            StartAddress=hexadecimal(start, 4),
            ControlByte=hexadecimal(control, 2),
            Enable="1",
        )


def process_data(one: ET.Element, device: Device, pdo: Pdo, tag: str, manager: int) -> None:
    found = ET.SubElement(one, tag, {"Sm": str(manager)})
    put(found, "Index", hexadecimal(pdo.index, 4))
    put(found, "Name", pdo.name)
    for index, subindex, bits in pdo.entries:
        entry = ET.SubElement(found, "Entry")
        put(entry, "Index", hexadecimal(index, 4))
        if index:
            described = device.object(index).entry(subindex)
            put(entry, "SubIndex", str(subindex))
            put(entry, "BitLen", str(bits))
            put(entry, "Name", described.name)
            put(entry, "DataType", TYPES[described.type].name)
        else:
            put(entry, "BitLen", str(bits))


def profile(one: ET.Element, device: Device) -> None:
    """Profile with the dictionary: data types first, then the objects that use them."""
    found = ET.SubElement(one, "Profile")
    put(found, "ProfileNo", "402")
    dictionary = ET.SubElement(found, "Dictionary")
    types = ET.SubElement(dictionary, "DataTypes")
    objects = ET.SubElement(dictionary, "Objects")
    done: set[str] = set()
    for one_object in device.objects:
        name, bits = type_of(one_object)
        if name not in done:
            done.add(name)
            describe_type(types, one_object, name, bits, done)
        describe(objects, one_object, name, bits)


def type_of(found: Object) -> tuple[str, int]:
    """Name and bits of an object's type; a structure has its subindices at multiples of 16 bits,
    subindex 0 in the first."""
    if found.kind == "var":
        return plain(found.entries[0]), found.entries[0].bits
    return f"DT{found.index:04X}", 16 + sum(e.bits for e in found.entries[1:])


def plain(entry: Entry) -> str:
    return f"STRING({entry.bytes})" if entry.type == "string" else TYPES[entry.type].name


def describe_type(types: ET.Element, found: Object, name: str, bits: int, done: set[str]) -> None:
    if found.kind != "var":
        for entry in found.entries:
            inner = plain(entry)
            if inner not in done:
                done.add(inner)
                basic(types, inner, entry.bits)
    else:
        basic(types, name, bits)
        return
    kind = ET.SubElement(types, "DataType")
    put(kind, "Name", name)
    put(kind, "BitSize", str(bits))
    at = 0
    for entry in found.entries:
        item = ET.SubElement(kind, "SubItem")
        put(item, "SubIdx", str(entry.subindex))
        put(item, "Name", entry.name)
        put(item, "Type", plain(entry))
        put(item, "BitSize", str(entry.bits))
        put(item, "BitOffs", str(at))
        flags(item, entry)
        at += entry.bits if entry.subindex else 16


def basic(types: ET.Element, name: str, bits: int) -> None:
    kind = ET.SubElement(types, "DataType")
    put(kind, "Name", name)
    put(kind, "BitSize", str(bits))


def flags(parent: ET.Element, entry: Entry) -> None:
    found = ET.SubElement(parent, "Flags")
    access = put(found, "Access", ACCESS[entry.access])
    if entry.access == "preop":
        access.set("WriteRestrictions", "PreOP")
    if entry.pdo:
        put(found, "PdoMapping", "R" if entry.pdo == "rx" else "T")


def describe(objects: ET.Element, found: Object, name: str, bits: int) -> None:
    one = ET.SubElement(objects, "Object")
    put(one, "Index", hexadecimal(found.index, 4))
    put(one, "Name", found.name if found.axis is None else f"Axis {found.axis + 1}: {found.name}")
    put(one, "Type", name)
    put(one, "BitSize", str(bits))
    content = ET.SubElement(one, "Info")
    if found.kind == "var":
        put(content, "DefaultData", found.entries[0].data().hex().upper())
        flags(one, found.entries[0])
        return
    for entry in found.entries:
        item = ET.SubElement(content, "SubItem")
        put(item, "Name", entry.name)
        put(ET.SubElement(item, "Info"), "DefaultData", entry.data().hex().upper())
    ET.SubElement(one, "Flags")
