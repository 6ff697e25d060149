/* SPDX-License-Identifier: Apache-2.0 */
/* HELD: the compiler has the pointer in a register, and does not make it anew from a constant address for each member
 * that it leads to. Costs no instruction. */
#ifndef ETHERCAT_HELD_H
#define ETHERCAT_HELD_H

#define HELD(pointer) __asm__("" : "+r"(pointer))

#endif
