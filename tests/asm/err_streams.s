; Streams: where they are, and which word is next.
.config stream
.input  x
.output F, safe = 0.0
.stream 1.0 ; error: a stream needs a name and its pipe => .stream name, pin A = words; only a second .stream after it goes on without
.stream W, pin C = 1.0 ; error: there is no stream of 'C' => pin A or B, a multiply-add pipe
.stream A, pin A = 1.0 ; error: a block of a stream cannot be named 'A', as a pipe is
.stream U, pin A = 1.0, 2.0
.stream 3.0
.stream V, pin A = 4.0
.stream X, pin B = 5.0
        fmul    a0, U+, x ; error: the stream of pipe A is at no place when 'U+' takes a word => seek U before it
        seek    U+3 ; error: 'U' has 3 words, there is no word 3 => words are U+0 to U+2
        seek    V+X ; error: a place in a stream names one block of it => seek W, or seek W+3 for its fourth word, where .stream declares W
        seek    x ; error: 'x' is not the name of a constant => declare it above with .const or .param
        seek    U+1
        seek    X
        fmul    p, U+, x
        fmul    p, V+, p ; error: the stream of pipe A is at a word of 'U' when 'V+' takes a word => seek V before it
        seek    U+2
        fmul    p, U+, p
        fmul    p, U+, p ; error: 'U' has no word left of its 3 => seek U before it, or add words
        seek    U
        fmul    b1, U+, p ; error: 'U' is a stream of pipe A, whose results go to bank A, and b1 is of another => write a register of bank A, or declare the words with pin B
        fmul    p, U+, U+ ; error: an operation takes one word of its stream => write the other word to a register before
        mov     c1, U+ ; error: mov cannot read a stream => multiply-adds can: write a register with fadd register, zero, U+ and read that
        fmul    p, U, p ; error: 'U' is a block of a stream, not a register => take its next word: U+
        fmul    p, y+, p ; error: 'y+' takes the next word of a stream, and 'y' is none => declare it above: .stream name, pin A = words; a sum is written in parentheses
        { fmul q, U+, x | fmul r, U+, x } ; error: no slot left for fmul: configuration 'stream' has slots fma, fma, aux; fmul takes slot 0 => put this multiply-add operation into another bundle
        bz      x, other
        seek    U
other:  fmul    p, U+, p ; error: which word 'U+' takes is not the same on every path => seek U before it
        mov     F, p
        halt
