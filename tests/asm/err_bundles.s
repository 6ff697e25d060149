; Bundles in braces.
.input  x
        { fadd a1, x, x | fmul a1, x, x } ; error: two operations of one bundle write 'a1'
        { fadd a1, x, x | fmul a2, x, x } ; error: no slot left for fmul: configuration 'fast' has slots fma, fma, aux; fadd takes slot 0 => put this multiply-add operation into another bundle
        { fadd t, x, x | fmul u, x, x | fsub v, x, x } ; error: no slot left for fsub: configuration 'fast' has slots fma, fma, aux; fadd takes slot 0, fmul takes slot 1 => put this multiply-add operation into another bundle
        { mov c1, x | fdiv c2, x, x } ; error: no slot left for fdiv: configuration 'fast' has slots fma, fma, aux; mov takes slot 2 => put this auxiliary operation into another bundle
        { fadd a1, x, x | halt } ; error: 'halt' is no operation of a bundle => write it after the '}'
        { } ; error: expected an operation, found '}'
        { fadd a1, x, x fmul b1, x, x } ; error: fadd takes 3 operands, found 5 => fadd dst, a, c
        { mov c1, x } mov c2, x ; error: 'mov' is more than this statement takes => one statement per line
loop:   { bz x, loop } halt ; error: bz in a bundle that ends the run
        { fadd a1, x, x | ; error: bundle without closing brace => add }
