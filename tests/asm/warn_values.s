; Constant operands and addresses that nobody can mean.
.input  s
.input  i : int
.data   tab = 1.0, 2.0
.data   other = 3.0
.output F, safe = 0.0
.export a, b, c, d, e, f, g, h, j
        ld      a, tab+1
        ld      b, tab+2 ; warning: address 2 is outside of 'tab', which has 2 words from 0 [data-bounds]
        ld      c, tab+2[i]
        ld      d, other+1 ; warning: address 3 is outside of 'other', which has 1 word from 2 [data-bounds]
        fdiv    e, s, 0.0 ; warning: division by 0: the result is infinite or NaN [division-by-zero]
        fsin    f, 1000.0 ; warning: fsin of 1000 rad is NaN: arguments lie in -256..256 rad => take whole turns out first [invalid-argument]
        fcos    g, 256.0
        fsqrt   h, -4.0 ; warning: square root of -4: the result is NaN [invalid-argument]
        iadd    n, i, i
        fadd    j, n, s ; warning: 'n' is of type int (iadd writes it), fadd reads type float => convert with i2f [type]
        mov     F, s
        halt
