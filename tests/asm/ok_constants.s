; assemble: -O0
; Constants: shared words, zero, integers, parameters, expressions.
.const  half = 1/2
.const  also_half = 0.5
.const  nothing = 0.0
.const  minus_zero = -0.0
.const  five = 5 : int
.param  p = 0.5
.const  angle = 2*pi/(3 - 1)
.const  unused = 7.0
.input  n : int
        fadd    t1, half, also_half
        fadd    t2, 0.5, nothing
        fadd    t3, minus_zero, 0.0
        iadd    t4, n, five
        iadd    t5, n, 5
        iadd    t6, n, 0xffffffff
        fadd    t7, p, angle
        fadd    t8, pi, (-sqrt(4) + abs(-1) - cos(0) + sin(0))
        fadd    t9, -0.5, 0f3fc00000
        halt
; = 00040000000004000000006004040101
; = 0004000000000400000000600c040000
; = 00040000000004000000006014080000
; = 00b40402060004000000000400000000
; = 00b40c02060004000000000400000000
; = 00b41402080004000000000400000000
; = 0004000000000400000000601c140106
; = 00040000000004000000006024180107
; = 0104000000000400000000602c200109
