; Macros.
.input  x
.macro  square d, s
        fmul    \d, \s, \t ; error: macro 'square' has no parameter 't' => its parameters are d, s; \@ numbers the expansion
.endm
.macro  square d ; error: macro 'square' is defined twice => first at tests/asm/err_macros.s:3
.endm
.macro  fadd d ; error: a macro cannot be named 'fadd': it is reserved
.endm
.macro  twice d, d ; error: parameter 'd' is named twice
.endm
.macro  cut d, ; error: expected a parameter name, found the end of the line
.endm
.macro  1st ; error: malformed number '1st' => numbers are written 12, 0x1f, 1.5, 2e-3 or 0f3fc00000
.endm
.macro  outer
.macro  inner ; error: .macro inside a macro => close the outer with .endm
.endm
.macro  forever
        forever ; error: macro 'forever' expands itself more than 64 levels deep => end the recursion with .if
.endm
.macro  bad d
        fadd    \d, x, missing ; error: unknown name 'missing' => it is neither declared nor written
.endm
        square  q, x
        square  q ; error: macro 'square' takes 2 arguments, found 1 => square d, s
        bad     t
        forever
.endm ; error: .endm without .macro
        halt
.macro  open ; error: .macro without .endm => add .endm
