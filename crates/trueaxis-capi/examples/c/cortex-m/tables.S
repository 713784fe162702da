/* The two table files as they are, at the addresses that mps2.ld gives them. */
    .syntax unified
    .section .tables_first, "a"
    .global tables_first, tables_first_end
tables_first:
    .incbin FIRST
tables_first_end:

    .section .tables_second, "a"
    .global tables_second, tables_second_end
tables_second:
    .incbin SECOND
tables_second_end:
