/* SPDX-License-Identifier: Apache-2.0 */
/* String functions of the C library: comparison, search, tokens. */
#include <string.h>

#include "test.h"

void test(void) {
  static const char *words[] = {"axis", "axes", "tilt", "rotation", "", "leg", "legs", "Leg", "z"};
  char text[80];
  for (unsigned i = 0; i < 9; ++i) {
    for (unsigned j = 0; j < 9; ++j) {
      int c = strcmp(words[i], words[j]), n = strncmp(words[i], words[j], 3);
      add((uint32_t)((c > 0) - (c < 0)));
      add((uint32_t)((n > 0) - (n < 0)));
      add((uint32_t)strspn(words[i], words[j]));
      add((uint32_t)strcspn(words[i], words[j]));
    }
    strcpy(text, "the tilt axis, the legs and the rotation axis");
    char *at = strstr(text, words[i]);
    add(at ? (uint32_t)(at - text) : 99u);
    at = strrchr(text, words[i][0]);
    add(at ? (uint32_t)(at - text) : 99u);
  }
  uint32_t count = 0;
  for (char *word = strtok(text, " ,"); word; word = strtok(NULL, " ,")) {
    add_text(word);
    ++count;
  }
  add(count);
  strncpy(text, "short", 12);
  strncat(text, " and longer", OPAQUE((size_t)5));
  add_text(text);
}
