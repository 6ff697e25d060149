; Labels.
.input  x
.watchdog 100 200 ; error: '200' is more than this statement takes => one statement per line
again:  mov     t, x
again:  mov     u, x ; error: label 'again' is defined twice => first at tests/asm/err_labels.s:4
        jmp     agian ; error: label 'agian' is not defined => did you mean 'again'?
