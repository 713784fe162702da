/*
 * Cartesian kinematics, for a core without kinematics.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#include <math.h>
#include <string.h>

#include "trueaxis_kinematics.h"

void trueaxis_validate(const coord_data_t *target, plan_line_data_t *pl_data) {
    if (!pl_data->condition.target_validated) {
        coord_data_t end = *target;
        pl_data->condition.target_validated = On;
        pl_data->condition.target_valid = grbl.check_travel_limits(end.values, sys.soft_limits, true, &sys.work_envelope);
    }
}

static coord_data_t *cartesian_from_steps(coord_data_t *position, mpos_t *steps) {
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        position->values[idx] = (float)steps->values[idx] / settings.axis[idx].steps_per_mm;
    }
    return position;
}

static coord_data_t *cartesian_to_motors(coord_data_t *target, coord_data_t *position) {
    return memcpy(target, position, sizeof *target);
}

static coord_data_t *cartesian_line(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init) {
    static coord_data_t end;
    static bool handed;

    (void)position;
    if (init) {
        trueaxis_validate(target, pl_data);
        end = *target;
        handed = false;
        return &end;
    }
    return handed ? NULL : (handed = true, &end);
}

static uint_fast8_t cartesian_axis_mask(uint_fast8_t idx) {
    return bit(idx);
}

static void cartesian_homing_start(uint_fast8_t idx) {
    sys.position[idx] = 0;
}

/* The core has a function for this, but omits it if built with KINEMATICS_API. */
static void cartesian_homed(axes_signals_t cycle) {
    const coord_data_t *pulloff = limits_homing_pulloff(NULL);

    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        if (!(cycle.mask & bit(idx))) {
            continue;
        }
        float home = 0.0f;
        if (!settings.homing.flags.force_set_origin) {
            bool low = settings.homing.dir_mask.mask & bit(idx);
            home = low ? settings.axis[idx].max_travel + pulloff->values[idx] : -pulloff->values[idx];
        }
        sys.home_position[idx] = home;
        sys.position[idx] = (int32_t)lroundf(home * settings.axis[idx].steps_per_mm);
    }
}

static bool cartesian_homing_valid(axes_signals_t cycle) {
    (void)cycle;
    return true;
}

static float cartesian_homing_rate(axes_signals_t cycle, float rate, homing_mode_t mode) {
    (void)cycle, (void)mode;
    return rate;
}

kinematics_t trueaxis_cartesian(void) {
    return (kinematics_t){
        .transform_steps_to_cartesian = cartesian_from_steps,
        .transform_from_cartesian = cartesian_to_motors,
        .segment_line = cartesian_line,
        .limits_get_axis_mask = cartesian_axis_mask,
        .limits_set_target_pos = cartesian_homing_start,
        .limits_set_machine_positions = cartesian_homed,
        .homing_cycle_validate = cartesian_homing_valid,
        .homing_cycle_get_feedrate = cartesian_homing_rate,
    };
}
