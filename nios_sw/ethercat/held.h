/* SPDX-License-Identifier: Apache-2.0 */
/* HELD keeps a pointer in a register. Without it the compiler builds the constant address again for each member that
 * the pointer leads to. It costs no instruction. */
#ifndef ETHERCAT_HELD_H
#define ETHERCAT_HELD_H

#define HELD(pointer) __asm__("" : "+r"(pointer))

#endif
