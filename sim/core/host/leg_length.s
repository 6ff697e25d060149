; SPDX-License-Identifier: Apache-2.0
; Program of the driver demonstration (demo.c): length of a leg from its base at (0, R, 0) to
; (x, y, z), its reciprocal, the sum of squared lengths over the runs [m^2], and the way a counter
; has gone.
.program  "leg length"
.input    x, y, z                          ; [m]
.input    counter : int
.param    R = 0.5                          ; [m]
.state    sum = 0.0
.state    before : int = 0
.output   length, safe = 0.0
.output   inverse, safe = 0.25
.output   total, safe = -1.0
.output   way, safe = 0.0
.export   square

        fsub    d, y, R
        fmul    t, x, x
        fmadd   t2, d, d, t
        fmadd   square, z, z, t2
        fsqrt   l, square
        mov     length, l
        fdiv    inverse, 1.0, l
        fadd    sum, sum, square
        mov     total, sum
        isub    step, counter, before
        mov     before, counter
        i2f     way, step
        halt
