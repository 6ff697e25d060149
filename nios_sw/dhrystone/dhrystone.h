/* SPDX-License-Identifier: Apache-2.0 */
/* Dhrystone 2.1 (R. Weicker, 1988) in ISO C: types and what both source files share. The benchmark's
 * rules: two files, no inlining between its procedures, no statement changed in its effect. The local
 * strings start at a word, as its constants do: the C library then works on words. */
#ifndef DHRYSTONE_H
#define DHRYSTONE_H

enum identification { IDENT_1, IDENT_2, IDENT_3, IDENT_4, IDENT_5 };

#define STRING_ALIGNMENT 4
typedef char text_30[31];
typedef int array_1[50];
typedef int array_2[50][50];

struct record {
  struct record *next;
  enum identification discriminant;
  union {
    struct {
      enum identification component;
      int number;
      char text[31];
    } variant_1;
    struct {
      enum identification component;
      char text[31];
    } variant_2;
    struct {
      char first, second;
    } variant_3;
  } variant;
};

extern struct record *global_record, *next_global_record;
extern int int_global, bool_global;
extern char char_1_global, char_2_global;
extern array_1 array_1_global;
extern array_2 array_2_global;

void procedure_1(struct record *value);
void procedure_2(int *reference);
void procedure_3(struct record **reference);
void procedure_4(void);
void procedure_5(void);
void procedure_6(enum identification value, enum identification *reference);
void procedure_7(int first, int second, int *reference);
void procedure_8(array_1 first, array_2 second, int value_1, int value_2);
enum identification function_1(char first, char second);
int function_2(text_30 first, text_30 second);
int function_3(enum identification value);

#endif
