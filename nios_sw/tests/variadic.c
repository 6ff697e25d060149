/* SPDX-License-Identifier: Apache-2.0 */
/* Functions with variable arguments of mixed types. */
#include <stdarg.h>
#include <string.h>

#include "test.h"

static double sum(const char *types, ...) {
  va_list list;
  double total = 0;
  va_start(list, types);
  for (; *types; ++types) {
    if (*types == 'i') total += va_arg(list, int);
    if (*types == 'l') total += (double)va_arg(list, long long);
    if (*types == 'd') total += va_arg(list, double);
    if (*types == 's') total += (double)strlen(va_arg(list, const char *));
  }
  va_end(list);
  return total;
}

void test(void) {
  add_double(sum("iidli", 1, -2, 3.25, 1LL << 40, 7));
  add_double(sum("dsdsl", 0.1, "four", -1e9, "", -5LL));
  add_double(sum("iiiiiiiiii", 1, 2, 3, 4, 5, 6, 7, 8, 9, 10));
}
