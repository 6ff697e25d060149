# SPDX-License-Identifier: Apache-2.0
"""Run in a copy of the tree by test_moved_register.py: a program by the Python harness, then by the
C driver over the same Verilated core. Prints what both read as JSON."""

import ctypes
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from asip_asm.assemble import assemble
from asip_asm.c_image import to_c
from sim.core.host import DRIVER
from sim.core.iss.core import Iss
from sim.rtl.asip_bus import CSR, STATUS
from sim.rtl.asip_rtl import AsipRtl

INPUTS = {"x": 3.0, "y": 0.5, "z": 4.0, "counter": 7}
READ = ctypes.CFUNCTYPE(ctypes.c_uint32, ctypes.c_void_p, ctypes.c_uint32)
WRITE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32)


class Bus(ctypes.Structure):
    """asip_bus of asip.h."""

    _fields_ = [("read32", READ), ("write32", WRITE), ("context", ctypes.c_void_p)]


def driver(folder: Path, source: Path) -> ctypes.CDLL:
    """The C driver with `source` as a library."""
    library = folder / "driver.so"
    command = [os.environ.get("CC", "cc"), "-std=c99", "-shared", "-fPIC", f"-I{DRIVER}"]
    command += [f"-I{folder}", source, DRIVER / "asip.c", "-o", library]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(library))


def main(folder: Path, source: Path) -> None:
    image = assemble(DRIVER / "leg_length.s", configuration="small")
    (folder / "leg_length.asip.h").write_text(to_c(image))
    model = Iss(image.to_json())
    model.set_inputs(INPUTS)
    wanted = model.run().output_bits
    names = [output.name for output in image.outputs]
    values = [INPUTS[word.name] for word in image.inputs]
    data = [int(np.float32(v).view(np.uint32)) if isinstance(v, float) else v for v in values]

    core = AsipRtl("small")
    core.load(image)
    addresses = core.input_addresses([word.name for word in image.inputs])
    ran = core.run(addresses, np.array([data], dtype=np.uint32), core.output_addresses(names))
    by_harness = {"words": ran.words[0].tolist(), "status": int(ran.status[0]), "fault": ran.fault}

    core.reset()
    bus = Bus(READ(lambda _, a: core.read(a)), WRITE(lambda _, a, d: core.write(a, d)), None)
    outputs, done = (ctypes.c_uint32 * len(names))(), ctypes.c_int()
    tick = driver(folder, source).tick_by_driver
    tick.argtypes = [Bus, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    words = (ctypes.c_uint32 * len(data))(*data)
    result = tick(bus, words, outputs, ctypes.byref(done))
    by_driver = {"result": result, "words": list(outputs), "done": done.value}
    report = {
        "harness": by_harness,
        "driver": by_driver,
        "wanted": [wanted[name] for name in names],
        "address": CSR["STATUS"],
        "masks": {name: field.mask for name, field in STATUS.items()},
        "status": core.read(CSR["STATUS"]),
        "old_status": core.read(3),
    }
    print(json.dumps(report))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
