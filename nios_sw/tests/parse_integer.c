/* SPDX-License-Identifier: Apache-2.0 */
/* strtol, strtoul, strtoull, atoi with bases, signs and overflow. */
#include <errno.h>
#include <stdlib.h>

#include "test.h"

void test(void) {
  static const char *texts[] = {"0",   "-1",  "  42x", "0x1F", "077", "99999999999", "-99999999999",
                                "zz9", "+-3", "",      "1e5"};
  static const int bases[] = {0, 8, 10, 16, 36};
  for (unsigned i = 0; i < 11; ++i) {
    for (unsigned j = 0; j < 5; ++j) {
      char *end;
      errno = 0;
      long long value = strtoll(texts[i], &end, bases[j]);
      add64((uint64_t)value);
      add((uint32_t)(end - texts[i]));
      add64(strtoull(texts[i], &end, bases[j]));
      add((uint32_t)(end - texts[i]));
    }
    if (i != 5 && i != 6) add((uint32_t)atoi(texts[i]));
  }
}
