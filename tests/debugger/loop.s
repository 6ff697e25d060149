; Sum of a table by a loop, with a macro.
.program  "table sum"
.input    scale
.output   sum, safe = 0.0
.const    last = 3 : int
.data     table = 1.0, 2.0, 4.0, 8.0
.reg      i, total

.macro add_entry value, factor
        fmul    scaled\@, \value, \factor    ; (1)
        fadd    total, total, scaled\@       ; (2)
.endm

        mov     i, last
        fadd    total, zero, zero
again:
        ld      entry, table[i]
        add_entry entry, scale
        isub    i, i, 1
        iadd    k, i, 1
        bnz     k, again
        mov     sum, total
        halt
