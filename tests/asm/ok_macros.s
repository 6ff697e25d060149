; assemble: -O0 -D gain=3.0
; Macros, conditional assembly, parameters, included files.
.input  x
.param  gain = 2.0
.output F1, safe = 0.0
.include "square.inc"
.if     gain - 2
        square  q, x
        fmul    p, q, gain              ; (1)
.else
        unknown q, x
.endif
.if     0
.if     1
        unknown
.else
        unknown
.endif
.macro  square d
.endm
.endif
.macro  clip d, s
again\@: fsat   \d, \s, (0 - gain), gain
.endm
        clip    F1, p
        halt
; = 00040000000004000000005004020000
; = 00040000000004000000005009020200
; = 01a60106050104000000000400000000
