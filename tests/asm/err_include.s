; Included files.
.include "missing.inc" ; error: file 'missing.inc' not found => searched tests/asm
.include missing ; error: expected a file name in quotes: .include "file", found 'missing'
.include "err_include.s" ; error: file 'err_include.s' includes itself => err_include.s -> err_include.s
        halt
