/*
 * Steps a circular motion of 8,000 servo cycles through the tables of a machine, exchanges the tables in motion, and
 * prints the results. Runs on a host and, with cortex-m/, on bare metal.
 *
 *   step_trace FIRST.tcomp SECOND.tcomp        host: files of one machine with three axes
 *   bare metal: the two files are at fixed addresses of the image
 *
 * The motion uses only additions and multiplications and is rounded to whole nanometres, so that it is the same on
 * every machine.
 */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "trueaxis.h"

#define PERIOD_NS 100000u
#define CYCLES 8000
#define REST 100 /* cycles before it moves */
#define SWITCH_AT 2000
#define EXCHANGE_AT 4000
#define ALARM_AT 6000
#define LAG_CYCLES 8
#define AXES 3
#define RADIUS_MM 25.0
#define CENTER_MM { 60.0, -40.0, -200.0 }
#ifndef MEMORY_BYTES
#define MEMORY_BYTES 65536
#endif
#define SPANS 64
#define FNV1A_START UINT64_C(0xcbf29ce484222325)

/* Nothing here is on the stack or the heap: firmware has it in static memory. uint64_t aligns to 8 bytes. */
static trueaxis_loop_t loops[2];
static uint64_t memory[2][MEMORY_BYTES / 8];
static trueaxis_state_t state;
static trueaxis_path_t path;
static uint64_t path_memory[SPANS * TRUEAXIS_SPAN_BYTES / 8];
static trueaxis_tables_info_t info;
static trueaxis_error_t error;
static trueaxis_input_t input;
static trueaxis_output_t output;

struct file {
    const uint8_t *bytes;
    size_t length;
};

#ifdef BARE_METAL
/* Included by cortex-m/tables.S, placed by cortex-m/mps2.ld. */
extern const uint8_t tables_first[], tables_first_end[], tables_second[], tables_second_end[];
#else
static uint8_t file_memory[2][1 << 20];

static struct file load(const char *name, uint8_t *to, size_t size) {
    struct file file = { to, 0 };
    FILE *stream = fopen(name, "rb");
    if (stream == NULL) {
        fprintf(stderr, "%s cannot be opened\n", name);
        return file;
    }
    file.length = fread(to, 1, size, stream);
    fclose(stream);
    return file;
}
#endif

static trueaxis_position_t position(int32_t nm) {
#ifdef TRUEAXIS_SINGLE
    return nm;
#else
    return nm / 1e6;
#endif
}

static int32_t whole_nm(double mm) {
    double nm = mm * 1e6;
    return (int32_t)(nm < 0 ? nm - 0.5 : nm + 0.5);
}

/* Builds the loop, or prints the reason and builds one that passes commands uncorrected. */
static uint8_t build(int which, struct file file, uint32_t machine_id) {
    trueaxis_result_t result = trueaxis_check_abi(TRUEAXIS_ABI_VERSION);
    uint8_t reason = TRUEAXIS_FAULT_ABI_MISMATCH;
    if (result == TRUEAXIS_OK) {
        result = trueaxis_loop_build(&loops[which], sizeof loops[which], file.bytes, file.length, machine_id, PERIOD_NS,
                                     memory[which], sizeof memory[which], &error);
        if (result == TRUEAXIS_OK) {
            return TRUEAXIS_FAULT_NONE;
        }
        reason = result == TRUEAXIS_ERROR_MEMORY ? TRUEAXIS_FAULT_CAPACITY_TOO_SMALL : TRUEAXIS_FAULT_TABLES_REFUSED;
        printf("refused: result %" PRId32 ", code %" PRIu32 ": %s\n", result, error.code, error.text);
    } else {
        printf("refused: result %" PRId32 ", header %08" PRIx32 ", library %08" PRIx32 ": %s\n", result,
               (uint32_t)TRUEAXIS_ABI_VERSION, trueaxis_abi_version(), trueaxis_result_text(result));
    }
    result = trueaxis_loop_bypass(&loops[which], sizeof loops[which], AXES, reason, PERIOD_NS);
    if (result != TRUEAXIS_OK) {
        printf("no bypass: %s\n", trueaxis_result_text(result));
    }
    return reason;
}

static uint64_t fnv1a(uint64_t sum, const void *from, size_t size) {
    const uint8_t *bytes = from;
    for (size_t i = 0; i < size; ++i) {
        sum = (sum ^ bytes[i]) * UINT64_C(0x100000001b3);
    }
    return sum;
}

/* What the cycles add up to. */
struct totals {
    uint64_t drives, frames; /* FNV-1a of all bytes */
    uint32_t faults, frame_bytes;
    double worst_um, largest_um[AXES];
};

/* Starts the state of a loop and its path, a full circle. */
static int start(const trueaxis_loop_t *loop) {
    const double center[3] = CENTER_MM, up[3] = { 0, 0, 1 };
    const double from[3] = { center[0] + RADIUS_MM, center[1], center[2] };
    return trueaxis_path_start(&path, sizeof path, path_memory, sizeof path_memory, 0) == TRUEAXIS_OK &&
           trueaxis_path_arc(&path, from, from, center, up, 0, &error) == TRUEAXIS_OK &&
           trueaxis_path_close(&path) == TRUEAXIS_OK &&
           trueaxis_start(loop, &state, sizeof state, PERIOD_NS) == TRUEAXIS_OK;
}

static void add(struct totals *totals, const uint8_t *frame, size_t length) {
    totals->drives = fnv1a(totals->drives, output.drive, AXES * sizeof output.drive[0]);
    totals->frames = fnv1a(totals->frames, frame, length);
    totals->frame_bytes += (uint32_t)length;
    totals->faults += output.record.fault != TRUEAXIS_FAULT_NONE;
    if (output.record.has_dynamic) {
        for (int axis = 0; axis < AXES; ++axis) {
            const double sent = output.record.dynamic.sent[axis] * 1e3, size = sent < 0 ? -sent : sent;
            totals->largest_um[axis] = size > totals->largest_um[axis] ? size : totals->largest_um[axis];
        }
    }
    if (!(output.record.tip.flags & TRUEAXIS_CONTOUR_NOT_FOUND) && output.record.tip.error * 1e3 > totals->worst_um) {
        totals->worst_um = output.record.tip.error * 1e3;
    }
}

static void print(const struct totals *totals) {
    printf("cycles %" PRIu32 ", faults %" PRIu32 ", last fault %d, tables %08" PRIx32 "\n", output.record.sequence + 1,
           totals->faults, output.record.fault, output.record.tables_crc);
    for (int axis = 0; axis < AXES; ++axis) {
        printf("correction %c %.6f um\n", "XYZ"[axis], output.record.correction[axis] * 1e3);
    }
    for (int axis = 0; axis < AXES; ++axis) {
        printf("largest dynamic %c %.6f um\n", "XYZ"[axis], totals->largest_um[axis]);
    }
    printf("worst contour error %.6f um\n", totals->worst_um);
    /* Printed in halves: not every C library prints 64 bits. */
    printf("drives %08" PRIx32 "%08" PRIx32 "\n", (uint32_t)(totals->drives >> 32), (uint32_t)totals->drives);
    printf("frames %08" PRIx32 "%08" PRIx32 ", %" PRIu32 " bytes\n", (uint32_t)(totals->frames >> 32),
           (uint32_t)totals->frames, totals->frame_bytes);
}

static int run(struct file first, struct file second) {
    const double center[3] = CENTER_MM;
    info.size = sizeof info;
    error.size = sizeof error;
    input.size = sizeof input;
    output.size = sizeof output;

    const trueaxis_loop_t *active = &loops[0];
    const uint8_t refused = build(0, first, 0);
    if (refused == TRUEAXIS_FAULT_NONE) {
        if (trueaxis_tables_info(first.bytes, first.length, &info, &error) != TRUEAXIS_OK || info.axes != AXES ||
            build(1, second, info.machine_id) != TRUEAXIS_FAULT_NONE) {
            puts("two files of one machine with three axes are needed");
            return 1;
        }
        printf("machine %s, axes %s, tables %08" PRIx32 ", memory %" PRIu32 " bytes\n", info.name, info.letters,
               info.tables_crc, (uint32_t)info.memory_bytes);
    }
    if (!start(active)) {
        puts("path or state cannot be started");
        return 1;
    }

    /* cos and sin of a turn / 8000: almost one revolution in total. */
    const double turn[2] = { 0.9999996915748783, 0.0007853980826519387 };
    double phasor[2] = { RADIUS_MM, 0 };
    trueaxis_position_t lag[LAG_CYCLES][AXES];
    struct totals totals = { .drives = FNV1A_START, .frames = FNV1A_START };
    for (uint32_t cycle = 0; cycle < CYCLES; ++cycle) {
        const double at[AXES] = { center[0] + phasor[0], center[1] + phasor[1], center[2] };
        const uint32_t moved = cycle < REST ? 0 : cycle - REST;
        if (cycle >= REST) {
            const double x = phasor[0] * turn[0] - phasor[1] * turn[1];
            phasor[1] = phasor[0] * turn[1] + phasor[1] * turn[0];
            phasor[0] = x;
        }
        for (int axis = 0; axis < AXES; ++axis) {
            input.command[axis] = position(whole_nm(at[axis]));
            /* The machine follows its drives with a delay of some cycles. */
            input.feedback[axis] = cycle < LAG_CYCLES ? input.command[axis] : lag[cycle % LAG_CYCLES][axis];
        }
        input.homed = input.enable = 1;
        input.elapsed_ns = PERIOD_NS;
        input.encoder_alarm = cycle >= ALARM_AT && cycle < ALARM_AT + 5;
        if (cycle == EXCHANGE_AT && refused == TRUEAXIS_FAULT_NONE) {
            active = &loops[1];
        }
        /* Friction is off for a while, and X has a learned correction of 1 um. */
        input.dynamics_off = cycle >= SWITCH_AT && cycle < EXCHANGE_AT ? TRUEAXIS_DYNAMICS_FRICTION : 0;
        input.learned[0] = position(cycle >= SWITCH_AT ? 1000 : 0);
        trueaxis_measure_t measure = { .size = sizeof measure, .kind = TRUEAXIS_MEASURE_PATH, .path = &path };
        trueaxis_result_t result = trueaxis_path_reference(&path, 0, moved / 8000.0, &measure.reference);
        if (result == TRUEAXIS_OK) {
            result = trueaxis_step(active, &state, &input, &measure, NULL, &output);
        }
        uint8_t frame[TRUEAXIS_FRAME_BYTES];
        size_t length = 0;
        if (result == TRUEAXIS_OK) {
            result = trueaxis_frame_encode(&output, frame, sizeof frame, &length);
        }
        if (result != TRUEAXIS_OK) {
            printf("cycle %" PRIu32 ": %s\n", cycle, trueaxis_result_text(result));
            return 1;
        }
        for (int axis = 0; axis < AXES; ++axis) {
            lag[cycle % LAG_CYCLES][axis] = output.drive[axis];
        }
        add(&totals, frame, length);
        if (refused != TRUEAXIS_FAULT_NONE &&
            (output.record.fault != refused || memcmp(output.drive, input.command, sizeof output.drive) != 0)) {
            printf("cycle %" PRIu32 ": not passed as commanded, or without the reason\n", cycle);
            return 1;
        }
    }
    print(&totals);
    return 0;
}

#ifdef BARE_METAL
int main(void) {
    const struct file first = { tables_first, (size_t)(tables_first_end - tables_first) };
    const struct file second = { tables_second, (size_t)(tables_second_end - tables_second) };
    return run(first, second);
}
#else
int main(int count, char **arguments) {
    if (count != 3) {
        fputs("usage: step_trace FIRST.tcomp SECOND.tcomp\n", stderr);
        return 2;
    }
    return run(load(arguments[1], file_memory[0], sizeof file_memory[0]),
               load(arguments[2], file_memory[1], sizeof file_memory[1]));
}
#endif
