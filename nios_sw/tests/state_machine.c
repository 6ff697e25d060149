/* SPDX-License-Identifier: Apache-2.0 */
/* A lexer that turns G-code into fixed-point numbers. */
#include "test.h"

enum state { START, LETTER, WHOLE, FRACTION, COMMENT };

void test(void) {
  static const char code[] = "G1 X12.5 Y-3.25 F2000 (feed)\nG2 X0 Y.75 I-1.125 J2\n(end) M30\n";
  enum state state = START;
  int32_t value = 0, sign = 1, scale = 1;
  for (const char *at = code; *at; ++at) {
    char c = *at;
    if (state == COMMENT) {
      if (c == ')') state = START;
      continue;
    }
    if (c >= 'A' && c <= 'Z') {
      add((uint32_t)c);
      state = LETTER;
      value = 0, sign = 1, scale = 1;
    } else if (c == '-' && state == LETTER) {
      sign = -1;
    } else if (c >= '0' && c <= '9') {
      value = value * 10 + (c - '0');
      if (state == FRACTION) scale *= 10;
      if (state == LETTER) state = WHOLE;
    } else if (c == '.') {
      state = FRACTION;
    } else {
      if (state != START) {
        add((uint32_t)(sign * value));
        add((uint32_t)scale);
      }
      state = c == '(' ? COMMENT : START;
    }
  }
}
