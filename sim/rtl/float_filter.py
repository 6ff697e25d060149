#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""GTKWave's process filter for binary32: words of eight hexadecimal digits in, numbers out."""

import struct
import sys

for line in sys.stdin:
    try:
        shown = f"{struct.unpack('>f', bytes.fromhex(line.strip()))[0]:.9g}"
    except (ValueError, struct.error):
        shown = line.strip()  # x, z
    print(shown, flush=True)
