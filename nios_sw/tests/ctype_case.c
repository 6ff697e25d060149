/* SPDX-License-Identifier: Apache-2.0 */
/* Character classes and case of the C locale. */
#include <ctype.h>

#include "test.h"

void test(void) {
  for (int c = 0; c < 128; ++c) {
    uint32_t bits = 0;
    bits |= (uint32_t)(isalpha(c) != 0) << 0 | (uint32_t)(isdigit(c) != 0) << 1;
    bits |= (uint32_t)(isspace(c) != 0) << 2 | (uint32_t)(ispunct(c) != 0) << 3;
    bits |= (uint32_t)(isxdigit(c) != 0) << 4 | (uint32_t)(isupper(c) != 0) << 5;
    bits |= (uint32_t)(iscntrl(c) != 0) << 6 | (uint32_t)(isprint(c) != 0) << 7;
    add(bits);
    add((uint32_t)toupper(c));
    add((uint32_t)tolower(c));
  }
}
