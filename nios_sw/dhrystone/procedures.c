/* SPDX-License-Identifier: Apache-2.0 */
/* Dhrystone 2.1, procedures 6 to 8 and functions. */
#include <string.h>

#include "dhrystone.h"

void procedure_6(enum identification value, enum identification *reference) {
  *reference = value;
  if (!function_3(value)) *reference = IDENT_4;
  switch (value) {
    case IDENT_1:
      *reference = IDENT_1;
      break;
    case IDENT_2:
      *reference = int_global > 100 ? IDENT_1 : IDENT_4;
      break;
    case IDENT_3:
      *reference = IDENT_2;
      break;
    case IDENT_4:
      break;
    case IDENT_5:
      *reference = IDENT_3;
      break;
  }
}

void procedure_7(int first, int second, int *reference) {
  int value = first + 2;
  *reference = second + value;
}

void procedure_8(array_1 first, array_2 second, int value_1, int value_2) {
  int index = value_1 + 5;
  first[index] = value_2;
  first[index + 1] = first[index];
  first[index + 30] = index;
  for (int i = index; i <= index + 1; ++i) second[index][i] = index;
  second[index][index - 1] += 1;
  second[index + 20][index] = first[index];
  int_global = 5;
}

enum identification function_1(char first, char second) {
  char copy = first;
  if (copy != second) return IDENT_1;
  char_1_global = copy;
  return IDENT_2;
}

int function_2(text_30 first, text_30 second) {
  int index = 2;
  char letter = 'A';
  while (index <= 2) {
    if (function_1(first[index], second[index + 1]) == IDENT_1) {
      letter = 'A';
      index += 1;
    }
  }
  if (letter >= 'W' && letter < 'Z') index = 7;
  if (letter == 'R') return 1;
  if (strcmp(first, second) > 0) {
    index += 7;
    int_global = index;
    return 1;
  }
  return 0;
}

int function_3(enum identification value) {
  enum identification copy = value;
  return copy == IDENT_3;
}
