/* SPDX-License-Identifier: MIT OR Apache-2.0 */
#include "trueaxis_correction.h"

#include <math.h>
#include <string.h>

#define PERIOD_NS 1000000 /* of no effect on a correction at a position, but a loop has one */
#define PASSES 8
#define LATTICE 3         /* places on each axis where the search for the largest correction begins */
#define LINE 32           /* the least of places on a line of the search */
#define ROWS 256          /* the most of places on a line where a table has more rows */
#define SWEEPS 4          /* of the search over all axes */
#define MISSED_MM 0.001f  /* by the search */

#ifdef TRUEAXIS_SINGLE
#define TOLERANCE 1 /* nm */
#else
#define TOLERANCE 1e-6 /* mm */
#endif

static struct {
    trueaxis_loop_t loop;
    trueaxis_tables_info_t info;
    trueaxis_error_t error;
    trueaxis_position_t low[TRUEAXIS_AXES_MAX], high[TRUEAXIS_AXES_MAX];
    trueaxis_real_t limit[TRUEAXIS_AXES_MAX];
    trueaxis_real_t largest[TRUEAXIS_AXES_MAX];
    uint8_t axis[TRUEAXIS_AXES_MAX];
} tables;
static uint64_t memory[TRUEAXIS_MEMORY_BYTES / sizeof(uint64_t)];

static trueaxis_position_t clamp(trueaxis_position_t value, trueaxis_position_t low, trueaxis_position_t high) {
    return value < low ? low : value > high ? high : value;
}

#ifdef TRUEAXIS_SINGLE
#define RANGE_MM 2147.0f /* of an int32 in nm */

/* A value that is out of range or NaN becomes the end of the range, for a lookup only. */
static trueaxis_position_t to_position(float mm) {
    if (!(mm > -RANGE_MM)) {
        return -2147000000;
    }
    if (mm > RANGE_MM) {
        return 2147000000;
    }
    /* Whole millimetres are converted separately: a single product would be rounded to 24 bits. */
    int32_t whole = (int32_t)mm;
    return whole * 1000000 + (int32_t)lroundf((mm - (float)whole) * 1e6f);
}
static float from_position(trueaxis_position_t nm) {
    int32_t whole = nm / 1000000;
    return (float)whole + (float)(nm - whole * 1000000) * 1e-6f;
}
static trueaxis_position_t added(trueaxis_real_t mm) {
    return (trueaxis_position_t)lroundf(mm * 1e6f);
}
#else
#define RANGE_MM 1e9f

static trueaxis_position_t to_position(float mm) {
    return mm;
}
static float from_position(trueaxis_position_t mm) {
    return (float)mm;
}
static trueaxis_position_t added(trueaxis_real_t mm) {
    return mm;
}
#endif

const trueaxis_tables_info_t *trueaxis_correction_tables(void) {
    return &tables.info;
}

unsigned trueaxis_correction_axis(unsigned slot) {
    return tables.axis[slot];
}

uint8_t trueaxis_correction_axes(void) {
    uint8_t bits = 0;
    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        bits |= (uint8_t)(1u << tables.axis[slot]);
    }
    return bits;
}

/* c at `from`, in the tables' order. */
static void correction(const trueaxis_position_t *from, uint8_t negative, trueaxis_real_t *c) {
    trueaxis_position_t inside[TRUEAXIS_AXES_MAX];
    uint8_t directions = 0;

    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        inside[slot] = clamp(from[slot], tables.low[slot], tables.high[slot]);
        directions |= (uint8_t)((negative >> tables.axis[slot] & 1) << slot);
    }
    /* This refuses only positions outside the travel or NaN, which cannot occur here. */
    if (trueaxis_correction_at(&tables.loop, inside, directions, NULL, c) != TRUEAXIS_OK) {
        memset(c, 0, tables.info.axes * sizeof *c);
    }
    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        if (c[slot] > tables.limit[slot]) {
            c[slot] = tables.limit[slot];
        } else if (c[slot] < -tables.limit[slot]) {
            c[slot] = -tables.limit[slot];
        }
    }
}

/* The larger of the corrections of `slot` in both directions, at fractions of the travels. */
static trueaxis_real_t size_at(const float *share, unsigned slot) {
    trueaxis_position_t at[TRUEAXIS_AXES_MAX];
    trueaxis_real_t plus[TRUEAXIS_AXES_MAX], minus[TRUEAXIS_AXES_MAX];

    for (uint32_t i = 0; i < tables.info.axes; i++) {
        float low = (float)tables.info.travel_low[i], high = (float)tables.info.travel_high[i];
        at[i] = to_position(low + (high - low) * share[i]);
    }
    correction(at, 0, plus);
    correction(at, UINT8_MAX, minus);
    trueaxis_real_t a = plus[slot] < 0 ? -plus[slot] : plus[slot], b = minus[slot] < 0 ? -minus[slot] : minus[slot];
    return a > b ? a : b;
}

/* Searches along lines of the travel, each through the best point so far, starting from points along the diagonal. The
 * lines pass through the rows of an evenly spaced table; for other tables the pitch is halved around the best point. */
static void find_largest(void) {
    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        trueaxis_real_t most = 0;
        for (unsigned start = 0; start < LATTICE; start++) {
            float best[TRUEAXIS_AXES_MAX], share[TRUEAXIS_AXES_MAX];
            trueaxis_real_t found = -1;
            for (uint32_t i = 0; i < tables.info.axes; i++) {
                best[i] = (float)start / (LATTICE - 1);
            }
            bool better = true;
            for (unsigned sweep = 0; better && sweep < SWEEPS; sweep++) {
                better = false;
                for (uint32_t i = 0; i < tables.info.axes; i++) {
                    uint32_t rows = tables.info.rows[i] > 1 ? tables.info.rows[i] - 1 : 1;
                    rows = rows < ROWS ? rows : ROWS;
                    uint32_t places = rows * ((LINE + rows - 1) / rows);
                    float pitch = 1.0f / (float)places;
                    memcpy(share, best, sizeof share);
                    for (uint32_t place = 0; place <= places; place++) {
                        share[i] = (float)place * pitch;
                        trueaxis_real_t size = size_at(share, slot);
                        if (size > found) {
                            found = size;
                            best[i] = share[i];
                            better = true;
                        }
                    }
                    for (int halving = 0; halving < 16; halving++) {
                        /* Both sides of the best point, then half the pitch. */
                        pitch = halving & 1 ? -pitch : -0.5f * pitch;
                        share[i] = best[i] + pitch;
                        trueaxis_real_t size = share[i] >= 0 && share[i] <= 1 ? size_at(share, slot) : 0;
                        if (size > found) {
                            found = size;
                            best[i] = share[i];
                            better = true;
                        }
                    }
                }
            }
            most = found > most ? found : most;
        }
        tables.largest[slot] = most;
    }
}

float trueaxis_correction_largest(unsigned slot) {
    return (float)tables.largest[slot] + MISSED_MM;
}

const char *trueaxis_correction_load(const uint8_t *file, size_t length, uint32_t machine_id, unsigned axes) {
    static const char letters[] = "XYZABC";

    tables.error = (trueaxis_error_t){ .size = sizeof tables.error };
    tables.info = (trueaxis_tables_info_t){ .size = sizeof tables.info };
    if (trueaxis_check_abi(TRUEAXIS_ABI_VERSION) != TRUEAXIS_OK) {
        return "header and library differ in version or precision";
    }
    if (trueaxis_tables_info(file, length, &tables.info, &tables.error) != TRUEAXIS_OK) {
        return tables.error.text;
    }
    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        const char *letter = strchr(letters, tables.info.letters[slot]);
        tables.axis[slot] = letter ? (uint8_t)(letter - letters) : UINT8_MAX;
        if (tables.axis[slot] >= axes) {
            strcpy(tables.error.text, "the tables are for axes ");
            strcat(tables.error.text, tables.info.letters);
            strcat(tables.error.text, ", the controller has ");
            strncat(tables.error.text, letters, axes);
            return tables.error.text;
        }
        tables.low[slot] = to_position((float)tables.info.travel_low[slot]);
        tables.high[slot] = to_position((float)tables.info.travel_high[slot]);
        tables.limit[slot] = (trueaxis_real_t)tables.info.correction_limit[slot];
    }
    trueaxis_result_t built = trueaxis_loop_build(&tables.loop, sizeof tables.loop, file, length, machine_id, PERIOD_NS,
                                                  memory, sizeof memory, &tables.error);
    if (built != TRUEAXIS_OK) {
        return tables.error.text;
    }
    find_largest();
    return NULL;
}

/* Positions of the tables' axes, in their order. */
static void gather(const float *positions, trueaxis_position_t *to) {
    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        to[slot] = to_position(positions[tables.axis[slot]]);
    }
}

void trueaxis_correction_forward(const float *command, uint8_t negative, float *drive) {
    trueaxis_position_t from[TRUEAXIS_AXES_MAX];
    trueaxis_real_t c[TRUEAXIS_AXES_MAX];

    gather(command, from);
    correction(from, negative, c);
    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        unsigned axis = tables.axis[slot];
        /* Far outside any travel, or NaN: add in the host's floats, with the correction at the edge. */
        drive[axis] = fabsf(command[axis]) < RANGE_MM ? from_position(from[slot] + added(c[slot])) : command[axis] + c[slot];
    }
}

void trueaxis_correction_inverse(const float *drive, uint8_t negative, float *command) {
    trueaxis_position_t from[TRUEAXIS_AXES_MAX], found[TRUEAXIS_AXES_MAX];
    trueaxis_real_t c[TRUEAXIS_AXES_MAX];
    bool settled = false;

    gather(drive, from);
    memcpy(found, from, sizeof found);
    for (int pass = 0; pass < PASSES && !settled; pass++) {
        settled = true;
        correction(found, negative, c);
        for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
            trueaxis_position_t next = from[slot] - added(c[slot]), change = next - found[slot];
            settled = settled && change <= TOLERANCE && change >= -TOLERANCE;
            found[slot] = next;
        }
    }
    for (uint32_t slot = 0; slot < tables.info.axes; slot++) {
        command[tables.axis[slot]] = from_position(found[slot]);
    }
}
