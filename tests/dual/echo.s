; SPDX-License-Identifier: Apache-2.0
; Tracking core that puts its first five words out; word 5 makes a run long.
.program  "echo"
.input    e0, e1, e2, e3, e4
.input    spin : int
.const    one = 1 : int
.output   r0, safe = 1000.0
.output   r1, safe = 1001.0
.output   r2, safe = 1002.0
.output   r3, safe = 1003.0
.output   r4, safe = 1004.0
        mov     rest, spin
more:   isub    rest, rest, one
        i2f     left, rest
        bnz     left, more
        mov     r0, e0
        mov     r1, e1
        mov     r2, e2
        mov     r3, e3
        mov     r4, e4
        halt
