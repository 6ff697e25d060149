; Conditional assembly.
.else ; error: .else without .if
.endif ; error: .endif without .if
.if     unknown ; error: 'unknown' is not the name of a constant => declare it above with .const or .param
        nonsense
.endif
.if     1
        nonsence ; error: unknown operation 'nonsence' => a label is written with a colon: nonsence:
.else
.else ; error: second .else of one .if
.endif
.if     0
        ignored 1.2.3
.if     ignored
.else
.endif
.endif  0 ; error: '0' is more than this statement takes => one statement per line
        halt
.if     1 2 ; error: '2' is more than this statement takes => one statement per line ; error: .if without .endif => add .endif
