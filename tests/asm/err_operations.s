; Mnemonics and operands.
.input  x, y, n : int
.const  two = 2 : int
.data   table = 1, 2
        fad     t1, x, y ; error: unknown operation 'fad' => did you mean 'fadd'?
        fadd    t2, x ; error: fadd takes 3 operands, found 2 => fadd dst, a, c
        fadd    t3, x, y, y ; error: fadd takes 3 operands, found 4 => fadd dst, a, c
        halt    x ; error: 'x' is more than this statement takes => one statement per line
        fadd    t4, x, 2*3 ; error: '*' after the operands of fadd => an operand that is an expression is written in parentheses
        fadd    t5, x, -y ; error: 'y' is not a constant: an operand cannot negate it => subtract it instead, or negate it first: fsub negative, 0.0, y
        fadd    t5, x, -two ; error: an expression as an operand is written in parentheses => (-two)
        imul    t5, n, n ; error: unknown operation 'imul' => integers have no such operation; theirs are iadd, isub, i2f
        fadd    t6, x, sqrt(2) ; error: an expression as an operand is written in parentheses => (sqrt(...))
        fadd    t7, x, [y] ; error: expected operand c of fadd: a register, a number or '(', found '['
        fadd    7, x, y ; error: expected the destination of fadd, found '7'
        fadd    t8 x, y ; error: fadd takes 3 operands, found 2 => commas separate operands: fadd t8, x, y
        fadd    t9, x, n ; error: 'n' is of type int, fadd reads type float => convert with i2f
        fadd    t10, x, two ; error: 'two' is of type int, fadd reads type float => convert with i2f
        iadd    t11, n, y ; error: 'y' is of type float, iadd reads type int => convert with f2i or f2it
        iadd    t12, n, 1.5 ; error: 1.5 is not an integer
        iadd    t13, n, 4294967296 ; error: 4294967296 does not fit 32 bits => range -2147483648..4294967295
        fadd    t14, x, 1e39 ; error: 1e+39 is not a finite binary32 number => constants are finite; the largest magnitude is 3.40282347e+38
        fadd    t15, x, table ; error: 'table' is the address of data memory, not a register => load it: ld register, table
        ld      t16, 1024 ; error: data address 1024 is out of range => addresses are integers 0..1023
        ld      t17, table-1 ; error: data address -1 is out of range => addresses are integers 0..1023
        ld      t18, 65536[n] ; error: data address 65536 is out of range => offsets are integers 0..65535
        ld      t19, table[x] ; error: 'x' is of type float, ld reads type int => convert with f2i or f2it
        ld      t20, table[1] ; error: expected the index register, found '1'
        ld      t21, table[n ; error: expected ']' after the index register, found the end of the line
        st      x, tabel ; error: 'tabel' is not the name of a constant => did you mean 'table'?
        jmp     7 ; error: expected a label, found '7'
        mov     t22, y } halt ; error: '}' is more than this statement takes => one statement per line
        halt
