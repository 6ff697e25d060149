; assemble: -O0
; Linear code, one operation per bundle: inputs, constants, state, output.
.program  "leg length"
.input    x, y, z
.input    count : int
.const    R = 0.5
.state    previous : int = 0
.output   F1, safe = 0.0

        fsub    dy, y, R           ; (7)
        fmul    t, x, x            ;(7)
        fmadd   t2, dy, dy, t      # (8) a note
        fmadd   q, z, z, t2        ; not (9)
        fsqrt   l, q
        fdiv    r, 1.0, l
        fsat    F1, r, 0.0, 2.0
        mov     previous, count
        halt
; = 00040000000004000000006804040104
; = 00040000000050040200000400000000
; = 00040000000004000000004009008080
; = 000400000000040000000040140a0441
; = 00c40908000004000000000400000000
; = 00c01415820004000000000400000000
; = 00a60308010604000000000400000000
; = 019c040c000004000000000400000000
