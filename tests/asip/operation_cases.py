# SPDX-License-Identifier: Apache-2.0
"""Directed cases of every operation, worked out by hand: the instruction-set model must give them,
and except for sine and cosine the arithmetic units and their reference.
"""

from __future__ import annotations

NV, DZ, OF, UF, NX = 16, 8, 4, 2, 1
ONE, TWO, THREE, HALF = 0x3F800000, 0x40000000, 0x40400000, 0x3F000000
MINUS_ONE, MINUS_TWO = 0xBF800000, 0xC0000000
ZERO, MINUS_ZERO, INF, MINUS_INF = 0x00000000, 0x80000000, 0x7F800000, 0xFF800000
NAN, QUIET, SIGNALLING = 0x7FC00000, 0xFFC12345, 0x7F800001
MAX, TINY, NORMAL = 0x7F7FFFFF, 0x00000001, 0x00800000
NEXT = 0x3F800001  # 1 + 2^-23

# mnemonic, operands in the order of the assembly, result, flags {nv, dz, of, uf, nx}
CASES = [
    # multiply-add: signs of product and addend, one rounding
    ("fmadd", (TWO, THREE, ONE), 0x40E00000, 0),  # 7
    ("fnmsub", (TWO, THREE, ONE), 0xC0A00000, 0),  # -5
    ("fmsub", (TWO, THREE, ONE), 0x40A00000, 0),  # 5
    ("fnmadd", (TWO, THREE, ONE), 0xC0E00000, 0),  # -7
    # (1+u)^2 - (1+2u) = u^2 with u = 2^-23, exact only if the product is not rounded
    ("fmsub", (NEXT, NEXT, 0x3F800002), 0x28800000, 0),
    ("fmadd", (ONE, ONE, MINUS_ONE), ZERO, 0),
    ("fnmadd", (ONE, ZERO, ZERO), MINUS_ZERO, 0),  # -0 - 0
    ("fmadd", (MAX, TWO, ZERO), INF, OF | NX),
    ("fmadd", (INF, ZERO, ONE), NAN, NV),
    ("fmadd", (INF, ZERO, QUIET), NAN, NV),
    ("fmadd", (ONE, QUIET, ONE), NAN, 0),
    ("fmadd", (ONE, ONE, SIGNALLING), NAN, NV),
    ("fmadd", (0x00FFFFFF, HALF, ZERO), NORMAL, UF | NX),  # tiny as the product alone is
    ("fmadd", (0x007FFFFF, NEXT, ZERO), NORMAL, NX),  # not tiny
    ("fmadd", (ZERO, INF, 0x7FC00001), NAN, NV),
    ("fmadd", (INF, ONE, MINUS_INF), NAN, NV),
    ("fmadd", (INF, NAN, MINUS_INF), NAN, 0),  # a quiet factor hides opposite infinities
    ("fmadd", (TWO, MINUS_ONE, TWO), ZERO, 0),  # exact cancellation
    ("fmadd", (NEXT, NEXT, 0xBF800002), 0x28800000, 0),  # one rounding keeps the low product
    ("fmadd", (0x80000001, TINY, NORMAL), NORMAL, NX),  # a product far below the addend
    ("fmadd", (ZERO, MAX, TINY), TINY, 0),
    ("fmul", (TWO, THREE), 0x40C00000, 0),
    ("fnmul", (TWO, THREE), 0xC0C00000, 0),
    ("fnmul", (ZERO, ONE), MINUS_ZERO, 0),
    ("fmul", (TINY, HALF), ZERO, UF | NX),  # tie to even
    ("fmul", (0x00FFFFFF, HALF), NORMAL, UF | NX),  # below 2^-126 even after rounding to 24 bits
    ("fmul", (0x3F7FFFFE, 0x00800001), NORMAL, NX),  # 2^-126 (1 - 2^-46): not tiny once rounded
    ("fmul", (0x007FFFFF, NEXT), NORMAL, NX),  # of a subnormal operand, not tiny either
    ("fmul", (ZERO, INF), NAN, NV),
    ("fmul", (TINY, TINY), ZERO, UF | NX),
    ("fmul", (MAX, 0xFF7FFFFF), MINUS_INF, OF | NX),
    ("fmul", (SIGNALLING, ONE), NAN, NV),
    ("fmul", (QUIET, ONE), NAN, 0),
    ("fadd", (ONE, TWO), THREE, 0),
    ("fadd", (ONE, 0x33800000), ONE, NX),  # 1 + 2^-24: tie to even
    ("fadd", (MAX, MAX), INF, OF | NX),
    ("fadd", (INF, MINUS_INF), NAN, NV),
    ("fadd", (MINUS_ZERO, MINUS_ZERO), MINUS_ZERO, 0),
    ("fadd", (NEXT, 0x33800000), 0x3F800002, NX),  # tie above an odd number: up
    ("fadd", (ONE, 0xFFA00000), NAN, NV),
    ("fsub", (ONE, TWO), MINUS_ONE, 0),
    ("fsub", (ONE, ONE), ZERO, 0),
    ("fsub", (NORMAL, 0x00800001), 0x80000001, 0),
    ("fsub", (0x00800001, NORMAL), TINY, 0),
    ("fsub", (INF, INF), NAN, NV),
    ("fsub", (ONE, TINY), ONE, NX),
    # comparisons
    ("feq", (ONE, ONE), ONE, 0),
    ("feq", (ZERO, MINUS_ZERO), ONE, 0),
    ("feq", (MINUS_ZERO, ZERO), ONE, 0),
    ("feq", (QUIET, QUIET), ZERO, 0),
    ("feq", (NAN, NAN), ZERO, 0),
    ("feq", (ONE, SIGNALLING), ZERO, NV),
    ("flt", (MINUS_ONE, ONE), ONE, 0),
    ("flt", (MINUS_ZERO, ZERO), ZERO, 0),
    ("flt", (QUIET, ONE), ZERO, NV),
    ("flt", (NAN, ONE), ZERO, NV),
    ("fle", (ZERO, MINUS_ZERO), ONE, 0),
    ("fle", (TWO, ONE), ZERO, 0),
    ("fle", (ONE, QUIET), ZERO, NV),
    ("fmin", (ZERO, MINUS_ZERO), MINUS_ZERO, 0),
    ("fmin", (MINUS_ZERO, ZERO), MINUS_ZERO, 0),
    ("fmin", (QUIET, TWO), TWO, 0),
    ("fmin", (TWO, SIGNALLING), TWO, NV),
    ("fmin", (SIGNALLING, TWO), TWO, NV),
    ("fmin", (QUIET, QUIET), NAN, 0),
    ("fmax", (MINUS_ZERO, ZERO), ZERO, 0),
    ("fmax", (ZERO, MINUS_ZERO), ZERO, 0),
    ("fmax", (MINUS_TWO, MINUS_ONE), MINUS_ONE, 0),
    ("fmax", (SIGNALLING, QUIET), NAN, NV),
    ("fmax", (0x7FC12345, 0xFFC00001), NAN, 0),
    # bits
    ("fabs", (SIGNALLING | 1 << 31,), SIGNALLING, 0),
    ("fabs", (MINUS_ZERO,), ZERO, 0),
    ("fabs", (0xFF812345,), 0x7F812345, 0),  # the payload stays
    ("fneg", (QUIET,), QUIET & 0x7FFFFFFF, 0),
    ("fneg", (ZERO,), MINUS_ZERO, 0),
    ("mov", (0xFFFFFFFF,), 0xFFFFFFFF, 0),
    ("fsgn", (0x80000001,), MINUS_ONE, 0),
    ("fsgn", (INF,), ONE, 0),
    ("fsgn", (MINUS_ZERO,), ZERO, 0),
    ("fsgn", (QUIET,), NAN, 0),
    ("fsgn", (SIGNALLING,), NAN, NV),
    ("fsat", (THREE, MINUS_ONE, TWO), TWO, 0),
    ("fsat", (MINUS_INF, MINUS_ONE, TWO), MINUS_ONE, 0),
    ("fsat", (MINUS_ZERO, ZERO, TWO), MINUS_ZERO, 0),
    ("fsat", (ONE, TWO, MINUS_ONE), NAN, NV),
    ("fsat", (ONE, TWO, ZERO), NAN, NV),
    ("fsat", (ONE, TWO, TWO), TWO, 0),
    ("fsat", (QUIET, MINUS_ONE, ONE), NAN, 0),
    ("fsat", (ONE, SIGNALLING, TWO), NAN, NV),
    ("sel", (TINY, 5, 6), 5, 0),
    ("sel", (MINUS_ZERO, 5, 6), 6, 0),
    ("sel", (QUIET, 5, 6), 6, 0),
    ("sel", (NAN, 1, 2), 2, 0),
    ("selge", (MINUS_ZERO, 5, 6), 5, 0),
    ("selge", (MINUS_ZERO, 1, 2), 1, 0),
    ("selge", (0x80000001, 5, 6), 6, 0),
    ("selge", (SIGNALLING, 5, 6), 6, 0),
    ("selgt", (ZERO, 5, 6), 6, 0),
    ("selgt", (ZERO, 1, 2), 2, 0),
    ("selgt", (TINY, 5, 6), 5, 0),
    ("selgt", (QUIET, 5, 6), 6, 0),
    ("iadd", (0x7FFFFFFF, 1), 0x80000000, 0),
    ("iadd", (0xFFFFFFFF, 2), 1, 0),
    ("isub", (0, 1), 0xFFFFFFFF, 0),
    # division, root, conversions
    ("fdiv", (ONE, TWO), HALF, 0),
    ("fdiv", (ONE, THREE), 0x3EAAAAAB, NX),
    ("fdiv", (MINUS_ONE, ZERO), MINUS_INF, DZ),
    ("fdiv", (ZERO, ZERO), NAN, NV),
    ("fdiv", (TINY, TWO), ZERO, UF | NX),
    ("fdiv", (ZERO, MINUS_ZERO), NAN, NV),
    ("fdiv", (INF, MINUS_INF), NAN, NV),
    ("fdiv", (INF, MINUS_ZERO), MINUS_INF, 0),
    ("fdiv", (0x00FFFFFF, TWO), NORMAL, UF | NX),  # rounds up to 2^-126 and is tiny
    ("fdiv", (3, TINY), THREE, 0),  # subnormals divide exactly
    ("fdiv", (MAX, TINY), INF, OF | NX),
    ("fdiv", (QUIET, ZERO), NAN, 0),
    ("fsqrt", (0x40800000,), TWO, 0),
    ("fsqrt", (TWO,), 0x3FB504F3, NX),
    ("fsqrt", (MINUS_ZERO,), MINUS_ZERO, 0),
    ("fsqrt", (MINUS_ONE,), NAN, NV),
    ("fsqrt", (0x80000001,), NAN, NV),
    ("fsqrt", (0xFFC00000,), NAN, 0),
    ("fsqrt", (TINY,), 0x1A3504F3, NX),
    ("i2f", (0xFFFFFFFF,), MINUS_ONE, 0),
    ("i2f", (16777217,), 0x4B800000, NX),
    ("i2f", (0x80000000,), 0xCF000000, 0),
    ("f2i", (0x40200000,), 2, NX),  # 2.5 to even
    ("f2i", (0xC0600000,), 0xFFFFFFFC, NX),  # -3.5 to even
    ("f2it", (0xC0600000,), 0xFFFFFFFD, NX),  # toward zero
    ("f2i", (QUIET,), 0x7FFFFFFF, NV),
    ("f2i", (0x4F000000,), 0x7FFFFFFF, NV),  # 2^31
    ("f2it", (MINUS_INF,), 0x80000000, NV),
    ("f2i", (0xCF000000,), 0x80000000, 0),  # -2^31
    ("f2i", (NAN,), 0x7FFFFFFF, NV),
    ("f2i", (0xFFC00000,), 0x7FFFFFFF, NV),
    ("f2i", (0xFF800001,), 0x7FFFFFFF, NV),
    ("f2i", (INF,), 0x7FFFFFFF, NV),
    ("f2i", (MINUS_INF,), 0x80000000, NV),
    ("f2i", (0xCF000001,), 0x80000000, NV),  # below -2^31
    ("f2it", (NAN,), 0x7FFFFFFF, NV),
    ("f2it", (0xFFC00000,), 0x7FFFFFFF, NV),
    ("f2it", (0xFF800001,), 0x7FFFFFFF, NV),
    ("f2it", (INF,), 0x7FFFFFFF, NV),
    ("f2it", (0x4F000000,), 0x7FFFFFFF, NV),
    ("f2it", (0xCF000000,), 0x80000000, 0),
    ("f2it", (0xCF000001,), 0x80000000, NV),  # below -2^31
    # sine and cosine: exact points, flags, range
    ("fsin", (MINUS_ZERO,), MINUS_ZERO, 0),
    ("fcos", (MINUS_ZERO,), ONE, 0),
    ("fsin", (ONE,), 0x3F576AA4, NX),  # 0.84147098
    ("fcos", (ONE,), 0x3F0A5140, NX),  # 0.54030231
    ("fsin", (TINY,), TINY, UF | NX),
    ("fsin", (NORMAL,), NORMAL, NX),  # rounds to 2^-126 with 24 bits: not tiny
    ("fsin", (0x43800001,), NAN, NV),  # beyond 256
    ("fcos", (INF,), NAN, NV),
    ("fsin", (QUIET,), NAN, 0),
]
