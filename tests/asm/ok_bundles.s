; Bundles with physical registers: encoded as written, slots by destination.
.input  x, y
.const  two = 2.0, pin k2
.output F1, safe = -1.0
        { fmadd a3, a1, k2, b7 | fmul b4, x, y | fdiv c1, a0, b0 }
        { fdiv c63, y, k127 | fnmsub b63, b1, b2, b3 }
        {
          mov o0, c1 |                  ; a bundle may go on
          fadd a0, a63, zero
        }
        { nop }
        { fsqrt c2, a0 } halt
; = 00c00901000050240202004019060487
; = 00c1fc06fe0045fa0504830400000000
; = 009e0304000004000000006001fc0000
; = 00040000000004000000000400000000
; = 01c41100000004000000000400000000
