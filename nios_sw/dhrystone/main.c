/* SPDX-License-Identifier: Apache-2.0 */
/* Dhrystone 2.1, main loop and procedures 1 to 5. Prints runs, cycles, alignment and options, a
 * line each, and returns the number of wrong final values. */
#include <string.h>

#include "dhrystone.h"
#include "io.h"

#ifndef RUNS
#define RUNS 200
#endif

struct record *global_record, *next_global_record;
int int_global, bool_global;
char char_1_global, char_2_global;
array_1 array_1_global;
array_2 array_2_global;

static struct record records[2];

void procedure_1(struct record *value) {
  struct record *next = value->next;
  *value->next = *global_record;
  value->variant.variant_1.number = 5;
  next->variant.variant_1.number = value->variant.variant_1.number;
  next->next = value->next;
  procedure_3(&next->next);
  if (next->discriminant == IDENT_1) {
    next->variant.variant_1.number = 6;
    procedure_6(value->variant.variant_1.component, &next->variant.variant_1.component);
    next->next = global_record->next;
    procedure_7(next->variant.variant_1.number, 10, &next->variant.variant_1.number);
  } else {
    *value = *value->next;
  }
}

void procedure_2(int *reference) {
  int value = *reference + 10;
  enum identification identification = IDENT_2;
  do {
    if (char_1_global == 'A') {
      value -= 1;
      *reference = value - int_global;
      identification = IDENT_1;
    }
  } while (identification != IDENT_1);
}

void procedure_3(struct record **reference) {
  if (global_record != NULL) *reference = global_record->next;
  procedure_7(10, int_global, &global_record->variant.variant_1.number);
}

void procedure_4(void) {
  int is_a = char_1_global == 'A';
  bool_global = is_a | bool_global;
  char_2_global = 'B';
}

void procedure_5(void) {
  char_1_global = 'A';
  bool_global = 0;
}

/* Counts a final value that is not what the benchmark states. */
static int wrong;
static void expect(int is_right) { wrong += !is_right; }

int main(void) {
  int value_1 = 0, value_2 = 0, value_3 = 0;
  enum identification identification = IDENT_1;
  _Alignas(STRING_ALIGNMENT) text_30 text_1;
  _Alignas(STRING_ALIGNMENT) text_30 text_2;

  next_global_record = &records[0];
  global_record = &records[1];
  global_record->next = next_global_record;
  global_record->discriminant = IDENT_1;
  global_record->variant.variant_1.component = IDENT_3;
  global_record->variant.variant_1.number = 40;
  strcpy(global_record->variant.variant_1.text, "DHRYSTONE PROGRAM, SOME STRING");
  strcpy(text_1, "DHRYSTONE PROGRAM, 1'ST STRING");
  array_2_global[8][7] = 10;

  uint32_t begin = cycle_now();
  for (int run = 1; run <= RUNS; ++run) {
    procedure_5();
    procedure_4();
    value_1 = 2;
    value_2 = 3;
    strcpy(text_2, "DHRYSTONE PROGRAM, 2'ND STRING");
    identification = IDENT_2;
    bool_global = !function_2(text_1, text_2);
    while (value_1 < value_2) {
      value_3 = 5 * value_1 - value_2;
      procedure_7(value_1, value_2, &value_3);
      value_1 += 1;
    }
    procedure_8(array_1_global, array_2_global, value_1, value_3);
    procedure_1(global_record);
    for (char index = 'A'; index <= char_2_global; ++index) {
      if (identification == function_1(index, 'C')) {
        procedure_6(IDENT_1, &identification);
        strcpy(text_2, "DHRYSTONE PROGRAM, 3'RD STRING");
        value_2 = run;
        int_global = run;
      }
    }
    value_2 = value_2 * value_1;
    value_1 = value_2 / value_3;
    value_2 = 7 * (value_2 - value_3) - value_1;
    procedure_2(&value_1);
  }
  uint32_t cycles = cycle_now() - begin;

  expect(int_global == 5);
  expect(bool_global == 1);
  expect(char_1_global == 'A');
  expect(char_2_global == 'B');
  expect(array_1_global[8] == 7);
  expect(array_2_global[8][7] == RUNS + 10);
  expect(global_record->discriminant == IDENT_1);
  expect(global_record->variant.variant_1.component == IDENT_3);
  expect(global_record->variant.variant_1.number == 17);
  expect(!strcmp(global_record->variant.variant_1.text, "DHRYSTONE PROGRAM, SOME STRING"));
  expect(next_global_record->variant.variant_1.component == IDENT_2);
  expect(next_global_record->variant.variant_1.number == 18);
  expect(value_1 == 5);
  expect(value_2 == 13);
  expect(value_3 == 7);
  expect(identification == IDENT_2);
  expect(!strcmp(text_1, "DHRYSTONE PROGRAM, 1'ST STRING"));
  expect(!strcmp(text_2, "DHRYSTONE PROGRAM, 2'ND STRING"));

  console_text("runs ");
  console_decimal(RUNS);
  console_text("\ncycles ");
  console_decimal(cycles);
  console_text("\nstring_alignment ");
  console_decimal(STRING_ALIGNMENT);
  console_text("\noptions " OPTIONS "\n");
  return wrong;
}
