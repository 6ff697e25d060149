; assemble: -O0
; A register that a state names is given to no symbol, even where no operation mentions it.
.input  x
.state  kept = 1.0, pin c0
.state  other = 2.0, pin a1
        mov     t1, x
        mov     t2, t1
        fadd    t3, t2, t1
        fadd    t4, t3, t2
        fadd    t5, t4, t3
        halt
; = 009c0c00000004000000000400000000
; = 009c1304000004000000000400000000
; = 000400000000040000000060030800c1
; = 00040000000060010000c20400000000
; = 01040000000004000000006012000040
