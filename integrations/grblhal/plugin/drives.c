/*
 * Positions of the drives, from the steps taken and not from the plan, because the core may drop its queue at any time. A
 * drive that turns first takes up its lost motion while the tool is at rest.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#include <math.h>
#include <string.h>

#include "trueaxis_kinematics.h"

static struct {
    mpos_t steps, probe_steps; /* the latest that were followed */
    coord_data_t drive;        /* at `steps` */
    coord_data_t probe_drive;  /* with `probe_negative`, puts the tool where the probe triggered */
    uint8_t probe_negative;
} followed;

bool trueaxis_same_steps(const int32_t *a, const int32_t *b) {
    return !memcmp(a, b, N_AXIS * sizeof *a);
}

static float back_from(const trueaxis_sides_t *sides, const coord_data_t *drive, uint_fast8_t idx) {
    float back = sides->furthest.values[idx] - drive->values[idx];
    return sides->negative & bit(idx) ? -back : back;
}

/* Moves the drives to `drive`. A drive has turned once it has moved back by more than its lost motion at that
 * position. */
static void advance(trueaxis_sides_t *sides, const coord_data_t *drive) {
    coord_data_t plus, minus;
    bool looked_up = false;

    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        float back = back_from(sides, drive, idx);
        if (back <= 0.0f) {
            sides->furthest.values[idx] = drive->values[idx];
        } else if (back > TRUEAXIS_HYSTERESIS_MM) {
            if (!looked_up) {
                trueaxis_correction_forward(drive->values, 0, plus.values);
                trueaxis_correction_forward(drive->values, UINT8_MAX, minus.values);
                looked_up = true;
            }
            if (back > plus.values[idx] - minus.values[idx]) {
                sides->negative ^= (uint8_t)bit(idx);
                sides->furthest.values[idx] = drive->values[idx];
            }
        }
    }
}

/* While a drive takes up its lost motion, the tool remains where it was when the drive turned. */
static void holding(const trueaxis_sides_t *sides, const coord_data_t *drive, coord_data_t *held) {
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        held->values[idx] = back_from(sides, drive, idx) > 0.0f ? sides->furthest.values[idx] : drive->values[idx];
    }
}

void trueaxis_follow(void) {
    mpos_t steps, probe_steps;
    coord_data_t probe_drive;

    memcpy(probe_steps.values, sys.probe_position, sizeof probe_steps.values);
    memcpy(steps.values, sys.position, sizeof steps.values);
    if (!trueaxis_same_steps(probe_steps.values, followed.probe_steps.values)) {
        /* The drives passed the probe's position after they were last followed. */
        trueaxis_sides_t sides = trueaxis_shared.executed;
        followed.probe_steps = probe_steps;
        trueaxis_shared.present.transform_steps_to_cartesian(&probe_drive, &probe_steps);
        advance(&sides, &probe_drive);
        holding(&sides, &probe_drive, &followed.probe_drive);
        followed.probe_negative = sides.negative;
    }
    if (!trueaxis_same_steps(steps.values, followed.steps.values)) {
        followed.steps = steps;
        trueaxis_shared.present.transform_steps_to_cartesian(&followed.drive, &steps);
        advance(&trueaxis_shared.executed, &followed.drive);
    }
}

void trueaxis_follow_from_here(uint8_t negative) {
    memcpy(followed.steps.values, sys.position, sizeof followed.steps.values);
    trueaxis_shared.present.transform_steps_to_cartesian(&followed.drive, &followed.steps);
    trueaxis_shared.executed.negative = negative;
    trueaxis_shared.executed.furthest = followed.drive;
}

void trueaxis_drives(coord_data_t *drive) {
    *drive = followed.drive;
}

void trueaxis_tool(coord_data_t *tool) {
    holding(&trueaxis_shared.executed, &followed.drive, tool);
    trueaxis_correction_inverse(tool->values, trueaxis_shared.executed.negative, tool->values);
}

void trueaxis_program(coord_data_t *position) {
    trueaxis_tool(position);
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        /* Within a block, its rounded ends and its own steps together deviate by up to one step. */
        float off = fabsf(position->values[idx] - trueaxis_shared.last.values[idx]);
        if (off < 1.0f / settings.axis[idx].steps_per_mm + TRUEAXIS_HYSTERESIS_MM) {
            position->values[idx] = trueaxis_shared.last.values[idx];
        }
    }
}

void trueaxis_probed(coord_data_t *tool) {
    *tool = followed.probe_drive;
    trueaxis_correction_inverse(tool->values, followed.probe_negative, tool->values);
}

void trueaxis_take_over(void) {
    trueaxis_program(&trueaxis_shared.last);
    trueaxis_shared.planned = trueaxis_shared.executed;
    trueaxis_shared.sent = followed.steps;
}
