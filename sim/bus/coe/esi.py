# SPDX-License-Identifier: Apache-2.0
"""The EtherCAT slave information (ESI) file: what a configuration tool reads about the device.

Format: ETG.2000, EtherCATInfo version 1.16. Numbers in hexadecimal start with `#x`.
"""

from __future__ import annotations

from xml.etree import ElementTree as ET

from sim.bus.coe import sii
from sim.bus.coe.c_tables import ORIGIN
from sim.bus.coe.dictionary import TYPES, Device, Entry, Object, Pdo

ACCESS = {"ro": "ro", "const": "ro", "rw": "rw", "preop": "rw"}


def document(device: Device) -> str:
    """The whole file."""
    head = device.device
    root = ET.Element("EtherCATInfo", {"Version": "1.16"})
    root.append(ET.Comment(f" {ORIGIN} "))
    child(root, "Vendor", Id=hexadecimal(head["vendor"]), Name=head["vendor_name"])
    descriptions = ET.SubElement(root, "Descriptions")
    child(child(descriptions, "Groups"), "Group", Type=head["order"], Name=head["group"])
    one = ET.SubElement(child(descriptions, "Devices"), "Device", {"Physics": "YY"})
    product, revision = hexadecimal(head["product"]), hexadecimal(head["revision"])
    put(one, "Type", head["order"], ProductCode=product, RevisionNo=revision)
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
    services = ("SdoInfo", "PdoAssign", "PdoConfig", "CompleteAccess", "SegmentedSdo")
    ET.SubElement(mailbox, "CoE", dict.fromkeys(services, "1"))
    ET.SubElement(mailbox, "FoE")
    clock = child(one, "Dc")
    for name, factor, activate in sii.MODES:
        text = "with SYNC0" if activate else "with the outputs"
        mode = child(clock, "OpMode", Name=name, Desc=text, AssignActivate=hexadecimal(activate, 4))
        if activate:
            put(mode, "CycleTimeSync0", "0", Factor=str(factor))
            put(mode, "ShiftTimeSync0", "0")
    image = sii.image(device)
    eeprom = child(one, "Eeprom", ByteSize=len(image), ConfigData=image[:14].hex().upper())
    put(eeprom, "BootStrap", sii.mailboxes(device).hex().upper())
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


def put(parent: ET.Element, tag: str, text: str, **attributes: str) -> ET.Element:
    found = ET.SubElement(parent, tag, attributes)
    found.text = text
    return found


def child(parent: ET.Element, tag: str, **texts: str | int) -> ET.Element:
    """A new element with elements in it that have these texts."""
    found = ET.SubElement(parent, tag)
    for name, text in texts.items():
        put(found, name, str(text))
    return found


def hexadecimal(value: int, digits: int = 8) -> str:
    return f"#x{value:0{digits}X}"


def info(one: ET.Element, device: Device) -> None:
    process = device.process_data
    found = child(one, "Info")
    child(
        child(found, "StateMachine"),
        "Timeout",
        PreopTimeout=process["timeout_preop_ms"],
        SafeopOpTimeout=process["timeout_safeop_op_ms"],
        BackToInitTimeout=process["timeout_back_ms"],
        BackToSafeopTimeout=process["timeout_back_ms"],
    )
    put(found, "IdentificationReg134", "true")


def managers(one: ET.Element, device: Device) -> None:
    for text, start, size, control in sii.managers(device):
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
        texts: dict[str, str | int] = {"BitLen": bits}
        if index:
            described = device.object(index).entry(subindex)
            texts = {"SubIndex": subindex, **texts, "Name": described.name}
            texts["DataType"] = TYPES[described.type].name
        child(found, "Entry", Index=hexadecimal(index, 4), **texts)


def profile(one: ET.Element, device: Device) -> None:
    """Profile with the dictionary: data types first, then the objects that use them."""
    found = child(one, "Profile", ProfileNo=402)
    dictionary = child(found, "Dictionary")
    types, objects = child(dictionary, "DataTypes"), child(dictionary, "Objects")
    texts = child(found, "DiagMessages")
    for number, text in enumerate(device.diagnosis, start=1):
        message = child(texts, "DiagMessage", TextId=hexadecimal(number, 4))
        put(message, "MessageText", text.text, LcId="1033")
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
    return f"DT{found.index:04X}", 16 + sum(8 * e.bytes for e in found.entries[1:])


def plain(entry: Entry) -> str:
    name = TYPES[entry.type].name
    return f"{name}({entry.bytes})" if entry.type in ("string", "octets") else name


def describe_type(types: ET.Element, found: Object, name: str, bits: int, done: set[str]) -> None:
    entries = found.entries if found.kind != "var" else ()
    for entry in entries:
        inner = plain(entry)
        if inner not in done:
            done.add(inner)
            child(types, "DataType", Name=inner, BitSize=entry.bits)
    kind = child(types, "DataType", Name=name, BitSize=bits)
    at = 0
    for entry in entries:
        item = child(kind, "SubItem", SubIdx=entry.subindex, Name=entry.name, Type=plain(entry),
                     BitSize=entry.bits, BitOffs=at)  # fmt: skip
        flags(item, entry)
        at += 8 * entry.bytes if entry.subindex else 16


def flags(parent: ET.Element, entry: Entry) -> None:
    found = child(parent, "Flags")
    access = put(found, "Access", ACCESS[entry.access])
    if entry.access == "preop":
        access.set("WriteRestrictions", "PreOP")
    if entry.pdo:
        put(found, "PdoMapping", "R" if entry.pdo == "rx" else "T")
    if entry.stored:
        put(found, "Backup", "1")


def describe(objects: ET.Element, found: Object, name: str, bits: int) -> None:
    shown = found.name if found.axis is None else f"Axis {found.axis + 1}: {found.name}"
    index = hexadecimal(found.index, 4)
    one = child(objects, "Object", Index=index, Name=shown, Type=name, BitSize=bits)
    content = child(one, "Info")
    if found.kind == "var":
        put(content, "DefaultData", found.entries[0].data().hex().upper())
        flags(one, found.entries[0])
        return
    for entry in found.entries:
        item = child(content, "SubItem", Name=entry.name)
        child(item, "Info", DefaultData=entry.data().hex().upper())
    child(one, "Flags")
