; Declarations and directives.
.program "first"
.program "second" ; error: second .program => a file has one title
.program title ; error: expected a title in quotes: .program "title", found 'title'
.inputs x ; error: unknown directive '.inputs' => did you mean '.input'?
.input  x, y, z
.input  x ; error: 'x' is declared twice => it is an input, declared at tests/asm/err_declarations.s:6
.input  n : integer ; error: unknown type 'integer' => did you mean 'int'?
.input  m : complex ; error: unknown type 'complex' => types are float and int
.input  3 ; error: expected the name of an input, found '3'
.input  u v ; error: expected ',' between inputs, found 'v'
.const  a3 = 1 ; error: 'a3' cannot be declared: the name is reserved => a0.., b0.., c0.., k0.., o0.., zero and pi have fixed meanings
.const  pi = 3 ; error: 'pi' cannot be declared: the name is reserved => a0.., b0.., c0.., k0.., o0.., zero and pi have fixed meanings
.const  o1 = 3 ; error: 'o1' cannot be declared: the name is reserved => a0.., b0.., c0.., k0.., o0.., zero and pi have fixed meanings
.const  wide = 4294967296 : int ; error: 4294967296 does not fit 32 bits => range -2147483648..4294967295
.const  half = 0.5 : int ; error: 0.5 is not an integer
.const  y = 2 ; error: 'y' is declared twice => it is an input, declared at tests/asm/err_declarations.s:6
.param  p = 1, pin a4 ; error: a constant cannot be pinned to 'a4' => pin k0..k127
.state  s ; error: expected '=' and the initial value after the name of a state, found the end of the line
.state  s1 : int = 1.5 ; error: 1.5 is not an integer
.state  s2 = 0, pin D ; error: a state cannot be pinned to 'D' => pin A, B or C, or a register of these banks
.state  s3 = 0, pen A ; error: expected 'pin', found 'pen'
.state  s4 = 0, pin k3 ; error: a state cannot be pinned to 'k3' => pin A, B or C, or a register of these banks
.output F1 ; error: expected ',' and the safe value: .output name, safe = value, found the end of the line
.output F2, save = 0 ; error: expected 'safe', found 'save'
.output F3, safe = 1e40 ; error: 1e+40 is not a finite binary32 number => constants are finite; the largest magnitude is 3.40282347e+38
.export ; error: expected the name of a register, found the end of the line
.export x, x ; error: 'x' is exported twice => first at tests/asm/err_declarations.s:28
.data   table = 1, 2, 1e40 ; error: 1e+40 is not a finite binary32 number => constants are finite; the largest magnitude is 3.40282347e+38
.data   more = 1 2 ; error: expected ',' between data words, found '2'
.space  block, 0 ; error: 0 is not a number of words
.space  block2, 1.5 ; error: 1.5 is not a number of words
.reg    r, r ; error: 'r' is declared twice => it is a symbolic register, declared at tests/asm/err_declarations.s:33
.watchdog 0 ; error: 0 is not a number of cycles => an integer 1..4294967295
.watchdog many ; error: 'many' is not the name of a constant => declare it above with .const or .param
.config fsat ; error: unknown configuration 'fsat' => did you mean 'fast'?
.config fast
.config small ; error: .config small contradicts .config fast => first at tests/asm/err_declarations.s:37
        halt
