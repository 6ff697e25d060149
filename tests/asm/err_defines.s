; assemble: -D R=abc -D Q=2
; Values from the command line.
.param  R = 0.5
.const  Q = 1
        halt
; error: 'abc' is not the name of a constant => did you mean 'abs'?
; error: -D Q: the program has no parameter 'Q' => only names declared with .param can be replaced
