; Parameter files.
.params "missing.toml" ; error: file 'missing.toml' not found => searched tests/asm
.params machine.toml ; error: expected a file name in quotes: .params "file", found 'machine.toml'
.params "machine.toml", Q ; error: 'tests/asm/machine.toml' has no parameter 'Q'
.params "machine.toml" R ; error: expected ',' between names, found 'R'
.params "square.inc" ; error: cannot read 'tests/asm/square.inc': tests/asm/square.inc:1:1: error: Invalid statement
.params "machine.toml", R, T_s
.param R = 2 ; error: 'R' is declared twice => it is a constant, declared at tests/asm/machine.toml:2
        halt
