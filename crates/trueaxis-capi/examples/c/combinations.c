/*
 * Every measure with and without a gauge on a five-axis machine. Prints a sum over all bits of each combination; the
 * example combinations.rs prints the same sums from the Rust interface.
 *
 *   combinations FIVE_AXES_WITH_GAUGE.tcomp
 */
#include <inttypes.h>
#include <stdio.h>

#include "trueaxis.h"

#define PERIOD_NS 100000u
#define CYCLES 8000
#define LAG 10
#define AXES 5

static const double from[AXES] = { 10, 20, -100, 20, 5 }, to[AXES] = { 50, 35, -90, 35, 25 };

static uint8_t file[1 << 18];
static trueaxis_loop_t loop;
static trueaxis_state_t state;
static trueaxis_kinematics_t kinematics;
static trueaxis_branch_tracker_t tracker;
static trueaxis_command_window_t window;
static trueaxis_path_t path;
static trueaxis_gauge_t gauge;
static trueaxis_gauge_state_512_t gauge_state;
static uint64_t memory[8192], path_memory[16 * TRUEAXIS_TOOL_SPAN_BYTES / 8];

static uint64_t sum;

static void add(const void *from_here, size_t size) {
    const uint8_t *bytes = from_here;
    for (size_t i = 0; i < size; ++i) {
        sum = (sum ^ bytes[i]) * UINT64_C(0x100000001b3);
    }
}

static void add_contour(const trueaxis_contour_t *contour) {
    add(&contour->error, sizeof contour->error);
    add(&contour->lag, sizeof contour->lag);
    add(contour->vector, sizeof contour->vector);
    add(&contour->flags, 1);
}

static void between(double u, double at[AXES]) {
    for (int axis = 0; axis < AXES; ++axis) {
        at[axis] = from[axis] + (to[axis] - from[axis]) * u;
    }
}

static trueaxis_result_t combination(uint32_t kind, int with_gauge, const trueaxis_tool_t ends[2]) {
    trueaxis_input_t input = { .size = sizeof input, .elapsed_ns = PERIOD_NS, .homed = 1, .enable = 1 };
    trueaxis_output_t output = { .size = sizeof output };
    trueaxis_measure_t measure = {
        .size = sizeof measure, .kind = kind, .path = &path, .window = &window, .kinematics = &kinematics
    };
    trueaxis_gauge_ride_t ride = {
        .size = sizeof ride, .gauge = &gauge, .state = (trueaxis_gauge_state_t *)&gauge_state
    };
    double drives[LAG][AXES];
    trueaxis_result_t result = trueaxis_start(&loop, &state, sizeof state, PERIOD_NS);
    if (result == TRUEAXIS_OK)
        result = trueaxis_branch_tracker_start(&tracker, sizeof tracker, &kinematics, from, 0.1, NULL);
    if (result == TRUEAXIS_OK)
        result = trueaxis_command_window_start(&window, sizeof window, NULL, 0.005);
    if (result == TRUEAXIS_OK)
        result = trueaxis_gauge_restart(&gauge, ride.state, sizeof gauge_state);
    for (int32_t cycle = 0; cycle < CYCLES && result == TRUEAXIS_OK; ++cycle) {
        const double u = cycle / 8192.0;
        double at[AXES];
        between(u, at);
        for (int axis = 0; axis < AXES; ++axis) {
            input.command[axis] = at[axis];
            input.feedback[axis] = cycle < LAG ? from[axis] : drives[cycle % LAG][axis];
        }
        if (kind == TRUEAXIS_MEASURE_TOOL) {
            trueaxis_tool_t tool;
            result = trueaxis_kinematics_forward(&kinematics, at, &tool);
            for (int i = 0; i < 3; ++i)
                tool.tip[i] = ends[0].tip[i] + (ends[1].tip[i] - ends[0].tip[i]) * u;
            if (result == TRUEAXIS_OK)
                result = trueaxis_rtcp(&loop, &state, &tool, &tracker, &kinematics, &input);
        }
        ride.spindle = ride.index = cycle * 1024;
        ride.has_index = cycle > 0 && cycle % 1024 == 0;
        for (int probe = 0; probe < 3; ++probe)
            ride.readings[probe] = ((cycle * (7 + 2 * probe)) % 512 - 256) / 256.0;
        if (result == TRUEAXIS_OK)
            result = trueaxis_path_reference(&path, 0, u, &measure.reference);
        if (result == TRUEAXIS_OK)
            result = trueaxis_step(&loop, &state, &input, &measure, with_gauge ? &ride : NULL, &output);
        for (int axis = 0; axis < AXES; ++axis)
            drives[cycle % LAG][axis] = output.drive[axis];
        add(output.drive, AXES * sizeof output.drive[0]);
        add_contour(&output.record.tip);
        add_contour(&output.record.encoder);
        add(&output.record.orientation, sizeof output.record.orientation);
        add(&ride.infeed, sizeof ride.infeed);
        add(&ride.flags, sizeof ride.flags);
        add(&ride.finished, sizeof ride.finished);
        add(measure.direction_error, sizeof measure.direction_error);
    }
    return result;
}

int main(int count, char **arguments) {
    FILE *stream = count == 2 ? fopen(arguments[1], "rb") : NULL;
    if (stream == NULL) {
        fputs("usage: combinations FILE.tcomp\n", stderr);
        return 2;
    }
    const size_t length = fread(file, 1, sizeof file, stream);
    fclose(stream);
    const double axes[2][3] = { { from[3], 0, from[4] }, { to[3], 0, to[4] } };
    trueaxis_error_t error = { .size = sizeof error };
    trueaxis_tool_t ends[2] = { { { 0 }, { 0 } }, { { 0 }, { 0 } } };
    if (trueaxis_loop_build(&loop, sizeof loop, file, length, 0, PERIOD_NS, memory, sizeof memory, &error) ||
        trueaxis_kinematics_build(&kinematics, sizeof kinematics, file, length, &error) ||
        trueaxis_gauge_build(&gauge, sizeof gauge, file, length, PERIOD_NS, &error) ||
        trueaxis_kinematics_forward(&kinematics, from, &ends[0]) || trueaxis_kinematics_forward(&kinematics, to, &ends[1]) ||
        trueaxis_path_start_tool(&path, sizeof path, path_memory, sizeof path_memory, 0) ||
        trueaxis_path_axes(&path, axes[0], axes[1]) || trueaxis_path_line(&path, ends[0].tip, ends[1].tip, &error)) {
        fprintf(stderr, "refused: %s\n", error.text);
        return 1;
    }
    for (uint32_t kind = TRUEAXIS_MEASURE_NOTHING; kind <= TRUEAXIS_MEASURE_TOOL; ++kind) {
        for (int with_gauge = 0; with_gauge < 2; ++with_gauge) {
            sum = UINT64_C(0xcbf29ce484222325);
            const trueaxis_result_t result = combination(kind, with_gauge, ends);
            if (result != TRUEAXIS_OK) {
                fprintf(stderr, "measure %" PRIu32 ", gauge %d: %s\n", kind, with_gauge, trueaxis_result_text(result));
                return 1;
            }
            printf("measure %" PRIu32 ", gauge %d: %016" PRIx64 "\n", kind, with_gauge, sum);
        }
    }
    return 0;
}
