/* SPDX-License-Identifier: Apache-2.0 */
/* program_exit(status) for QEMU and the lockstep: `break 1` asks the debugger to end the program,
 * operation r4 = 0, status r5. */
        .text
        .globl  program_exit
program_exit:
        mov     r5, r4
        mov     r4, zero
        break   1
        br      .
