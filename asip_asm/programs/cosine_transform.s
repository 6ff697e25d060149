; Product of a constant 16x16 matrix and a vector: the cosine transform (DCT-II) of 16 inputs,
; y_i = sum over j of cos(pi*i*(2*j + 1)/32) * x_j.
; The matrix lies in the streams, in the order of use: column after column, rows 0 to 7 in the stream
; of pipe A, rows 8 to 15 in that of pipe B. A column takes 8 cycles, one more than a sum needs to
; be ready for the next column, so no multiply-add waits.
.program "cosine transform"
.config stream

.macro signals i
.input x\i
.output y\i, safe = 0
.endm
.macro entries i, j
.stream cos(pi*\i*(2*\j + 1)/32), cos(pi*(\i + 1)*(2*\j + 1)/32)
.endm
.macro rows i, j
        entries \i, \j
        entries (\i + 2), \j
        entries (\i + 4), \j
        entries (\i + 6), \j
.endm
.macro columns i
        rows \i, 1
        rows \i, 2
        rows \i, 3
        rows \i, 4
        rows \i, 5
        rows \i, 6
        rows \i, 7
        rows \i, 8
        rows \i, 9
        rows \i, 10
        rows \i, 11
        rows \i, 12
        rows \i, 13
        rows \i, 14
        rows \i, 15
.endm
; The first row of column 0 gives the block its name; cos(0) = 1.
.stream upper, pin A = 1, cos(pi/32)
        entries 2, 0
        entries 4, 0
        entries 6, 0
        columns 0
.stream lower, pin B = cos(pi*8/32), cos(pi*9/32)
        entries 10, 0
        entries 12, 0
        entries 14, 0
        columns 8

.macro row i, block, x
        fmadd   s\i, \block+, \x, s\i
.endm
.macro start i, block
        fmul    s\i, \block+, x0
.endm
.macro column x
        row 0, upper, \x
        row 1, upper, \x
        row 2, upper, \x
        row 3, upper, \x
        row 4, upper, \x
        row 5, upper, \x
        row 6, upper, \x
        row 7, upper, \x
        row 8, lower, \x
        row 9, lower, \x
        row 10, lower, \x
        row 11, lower, \x
        row 12, lower, \x
        row 13, lower, \x
        row 14, lower, \x
        row 15, lower, \x
.endm

        signals 0
        signals 1
        signals 2
        signals 3
        signals 4
        signals 5
        signals 6
        signals 7
        signals 8
        signals 9
        signals 10
        signals 11
        signals 12
        signals 13
        signals 14
        signals 15

        seek    upper
        seek    lower
        start 0, upper
        start 1, upper
        start 2, upper
        start 3, upper
        start 4, upper
        start 5, upper
        start 6, upper
        start 7, upper
        start 8, lower
        start 9, lower
        start 10, lower
        start 11, lower
        start 12, lower
        start 13, lower
        start 14, lower
        start 15, lower
        column x1
        column x2
        column x3
        column x4
        column x5
        column x6
        column x7
        column x8
        column x9
        column x10
        column x11
        column x12
        column x13
        column x14
        column x15
        mov     y0, s0
        mov     y1, s1
        mov     y2, s2
        mov     y3, s3
        mov     y4, s4
        mov     y5, s5
        mov     y6, s6
        mov     y7, s7
        mov     y8, s8
        mov     y9, s9
        mov     y10, s10
        mov     y11, s11
        mov     y12, s12
        mov     y13, s13
        mov     y14, s14
        mov     y15, s15
        halt
