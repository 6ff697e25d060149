/* SPDX-License-Identifier: Apache-2.0 */
/* Start-up of programs in tightly coupled memory. Linker script: link/tcm.ld. */

        .section .reset, "ax"
        .globl  _start
_start:
        movia   sp, __stack_top
        movia   gp, _gp
        movia   r2, _system_start
        jmp     r2

/* Zero-initialised data, constructors, then main; its result is the status of the program. Initialised
 * data and constants are part of the image of the data memory. */
        .text
_system_start:
        movia   r2, __bss_start
        movia   r3, __bss_end
        br      2f
1:      stw     zero, 0(r2)
        addi    r2, r2, 4
2:      bltu    r2, r3, 1b
        movia   r4, run_destructors
        call    atexit                  /* first, so that they run last */
        movia   r16, __init_array_start
        movia   r17, __init_array_end
        br      4f
3:      ldw     r2, 0(r16)
        addi    r16, r16, 4
        callr   r2
4:      bltu    r16, r17, 3b
        mov     r4, zero
        mov     r5, zero
        call    main
        mov     r4, r2
        call    exit                    /* flushes what printf still holds */

/* Destructors, last one first. */
run_destructors:
        addi    sp, sp, -12
        stw     ra, 8(sp)
        stw     r17, 4(sp)
        stw     r16, 0(sp)
        movia   r16, __fini_array_end
        movia   r17, __fini_array_start
        br      2f
1:      addi    r16, r16, -4
        ldw     r2, 0(r16)
        callr   r2
2:      bltu    r17, r16, 1b
        ldw     r16, 0(sp)
        ldw     r17, 4(sp)
        ldw     ra, 8(sp)
        addi    sp, sp, 12
        ret
