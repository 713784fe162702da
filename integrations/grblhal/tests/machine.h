/* The tests' controller: a mill of 300 x 200 x 400 mm in grblHAL's machine coordinates. SPDX-License-Identifier: MIT OR Apache-2.0 */
#ifndef TESTS_MACHINE_H
#define TESTS_MACHINE_H

#include "core.h"

static inline void machine(float steps_per_mm) {
    static const float travel[N_AXIS] = { -300.0f, -200.0f, -400.0f };
    for (int idx = 0; idx < N_AXIS; idx++) {
        settings.axis[idx].steps_per_mm = steps_per_mm;
        settings.axis[idx].max_travel = travel[idx];
    }
    settings.homing.dir_mask.mask = 7; /* switches at the negative ends */
    settings.arc_tolerance = 0.002f;
    sys.soft_limits.mask = 7;
}

/* Sets the position of axes homed at their switches, without a pull-off. */
static inline void at_switches(axes_signals_t cycle) {
    for (int idx = 0; idx < N_AXIS; idx++) {
        if (cycle.mask & bit(idx)) {
            sys.home_position[idx] = settings.axis[idx].max_travel;
            sys.position[idx] = (int32_t)(settings.axis[idx].max_travel * settings.axis[idx].steps_per_mm);
        }
    }
}

/* Queues a line. */
static inline bool queue_to(float x, float y, float z, plan_line_data_t pl_data) {
    float target[N_AXIS] = { x, y, z };
    if (!pl_data.feed_rate) {
        pl_data.feed_rate = 600.0f;
    }
    return core_line(target, pl_data) != Status_Aborted;
}

/* Executes a line. */
static inline bool line_to(float x, float y, float z, plan_line_data_t pl_data) {
    block_count = 0;
    bool done = queue_to(x, y, z, pl_data);
    core_finish();
    return done;
}

#endif
