; Characters, numbers and strings that mean nothing.
.input  x
.const  A = 1.2.3 ; error: malformed number '1.2.3' => numbers are written 12, 0x1f, 1.5, 2e-3 or 0f3fc00000
.const  B = 0x ; error: malformed number '0x' => numbers are written 12, 0x1f, 1.5, 2e-3 or 0f3fc00000
.const  C = .5 ; error: malformed number '.5' => numbers are written 12, 0x1f, 1.5, 2e-3 or 0f3fc00000
.const  D = 0f3f8000 ; error: malformed number '0f3f8000' => numbers are written 12, 0x1f, 1.5, 2e-3 or 0f3fc00000
.const  E = 1e ; error: malformed number '1e' => numbers are written 12, 0x1f, 1.5, 2e-3 or 0f3fc00000
.const  F = 0f7fc00000 ; error: 0f7fc00000 is not a finite number => NaN and infinity cannot be constants
.const  G = 1e999 ; error: 1e999 is not a finite number
        mov     t, x @ ; error: character '@' means nothing here
        halt
