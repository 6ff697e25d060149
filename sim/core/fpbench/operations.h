// SPDX-License-Identifier: Apache-2.0
// The operations the bench knows: control word of fp_lane.sv, operand count, reference.
#pragma once
#include <string>

#include "gen/compare_codes.h"
#include "reference.h"

namespace operations {

using reference::Value;
using reference::u32;
using reference::u8;

// Shape of random operands and of constructed hard cases, see cases.h.
enum class Family { Add, Mul, Div, Sqrt, Fma, Compare, Integer, ToInteger, Angle };

struct Operation {
  const char *unit;
  const char *name;
  unsigned operands;  // a; a, b; a, b, c
  unsigned control;   // see fp_lane.sv
  Family family;
  Value (*reference)(u32, u32, u32);  // null: checked by its error, see angles.h
};

constexpr u32 S = reference::SIGN;
#define REF(expression) \
  [](u32 a, u32 b, u32 c) -> Value { (void)a, (void)b, (void)c; return expression; }
// An operation of fp_cmp: its name there, shape, reference; the rest is its record in asip_asm/isa.toml.
#define COMPARE(code, family, expression) \
  {"fp_cmp", compare_codes::code.name, compare_codes::code.operands, compare_codes::code.number, \
   Family::family, REF(expression)}
// A code without an operation copies a.
#define COMPARE_SPARE(name, number) {"fp_cmp", name, 1, number, Family::Compare, REF((Value{a, 0}))},

namespace r = reference;
inline const Operation TABLE[] = {
    {"fp_add", "add", 2, 0, Family::Add, REF(r::add(a, b))},
    {"fp_add", "sub", 2, 1, Family::Add, REF(r::host([](float x, float y) { return x - y; }, r::number(a), r::number(b)))},
    {"fp_mul", "mul", 2, 0, Family::Mul, REF(r::mul(a, b))},
    {"fp_fma", "mul_add", 3, 0, Family::Fma, REF(r::mul_add(a, b, c))},
    {"fp_fma", "mul_sub", 3, 8, Family::Fma, REF(r::mul_add(a, b, c ^ S))},
    {"fp_fma", "neg_mul_add", 3, 4, Family::Fma, REF(r::mul_add(a ^ S, b, c))},
    {"fp_fma", "neg_mul_sub", 3, 12, Family::Fma, REF(r::mul_add(a ^ S, b, c ^ S))},
    {"fp_fma", "fma_mul", 2, 1, Family::Mul, REF(r::mul(a, b))},
    {"fp_fma", "fma_neg_mul", 2, 5, Family::Mul, REF(r::mul(a ^ S, b))},
    {"fp_fma", "fma_add", 2, 2, Family::Add, REF(r::add(a, b))},
    {"fp_fma", "fma_sub", 2, 10, Family::Add, REF(r::add(a, b ^ S))},
    {"fp_divsqrt", "div", 2, 0, Family::Div, REF(r::div(a, b))},
    {"fp_divsqrt", "sqrt", 1, 1, Family::Sqrt, REF(r::sqrt(a))},
    COMPARE(EQ, Compare, r::host_compare([](float x, float y) { return x == y; }, a, b)),
    COMPARE(LT, Compare, r::host_compare([](float x, float y) { return x < y; }, a, b)),
    COMPARE(LE, Compare, r::host_compare([](float x, float y) { return x <= y; }, a, b)),
    COMPARE(MIN, Compare, r::extremum(a, b, true)),
    COMPARE(MAX, Compare, r::extremum(a, b, false)),
    COMPARE(ABS, Compare, (Value{a & ~S, 0})),
    COMPARE(NEG, Compare, (Value{a ^ S, 0})),
    COMPARE(MOV, Compare, (Value{a, 0})),
    COMPARE(SGN, Compare, r::signum(a)),
    COMPARE(SAT, Compare, r::saturate(a, b, c)),
    COMPARE(SEL, Compare, (Value{!r::is_nan(a) && r::wide(a) != 0 ? b : c, 0})),
    COMPARE(SELGE, Compare, (Value{!r::is_nan(a) && r::wide(a) >= 0 ? b : c, 0})),
    COMPARE(SELGT, Compare, (Value{!r::is_nan(a) && r::wide(a) > 0 ? b : c, 0})),
    COMPARE(IADD, Integer, (Value{a + b, 0})),
    COMPARE(ISUB, Integer, (Value{a - b, 0})),
    COMPARE_SPARES(COMPARE_SPARE)
    {"fp_i2f", "i2f", 1, 0, Family::Integer, REF(r::signed_to_float(a))},
    {"fp_i2f", "u2f", 1, 1, Family::Integer, REF(r::unsigned_to_float(a))},
    {"fp_f2i", "f2i", 1, 1, Family::ToInteger, REF(r::to_signed(a, true))},
    {"fp_f2i", "f2i_nearest", 1, 0, Family::ToInteger, REF(r::to_signed(a, false))},
    {"fp_sincos", "sin", 1, 0, Family::Angle, nullptr},
    {"fp_sincos", "cos", 1, 1, Family::Angle, nullptr},
};
#undef COMPARE_SPARE
#undef COMPARE
#undef REF

inline const Operation *find(const char *name) {
  for (const Operation &o : TABLE)
    if (std::string(name) == o.name) return &o;
  return nullptr;
}

}  // namespace operations
