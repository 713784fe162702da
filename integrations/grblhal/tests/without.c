/* A firmware without the plugin, for a comparison of sizes.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#include "machine.h"

static void nothing(void *data) {
    (void)data;
}

static coord_data_t *position(coord_data_t *to, mpos_t *steps) {
    (void)steps;
    return to;
}

static coord_data_t *line(coord_data_t *target, coord_data_t *from, plan_line_data_t *pl_data, bool init) {
    (void)from, (void)pl_data;
    return init ? target : NULL;
}

static void start_of(uint_fast8_t idx) {
    sys.position[idx] = 0;
}

static coord_data_t *motors(coord_data_t *target, coord_data_t *from) {
    *target = *from;
    return target;
}

void my_plugin_init(void) {
    kinematics = (kinematics_t){ .transform_steps_to_cartesian = position,
                                 .transform_from_cartesian = motors,
                                 .segment_line = line,
                                 .limits_set_target_pos = start_of,
                                 .limits_set_machine_positions = at_switches };
    task_run_on_startup(nothing, NULL);
}
