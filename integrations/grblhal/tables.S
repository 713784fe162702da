/* The machine's tables in flash, in a separate section: TRUEAXIS_TABLES names the .tcomp. MIT OR Apache-2.0. */
    .section .rodata.trueaxis_tables, "a"
    .balign 4
    .global trueaxis_tables, trueaxis_tables_end
trueaxis_tables:
    .incbin TRUEAXIS_TABLES
trueaxis_tables_end:
    .section .note.GNU-stack, "", %progbits
