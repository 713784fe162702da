/*
 * Steps through a recording that `firmware-sim replay` wrote as CSV and counts the drive positions that differ from the
 * library's in any bit: replay TABLES.tcomp RUN.csv. For controllers of three axes in double precision.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "trueaxis.h"

#define AXES 3
#define PERIOD_NS 1000000u
#define HEADER                                                                                                              \
    "x_cmd_mm,y_cmd_mm,z_cmd_mm,x_mm,y_mm,z_mm,x_drive_mm,y_drive_mm,z_drive_mm,elapsed_ns,homed,enable,reset,encoder_alarm," \
    "limited,fault\n"

static trueaxis_loop_t loop;
static uint64_t memory[65536 / 8];
static trueaxis_state_t state;
static trueaxis_input_t input = { .size = sizeof input };
static trueaxis_output_t output = { .size = sizeof output };
static trueaxis_error_t error = { .size = sizeof error };
static uint8_t tables[1 << 20];

int main(int argc, char **argv) {
    char line[512];
    FILE *file = argc == 3 ? fopen(argv[1], "rb") : NULL;
    if (file == NULL) {
        fputs("usage: replay TABLES.tcomp RUN.csv\n", stderr);
        return 2;
    }
    size_t length = fread(tables, 1, sizeof tables, file);
    fclose(file);
    if (trueaxis_loop_build(&loop, sizeof loop, tables, length, 0, PERIOD_NS, memory, sizeof memory, &error) != TRUEAXIS_OK) {
        fprintf(stderr, "%s: %s\n", argv[1], error.text);
        return 2;
    }
    if (trueaxis_start(&loop, &state, sizeof state, PERIOD_NS) != TRUEAXIS_OK) {
        return 2;
    }
    file = fopen(argv[2], "r");
    if (file == NULL || fgets(line, sizeof line, file) == NULL || strcmp(line, HEADER) != 0) {
        fprintf(stderr, "%s: needed the columns " HEADER, argv[2]);
        return 2;
    }
    long samples = 0, same = 0;
    double largest = 0.0;
    while (fgets(line, sizeof line, file) != NULL) {
        double drive[AXES], *c = input.command, *f = input.feedback;
        unsigned homed, enable, reset, alarm, limited, fault;
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%" SCNu32 ",%u,%u,%u,%u,%u,%u", &c[0], &c[1], &c[2], &f[0], &f[1], &f[2],
                   &drive[0], &drive[1], &drive[2], &input.elapsed_ns, &homed, &enable, &reset, &alarm, &limited, &fault) != 16) {
            fprintf(stderr, "%s: cycle %ld cannot be read\n", argv[2], samples / AXES);
            return 2;
        }
        input.homed = homed != 0, input.enable = enable != 0, input.reset = reset != 0, input.encoder_alarm = (uint8_t)alarm;
        if (trueaxis_step(&loop, &state, &input, NULL, NULL, &output) != TRUEAXIS_OK || output.record.fault != fault || output.record.limited != limited) {
            fprintf(stderr, "%s: cycle %ld is refused, or has another fault\n", argv[2], samples / AXES);
            return 1;
        }
        for (int axis = 0; axis < AXES; axis++, samples++) {
            same += memcmp(&drive[axis], &output.drive[axis], sizeof drive[axis]) == 0;
            largest = fmax(largest, fabs(drive[axis] - output.drive[axis]));
        }
    }
    fclose(file);
    printf("{\"host\": \"c\", \"samples\": %ld, \"same\": %ld, \"largest_mm\": %.3g}\n", samples, same, largest);
    return samples == 0 || same != samples;
}
