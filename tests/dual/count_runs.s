; SPDX-License-Identifier: Apache-2.0
; Set-points that say when they were made: word i of run n is 32 n + i. `spin` makes a run long.
.program  "words of a known run"
.input    poison                                   ; NaN: word 0 is NaN
.input    spin : int                               ; >= 1
.const    one = 1 : int
.state    run = -32.0
.output   w0, safe = -1.0
.output   w1, safe = -1.0
.output   w2, safe = -1.0
.output   w3, safe = -1.0
.output   w4, safe = -1.0
.output   w5, safe = -1.0
.output   w6, safe = -1.0
.output   w7, safe = -1.0
.output   w8, safe = -1.0
.output   w9, safe = -1.0
.output   w10, safe = -1.0
.output   w11, safe = -1.0
.output   w12, safe = -1.0
.output   w13, safe = -1.0
.output   w14, safe = -1.0
        mov     rest, spin
more:   isub    rest, rest, one
        i2f     left, rest
        bnz     left, more
        fadd    run, run, 32.0
        fadd    n0, run, poison
.macro put i
        fadd    n\i, run, (\i)
        mov     w\i, n\i
.endm
        mov     w0, n0
        put     1
        put     2
        put     3
        put     4
        put     5
        put     6
        put     7
        put     8
        put     9
        put     10
        put     11
        put     12
        put     13
        put     14
        halt
