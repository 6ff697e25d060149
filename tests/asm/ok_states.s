; assemble: -O0
; States: pinned to a bank or a register, never written, exported.
.input  x
.state  sum = 0.0, pin B
.state  fixed = 1.5, pin c7
.state  kept : int = -2
.state  first = 0.25
.export sum, fixed, kept, x, last, again = a9
        fadd    s1, sum, x
        fadd    sum, s1, fixed
        mov     fixed, sum
        fadd    last, first, x
        mov     first, last
        halt
; = 00040000000004000000006002000100
; = 00040000000060010000c70400000000
; = 009c3a00000004000000000400000000
; = 0004000000000400000000600b040100
; = 019c0904000004000000000400000000
