/*
 * The smallest firmware with the library: loads tables, measures the contour error against a path, corrects, and sends
 * every record as a frame. `size.py` links it to measure how much of the library it includes.
 */
#include "trueaxis.h"

#define PERIOD_NS 100000u
#define SPANS 64

/* Provided by the board. */
extern const uint8_t tables[], tables_end[];
void read_machine(trueaxis_input_t *input);
void write_drives(const trueaxis_position_t *drive);
void send(const uint8_t *bytes, size_t count);

static trueaxis_loop_t loop;
static trueaxis_state_t state;
static trueaxis_path_t path;
static uint64_t memory[2048];
static uint64_t path_memory[SPANS * TRUEAXIS_SPAN_BYTES / 8];
static trueaxis_measure_t measure = { .size = sizeof measure, .kind = TRUEAXIS_MEASURE_PATH, .path = &path };
static trueaxis_input_t input = { .size = sizeof input };
static trueaxis_output_t output = { .size = sizeof output };
static trueaxis_error_t error = { .size = sizeof error };
static uint8_t frame[TRUEAXIS_FRAME_BYTES];

trueaxis_result_t start(const double *from, const double *to) {
    trueaxis_result_t result = trueaxis_check_abi(TRUEAXIS_ABI_VERSION);
    if (result == TRUEAXIS_OK) {
        result = trueaxis_loop_build(&loop, sizeof loop, tables, (size_t)(tables_end - tables), 0, PERIOD_NS, memory,
                                     sizeof memory, &error);
    }
    if (result != TRUEAXIS_OK) {
        trueaxis_loop_bypass(&loop, sizeof loop, 3, TRUEAXIS_FAULT_TABLES_REFUSED, PERIOD_NS);
    }
    trueaxis_path_start(&path, sizeof path, path_memory, sizeof path_memory, 0);
    trueaxis_path_line(&path, from, to, &error);
    trueaxis_start(&loop, &state, sizeof state, PERIOD_NS);
    return result;
}

void servo_interrupt(double u) {
    size_t written;
    read_machine(&input);
    trueaxis_path_reference(&path, 0, u, &measure.reference);
    if (trueaxis_step(&loop, &state, &input, &measure, NULL, &output) == TRUEAXIS_OK) {
        write_drives(output.drive);
    }
    if (trueaxis_frame_encode(&output, frame, sizeof frame, &written) == TRUEAXIS_OK) {
        send(frame, written);
    }
}
