/* SPDX-License-Identifier: Apache-2.0 */
/* Exception entry of a kernel: saves the whole context of a task on its stack, asks the kernel in C which
 * task goes on, and restores that one's. It takes the place of lib/exception_entry.S.
 *
 * A context is r1..r23, fp, ra, ea, estatus and, on FPGA2, the bounds of the saturation instruction in
 * its internal registers c0..c31: state that an instruction reads and that no compiler saves. et and bt
 * belong to exceptions and to the debugger, gp is the same for all, sp is what the kernel keeps.
 * Its order is that of struct context in tasks.h. */
#define REGISTERS 27
#if defined NO_BOUNDS
#define FRAME (4 * REGISTERS)
#else
#define FRAME (4 * (REGISTERS + 64))
#endif

        .set    noat
        .section .exception, "ax"
        .globl  exception_entry
exception_entry:
        br      save                    /* the reset vector's page has room for little more */

        .text
save:
        addi    sp, sp, -FRAME
        .irp    n, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23
        stw     r\n, 4*(\n-1)(sp)
        .endr
        stw     fp, 92(sp)
        stw     ra, 96(sp)
        rdctl   et, estatus
        stw     et, 104(sp)
        andi    et, et, 1               /* interrupts count only where they were enabled */
        sub     et, zero, et
        rdctl   r4, ipending
        and     r4, r4, et
        beq     r4, zero, 1f
        addi    ea, ea, -4              /* an interrupted instruction is run again */
1:      stw     ea, 100(sp)
#if !defined NO_BOUNDS && !defined LOSE_BOUNDS
        .irp    n, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31
        custom  244, r2, c\n, r0        /* lower bound */
        custom  244, r3, c\n, c0        /* upper bound */
        stw     r2, 4*(REGISTERS+2*\n)(sp)
        stw     r3, 4*(REGISTERS+2*\n+1)(sp)
        .endr
#endif
        mov     r5, sp
        call    kernel_switch           /* (pending interrupts, context): the next context */
        mov     sp, r2

        .globl  kernel_restore
kernel_restore:                         /* of the context at sp */
#if !defined NO_BOUNDS && !defined LOSE_BOUNDS
        .irp    n, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31
        ldw     r2, 4*(REGISTERS+2*\n)(sp)
        ldw     r3, 4*(REGISTERS+2*\n+1)(sp)
        custom  244, c\n, r2, r3
        .endr
#endif
        ldw     et, 104(sp)
        wrctl   estatus, et
        ldw     ea, 100(sp)
        ldw     ra, 96(sp)
        ldw     fp, 92(sp)
        .irp    n, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23
        ldw     r\n, 4*(\n-1)(sp)
        .endr
        addi    sp, sp, FRAME
        eret

        .globl  kernel_go               /* (context): the first task; does not return */
kernel_go:
        mov     sp, r4
        br      kernel_restore
