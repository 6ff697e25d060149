/* SPDX-License-Identifier: Apache-2.0 */
/* Exception entry of programs in tightly coupled memory. A program with an entry of its own, such as a
 * kernel that switches stacks, links without this file (nios-gcc --own-exceptions). */

/* Exception vector, 32 bytes above reset. Saves what a C function may change. */
        .section .exception, "ax"
exception_entry:
        .set    noat
        addi    sp, sp, -76
        stw     ra, 0(sp)
        stw     r1, 4(sp)
        stw     r2, 8(sp)
        stw     r3, 12(sp)
        stw     r4, 16(sp)
        stw     r5, 20(sp)
        stw     r6, 24(sp)
        stw     r7, 28(sp)
        stw     r8, 32(sp)
        stw     r9, 36(sp)
        stw     r10, 40(sp)
        stw     r11, 44(sp)
        stw     r12, 48(sp)
        stw     r13, 52(sp)
        stw     r14, 56(sp)
        stw     r15, 60(sp)
        rdctl   et, estatus
        stw     et, 64(sp)
        andi    et, et, 1               /* PIE: where it was off nothing interrupts, */
        sub     et, zero, et            /* whatever is pending: this is an exception */
        rdctl   r4, ipending
        and     r4, r4, et
        mov     r5, ea
        beq     r4, zero, 1f
        addi    r5, r5, -4              /* an interrupted instruction is run again */
1:      stw     r5, 68(sp)
        call    exception_handler
        ldw     ea, 68(sp)
        ldw     et, 64(sp)
        wrctl   estatus, et
        ldw     r15, 60(sp)
        ldw     r14, 56(sp)
        ldw     r13, 52(sp)
        ldw     r12, 48(sp)
        ldw     r11, 44(sp)
        ldw     r10, 40(sp)
        ldw     r9, 36(sp)
        ldw     r8, 32(sp)
        ldw     r7, 28(sp)
        ldw     r6, 24(sp)
        ldw     r5, 20(sp)
        ldw     r4, 16(sp)
        ldw     r3, 12(sp)
        ldw     r2, 8(sp)
        ldw     r1, 4(sp)
        ldw     ra, 0(sp)
        addi    sp, sp, 76
        eret
