/*
 * The smallest program that uses the library: reads one table file, moves X by 50 mm at 20 mm/s, and prints the drive
 * positions beside the commands.
 *
 *   first_cycle MACHINE.tcomp        a machine of three axes
 */
#include <stdio.h>

#include "trueaxis.h"

#define PERIOD_NS 1000000u /* servo cycles at 1 kHz */

/* Firmware also has all of this in static memory. uint64_t aligns to 8 bytes. */
static uint8_t file[1 << 20];
static uint64_t memory[8192];
static trueaxis_loop_t loop;
static trueaxis_state_t state;

int main(int count, char **arguments) {
    trueaxis_error_t error = { .size = sizeof error };
    trueaxis_input_t input = { .size = sizeof input };
    trueaxis_output_t output = { .size = sizeof output };
    FILE *stream = count == 2 ? fopen(arguments[1], "rb") : NULL;
    if (stream == NULL) {
        fprintf(stderr, "usage: first_cycle MACHINE.tcomp\n");
        return 2;
    }
    const size_t length = fread(file, 1, sizeof file, stream);
    fclose(stream);
    if (trueaxis_check_abi(TRUEAXIS_ABI_VERSION) != TRUEAXIS_OK) {
        fprintf(stderr, "the header is not the library's\n");
        return 2;
    }
    if (trueaxis_loop_build(&loop, sizeof loop, file, length, 0, PERIOD_NS, memory, sizeof memory, &error) != TRUEAXIS_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 2;
    }
    trueaxis_start(&loop, &state, sizeof state, PERIOD_NS);

    input.homed = 1;
    input.enable = 1;
    input.elapsed_ns = PERIOD_NS;
    for (int cycle = 0; cycle <= 2500; ++cycle) {
        const double command[3] = { 0.02 * cycle, 0, -200 };
        for (int axis = 0; axis < 3; ++axis) {
            input.command[axis] = command[axis];
            input.feedback[axis] = command[axis]; /* on a machine: from the encoders */
        }
        if (trueaxis_step(&loop, &state, &input, NULL, NULL, &output) != TRUEAXIS_OK) {
            fprintf(stderr, "no drive positions in cycle %d\n", cycle);
            return 1;
        }
        if (cycle % 500 == 0) { /* output.drive goes to the drives */
            printf("X commanded %7.4f mm, to the drive %7.4f mm\n", command[0], output.drive[0]);
        }
    }
    return 0;
}
