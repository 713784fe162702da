/* A controller of 256 KiB of flash and 64 KiB of RAM: the plugin on nine terms, and a servo loop that corrects, measures
 * the contour error against lines and sends records. Prints the remaining memory.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "machine.h"
#include "trueaxis_correction.h"

#define PERIOD_NS 1000000u
#define SPANS 16
#define HEAP 2048 /* of the C library's printf */
#define PAINT 0xA5u

#define CHECK(holds)                                                                                                   \
    do {                                                                                                               \
        if (!(holds)) {                                                                                                \
            printf("FAILED line %d: %s; %s\n", __LINE__, #holds, told);                                                \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

extern const uint8_t trueaxis_tables[], trueaxis_tables_end[];
extern uint8_t end[], stack_top[];

static trueaxis_loop_t loop;
static trueaxis_state_t state;
static trueaxis_path_t path;
static uint64_t memory[TRUEAXIS_MEMORY_BYTES / 8];
static uint64_t path_memory[SPANS * TRUEAXIS_SPAN_BYTES / 8];
static trueaxis_measure_t measure = { .size = sizeof measure, .kind = TRUEAXIS_MEASURE_PATH, .path = &path };
static trueaxis_input_t input = { .size = sizeof input, .homed = 1, .enable = 1, .elapsed_ns = PERIOD_NS };
static trueaxis_output_t output = { .size = sizeof output };
static trueaxis_error_t error = { .size = sizeof error };
static uint8_t frame[TRUEAXIS_FRAME_BYTES];

/* Tables of tests/tables.py: EXX 20 um, EYX -20 um, EZX 10 um at odd multiples of 5 mm, 0 at even ones. */
static void moves_are_corrected(void) {
    machine(400.0f);
    core_start(NULL);
    core_home((axes_signals_t){ .mask = 7 }, true);
    CHECK(!strcmp(told, "[MSG:Info: trueaxis: mill-3axis, uncompensated until homed]\r\n[MSG:Info: trueaxis: correction on]\r\n"));
    CHECK(line_to(-105, -80, -60, (plan_line_data_t){ 0 }));
    float drive[3];
    const float command[3] = { -105, -80, -60 };
    trueaxis_correction_forward(command, 0, drive);
    CHECK(fabsf(drive[0] - -105.02f) < 2e-4f && fabsf(drive[1] - -79.98f) < 2e-4f && fabsf(drive[2] - -60.01f) < 2e-4f);
    for (int idx = 0; idx < N_AXIS; idx++) {
        CHECK(fabsf((float)sys.position[idx] / 400.0f - drive[idx]) <= 0.5f / 400.0f + 1e-4f);
    }
}

static void cycles_are_measured(void) {
    const double from[3] = { -200, -100, -300 }, to[3] = { -100, -100, -300 };
    CHECK(trueaxis_loop_build(&loop, sizeof loop, trueaxis_tables, (size_t)(trueaxis_tables_end - trueaxis_tables), 0,
                              PERIOD_NS, memory, sizeof memory, &error) == TRUEAXIS_OK);
    CHECK(trueaxis_start(&loop, &state, sizeof state, PERIOD_NS) == TRUEAXIS_OK);
    CHECK(trueaxis_path_start(&path, sizeof path, path_memory, sizeof path_memory, 0) == TRUEAXIS_OK);
    CHECK(trueaxis_path_line(&path, from, to, &error) == TRUEAXIS_OK);
    float worst = 0;
    for (int cycle = 0; cycle <= 5000; cycle++) {
        const int32_t x = -200000000 + 10000 * cycle, off = cycle % 2000 > 1000 ? 3000 : 0; /* nm */
        input.command[0] = x;
        input.feedback[0] = x - 5000;
        input.command[1] = -100000000;
        input.feedback[1] = input.command[1] + off;
        input.command[2] = input.feedback[2] = -300000000;
        CHECK(trueaxis_path_reference(&path, 0, 1e-4 * cycle, &measure.reference) == TRUEAXIS_OK);
        CHECK(trueaxis_step(&loop, &state, &input, &measure, NULL, &output) == TRUEAXIS_OK);
        CHECK(output.record.fault == TRUEAXIS_FAULT_NONE);
        if (cycle > 100) {
            const float beside = fabsf(output.record.encoder.normal - 1e-6f * (float)off);
            worst = beside > worst ? beside : worst;
        }
        size_t written = 0;
        CHECK(trueaxis_frame_encode(&output, frame, sizeof frame, &written) == TRUEAXIS_OK && written > 0);
    }
    /* At X -150, an even multiple of 5 mm: no error. */
    CHECK(abs(output.drive[0] - input.command[0]) < 5 && worst < 2e-6f);
    printf("contour error of 5,000 cycles: within %.1f nm\n", (double)worst * 1e6);
}

int main(void) {
    volatile uint8_t *const low = (volatile uint8_t *)end + HEAP, *const high = (volatile uint8_t *)__builtin_frame_address(0) - 256;
    for (volatile uint8_t *at = low; at < high; at++) {
        *at = PAINT;
    }
    moves_are_corrected();
    cycles_are_measured();
    const volatile uint8_t *at = low;
    while (at < high && *at == PAINT) {
        at++;
    }
    printf("stack %u bytes, of RAM never used %u\n", (unsigned)(stack_top - (const uint8_t *)at), (unsigned)(at - low));
    CHECK(at > low);
    return 0;
}
