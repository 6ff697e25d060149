; assemble: --config fast
; The file and the command line disagree.
.config small ; error: the file insists on configuration 'small', the command line says 'fast' => use --config small or change .config
        halt
