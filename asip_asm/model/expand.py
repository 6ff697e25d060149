# SPDX-License-Identifier: Apache-2.0
"""Programs of the functions that the core has no unit for.

Polynomials and reductions are core operations, which no later pass takes apart; what is an exact
identity of other functions is made of real operations. Coefficients are minimax fits (reweighted
least squares on 400 Chebyshev nodes in 40 digits, rounded to binary32). `functions` and
`combinations` state the errors, the domains and what happens outside of them.
"""

from __future__ import annotations

from collections.abc import Sequence

from asip_asm.model.graph import Graph, Node, Rewriter
from asip_asm.model.simplify import simplify

LN2 = 0.6931471805599453
LN2_HIGH = 0.693359375
LN2_LOW = -0.00021219444005469057
PI = 3.141592653589793
MAGIC = 12582912.0
"""1.5 * 2^23: adding it rounds to an integer."""
ONE_BITS = 0x3F800000
LEAST = -32.0
"""Below it exp(x) - 1 is -1, with many digits to spare; the bound that lanes have."""
STEP = 8388608.0
"""Of the exponent field of binary32."""
EXP = (0.5, 0.1666666716337204, 0.041666269302368164, 0.008333264850080013,
       0.0013946190010756254, 0.000199179703486152)  # fmt: skip
EXPM1 = (0.5000000596046448, 0.1666666865348816, 0.04166531562805176, 0.008333072997629642,
         0.00139974569901824, 0.00019992895249743015)  # fmt: skip
EXPM1_BELOW = (0.4999999701976776, 0.1666654348373413, 0.04166720062494278,
               0.008366528898477554, 0.0013882520142942667)  # fmt: skip
LOG = (0.3333333730697632, -0.2500016689300537, 0.19999843835830688, -0.16655564308166504,
       0.1427052915096283, -0.12714794278144836, 0.11735878884792328, -0.09252528101205826,
       0.038806408643722534)  # fmt: skip
ATAN = (-0.33333316445350647, 0.19998489320278168, -0.14243848621845245, 0.10595998167991638,
        -0.060834456235170364)  # fmt: skip
ASIN = (0.16666659712791443, 0.07500510662794113, 0.04451572149991989, 0.03181760758161545,
        0.014402614906430244, 0.037565186619758606)  # fmt: skip
ERF = (1.128379225730896, -0.37612637877464294, 0.11283782869577408, -0.02686544507741928,
       0.005221074912697077, -0.00084847112884745, 0.00011270544200669974,
       -9.680135008238722e-06)  # fmt: skip
ERFC = (7.806815147399902, 5.352680683135986, 0.9438923001289368, 0.010854245163500309,
        -0.002167085185647011, 0.00042822014074772596, -6.476102862507105e-05,
        2.0288274754420854e-05, -2.513267816084408e-07)  # fmt: skip
TANH_ABOVE = (0.014888912439346313, 5.717105159419589e-05)
TANH_BELOW = (1.0, 0.11311112344264984, 0.001206971937790513, 1.2309012618061388e-06)
"""tanh(x/2) = (x/2 + x^3 ABOVE(x^2)) / BELOW(x^2), weighted by what its error does to tanh(x)."""
TANH_FAR = 9.02
"""The size from which tanh is 1 in binary32."""
ATAN_MIDDLE, ATAN_FAR = 0.4375, 2.41421356237
"""Sizes from which pi/4 and pi/2 are the base. The first is above tan(pi/8), 0.414: just beyond it
the roundings around pi/4 weigh most, and the polynomial reaches further.
"""
LARGEST_POWER = 64
LARGE = 2.0**60
"""Its square is finite, and 1 more is the same number."""
SMALLEST = 2.0**-149
"""Positive number of binary32."""


def expand_functions(graph: Graph) -> Graph:
    """The graph without functions that have no unit."""
    return simplify(_Expander(graph).run())


class _Expander(Rewriter):
    def visit(self, index: int, node: Node, args: Sequence[int]) -> int:
        rule = getattr(self, f"_{node.op}", None)
        return rule(*args) if rule and node.args else super().visit(index, node, args)

    # ------------------------------------------------------------------ short hands
    def c(self, value: float) -> int:
        return self.new.const(value)

    def op(self, name: str, *args: int) -> int:
        return self.new.add(name, *args)

    def fma(self, a: int, b: int, c: int) -> int:
        return self.op("fmadd", a, b, c)

    def horner(self, coefficients: Sequence[float], x: int) -> int:
        """Polynomial, lowest coefficient first."""
        result = self.c(coefficients[-1])
        for value in reversed(coefficients[:-1]):
            result = self.fma(result, x, self.c(value))
        return result

    def mark(self, name: str, node: int, *args: int) -> int:
        """Note that the node approximates a function."""
        self.new.functions[node] = (name, args)
        return node

    def nearest(self, x: int) -> int:
        """x rounded to an integer, |x| < 2^22."""
        return self.op("fsub", self.op("fadd", x, self.c(MAGIC)), self.c(MAGIC))

    def power_of_two(self, k: int, bias: int) -> int:
        """2^(k + bias) for an integer k as a float."""
        bits = self.fma(k, self.c(STEP), self.c((127 + bias) * STEP))
        return self.op("f2i", bits)

    # ------------------------------------------------------------------ exponentials, logarithms
    def _exponential(self, x: int) -> int:
        p, k = self._reduced_exponential(self.op("fsat", x, self.c(-86.6), self.c(88.6)))
        return self.op("fmul", self.op("fmul", p, self.power_of_two(k, -1)), self.c(2.0))

    def _half_exponential(self, x: int) -> int:
        """exp(x) / 2 of a number x >= 0: finite up to 89.4, where exp(x) is not."""
        p, k = self._reduced_exponential(self.op("fsat", x, self.c(0.0), self.c(89.41)))
        return self.op("fmul", self.op("fmul", p, self.power_of_two(k, -2)), self.c(2.0))

    def _reduced_exponential(self, x: int) -> tuple[int, int]:
        """p of 0.7 to 1.5 and a whole number k, with exp(x) = 2^k p."""
        k = self.op("fsub", self.fma(x, self.c(1 / LN2), self.c(MAGIC)), self.c(MAGIC))
        r = self.op("fnmsub", k, self.c(LN2_LOW), self.op("fnmsub", k, self.c(LN2_HIGH), x))
        p = self.fma(self.op("fmul", r, r), self.horner(EXP, r), r)
        return self.op("fadd", p, self.c(1.0)), k

    def _exp(self, x: int) -> int:
        return self.mark("exp", self._exponential(x), x)

    def _near_expm1(self, x: int) -> int:
        return self.fma(self.op("fmul", x, x), self.horner(EXPM1, x), x)

    def _expm1(self, x: int) -> int:
        node = self.new.nodes[x]
        for other, arg in (node.args, node.args[::-1]) if node.op == "min" else ():
            if self.new.constant(arg) == 0.0:
                return self.mark("expm1_below", self._expm1_below(other), other)
        small = self._near_expm1(x)
        large = self.op("fsub", self._exponential(x), self.c(1.0))
        near = self.op("flt", self.op("fabs", x), self.c(0.5))
        return self.mark("expm1", self.op("sel", near, small, large), x)

    def _expm1_below(self, x: int) -> int:
        """exp(min(x, 0)) - 1 = 2^k q + (2^k - 1), q = exp(r) - 1: nothing cancels, as 2^k <= 1."""
        near = self.op("fsat", x, self.c(LEAST), self.c(0.0))
        shifted = self.fma(near, self.c(1 / LN2), self.c(MAGIC))
        k = self.op("fsub", shifted, self.c(MAGIC))
        power = self.op("f2i", self.fma(shifted, self.c(STEP), self.c((127 - MAGIC) * STEP)))
        r = self.op("fnmsub", k, self.c(LN2), near)
        square = self.op("fmul", r, r)
        low, high = self.horner(EXPM1_BELOW[:2], r), self.horner(EXPM1_BELOW[2:], r)
        q = self.fma(square, self.fma(square, high, low), r)
        return self.fma(power, q, self.op("fsub", power, self.c(1.0)))

    def _logarithm(self, x: int) -> int:
        bits = self.op("isub", x, self.new.add("int_const", value=ONE_BITS))
        k = self.nearest(self.op("fmul", self.op("i2f", bits), self.c(1 / STEP)))
        scale = self.op("f2i", self.op("fnmsub", k, self.c(STEP), self.c(127 * STEP)))
        f = self.op("fsub", self.op("fmul", x, scale), self.c(1.0))
        square = self.op("fmul", f, f)
        tail = self.op("fmul", self.op("fmul", f, square), self.horner(LOG, f))
        tail = self.op("fnmsub", square, self.c(0.5), tail)
        tail = self.fma(k, self.c(LN2_LOW), tail)
        result = self.fma(k, self.c(LN2_HIGH), self.op("fadd", f, tail))
        # sqrt makes a NaN of a negative number; the logarithm of 0 is a large negative one.
        refused = self.op("fsub", self.op("fsqrt", x), self.c(3e38))
        return self.op("selgt", x, result, refused)

    def _log(self, x: int) -> int:
        return self.mark("log", self._logarithm(x), x)

    def _log1p(self, x: int) -> int:
        one = self.c(1.0)
        u = self.op("fadd", x, one)
        lost = self.op("fsub", x, self.op("fsub", u, one))
        result = self.op("fadd", self._logarithm(u), self.op("fdiv", lost, u))
        return self.mark("log1p", result, x)

    def _pow(self, x: int, y: int) -> int:
        value = self.new.constant(y)
        if value is not None and 2 * value == int(2 * value) and abs(value) <= LARGEST_POWER:
            power = self._integer_power(x, int(abs(value)))
            if value != int(value):
                root = self.op("sqrt", x)
                power = root if abs(value) < 1 else self.op("mul", power, root)
            return power if value >= 0 else self.op("div", self.c(1.0), power)
        return self._exp(self.op("mul", y, self._log(x)))

    def _integer_power(self, x: int, n: int) -> int:
        if n == 0:
            return self.c(1.0)
        if n == 1:
            return x
        half = self._integer_power(x, n // 2)
        square = self.op("mul", half, half)
        return self.op("mul", square, x) if n % 2 else square

    # ------------------------------------------------------------------ hyperbolic functions
    def _sinh(self, x: int) -> int:
        a = self.op("abs", x)
        small = self.op("fmul", self._near_expm1(a), self.c(0.5))
        large = self.op("fsub", self._half_exponential(a), self.c(0.5))
        v = self.op("sel", self.op("flt", a, self.c(0.5)), small, large)
        v = self.mark("half_expm1", v, a)
        twice = self.op("mul", self.c(2.0), v)  # may be infinite: the quotient is 0 then
        rest = self.op("div", v, self.op("add", twice, self.c(1.0)))
        return self.op("copysign", self.op("add", v, rest), x)

    def _cosh(self, x: int) -> int:
        a = self.op("abs", x)
        half = self.mark("half_exp", self._half_exponential(a), a)
        return self.op("add", half, self.op("div", self.c(0.25), half))

    def _tanh(self, x: int) -> int:
        """2 n d / (n^2 + d^2) with n/d = tanh(x/2): an error of n/d matters less, the nearer the
        result is to 1, and no result is above 1.
        """
        near = self.op("fsat", x, self.c(-TANH_FAR), self.c(TANH_FAR))
        square = self.op("fmul", near, near)
        half = self.op("fmul", near, self.c(0.5))
        n = self.fma(self.op("fmul", near, square), self.horner(TANH_ABOVE, square), half)
        d = self.horner(TANH_BELOW, square)
        above = self.op("fmul", self.op("fadd", n, n), d)
        below = self.fma(n, n, self.op("fmul", d, d))
        return self.mark("tanh", self.op("fdiv", above, below), x)

    def _asinh(self, x: int) -> int:
        """a / (1 + sqrt(1 + a^2)) is 1 for large a: the square need not grow further."""
        a = self.op("abs", x)
        some = self.op("min", a, self.c(LARGE))
        one = self.c(1.0)
        root = self.op("sqrt", self.op("add", self.op("mul", some, some), one))
        ratio = self.op("div", some, self.op("add", root, one))
        grown = self.op("add", a, self.op("mul", a, ratio))
        return self.op("copysign", self._log1p(grown), x)

    def _acosh(self, x: int) -> int:
        """Two roots: the square of a large number is infinite."""
        t = self.op("sub", x, self.c(1.0))
        root = self.op("sqrt", self.op("add", t, self.c(2.0)))
        return self._log1p(self.op("add", t, self.op("mul", self.op("sqrt", t), root)))

    def _atanh(self, x: int) -> int:
        """Of the size: near x = -1 the logarithm's argument would lose its digits."""
        a = self.op("abs", x)
        ratio = self.op("div", self.op("add", a, a), self.op("sub", self.c(1.0), a))
        return self.op("copysign", self.op("mul", self.c(0.5), self._log1p(ratio)), x)

    # ------------------------------------------------------------------ angles
    def _tan(self, x: int) -> int:
        return self.op("div", self.op("sin", x), self.op("cos", x))

    def _arctangent(self, a: int) -> int:
        """Of a number a >= 0."""
        one = self.c(1.0)
        far = self.op("flt", self.c(ATAN_FAR), a)
        middle = self.op("flt", self.c(ATAN_MIDDLE), a)
        above = self.op("sel", far, self.c(-1.0), self.op("fsub", a, one))
        below = self.op("sel", far, a, self.op("fadd", a, one))
        t = self.op("sel", middle, self.op("fdiv", above, below), a)
        base = self.op("sel", middle, self.op("sel", far, self.c(PI / 2), self.c(PI / 4)),
                       self.c(0.0))  # fmt: skip
        z = self.op("fmul", t, t)
        p = self.fma(self.op("fmul", t, z), self.horner(ATAN, z), t)
        return self.op("fadd", base, p)

    def _atan(self, x: int) -> int:
        p = self._arctangent(self.op("fabs", x))
        return self.mark("atan", self.op("selge", x, p, self.op("fneg", p)), x)

    def _atan2(self, y: int, x: int) -> int:
        """Quotient of the smaller by the larger; both zero give 0."""
        a, b = self.op("abs", y), self.op("abs", x)
        large = self.op("max", self.op("max", a, b), self.c(SMALLEST))
        p = self._atan(self.op("div", self.op("min", a, b), large))
        p = self.op("select", self.op("lt", b, a), self.op("sub", self.c(PI / 2), p), p)
        left = self.op("lt", x, self.c(0.0))
        p = self.op("select", left, self.op("sub", self.c(PI), p), p)
        return self.op("copysign", p, y)

    def _half_arcsine(self, x: int) -> tuple[int, int]:
        """Size of x above 1/2 (a test), and arcsin of |x|, or of sqrt((1 - |x|)/2) there."""
        a = self.op("fabs", x)
        outer = self.op("flt", self.c(0.5), a)
        half = self.c(0.5)
        rest = self.op("fnmsub", a, half, half)
        z = self.op("sel", outer, rest, self.op("fmul", a, a))
        y = self.op("sel", outer, self.op("fsqrt", rest), a)
        return outer, self.fma(self.op("fmul", y, z), self.horner(ASIN, z), y)

    def _asin(self, x: int) -> int:
        outer, p = self._half_arcsine(x)
        far = self.op("fnmsub", p, self.c(2.0), self.c(PI / 2))
        size = self.op("sel", outer, far, p)
        return self.mark("asin", self.op("selge", x, size, self.op("fneg", size)), x)

    def _acos(self, x: int) -> int:
        outer, p = self._half_arcsine(x)
        twice = self.op("fadd", p, p)
        far = self.op("selge", x, twice, self.op("fsub", self.c(PI), twice))
        signed = self.op("selge", x, p, self.op("fneg", p))
        # pi/2 in two parts: near x = 1/2 one part alone costs half an ulp.
        near = self.op("fsub", self.c(PI / 2), self.op("fadd", signed, self.c(4.37113883e-8)))
        return self.mark("acos", self.op("sel", outer, far, near), x)

    def _erf(self, x: int) -> int:
        a = self.op("fabs", x)
        z = self.op("fmul", a, a)
        near = self.op("fmul", a, self.horner(ERF, z))
        b = self.op("fsub", self.op("fmin", a, self.c(4.0)), self.c(2.5))
        far = self.op("fsub", self.c(1.0), self._exponential(self.op("fneg", self.horner(ERFC, b))))
        size = self.op("sel", self.op("fle", a, self.c(1.0)), near, far)
        return self.mark("erf", self.op("selge", x, size, self.op("fneg", size)), x)

    # ------------------------------------------------------------------ integers and lengths
    def _truncated(self, x: int) -> int:
        return self.op("i2f", self.op("f2it", x))

    def _floor(self, x: int) -> int:
        """|x| < 2^31."""
        whole = self._truncated(x)
        return self.op("fsub", whole, self.op("flt", x, whole))

    def _ceil(self, x: int) -> int:
        whole = self._truncated(x)
        return self.op("fadd", whole, self.op("flt", whole, x))

    def _fmod(self, x: int, y: int) -> int:
        """|x / y| < 2^22; exact: the sign of the rest shows a quotient that is one too large."""
        size, step = self.op("fabs", x), self.op("fabs", y)
        quotient = self._truncated(self.op("fdiv", size, step))
        rest = self.op("fnmsub", quotient, step, size)
        rest = self.op("selge", rest, rest, self.op("fadd", rest, step))
        return self.op("copysign", rest, x)

    def _remainder(self, x: int, y: int) -> int:
        """|x / y| < 2^22; exact: a rest larger than |y|/2 shows a quotient that rounding moved to
        a half. A true half is exact, and goes to the even quotient.
        """
        quotient = self.op("i2f", self.op("f2i", self.op("fdiv", x, y)))
        rest = self.op("fnmsub", quotient, y, x)
        step = self.op("fabs", y)
        over = self.op("fmsub", self.op("fabs", rest), self.c(2.0), step)
        towards = self.op("selge", rest, step, self.op("fneg", step))
        return self.op("selgt", over, self.op("fsub", rest, towards), rest)

    def _hypot(self, x: int, y: int) -> int:
        squares = self.op("add", self.op("mul", x, x), self.op("mul", y, y))
        return self.op("sqrt", squares)
