; A program needs an operation.
.program "nothing" ; error: the program has no operation => add halt
