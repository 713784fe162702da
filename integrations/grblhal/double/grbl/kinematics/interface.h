/* The hooks of grblHAL's kinematics. SPDX-License-Identifier: MIT OR Apache-2.0 */
#ifndef DOUBLE_INTERFACE_H
#define DOUBLE_INTERFACE_H

#include "../core.h"

typedef struct {
    /* Motor steps to machine coordinates. */
    coord_data_t *(*transform_steps_to_cartesian)(coord_data_t *position, mpos_t *steps);
    /* Machine coordinates to motor positions. */
    coord_data_t *(*transform_from_cartesian)(coord_data_t *target, coord_data_t *position);
    /* With `init`, begins a line to `target` (machine coordinates) from `position` (motors) and returns the motor position
     * of its end. Later calls return the motor positions along the line, in the same storage, and finally NULL. */
    coord_data_t *(*segment_line)(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init);
    /* Motors that move while an axis is homed. */
    uint_fast8_t (*limits_get_axis_mask)(uint_fast8_t idx);
    /* Sets the motor position from which a homing move of the axis starts. */
    void (*limits_set_target_pos)(uint_fast8_t idx);
    /* Sets the motor positions of homed axes. */
    void (*limits_set_machine_positions)(axes_signals_t cycle);
    /* Whether these axes may be homed together. */
    bool (*homing_cycle_validate)(axes_signals_t cycle);
    /* Feed of the motors for a feed of the axes. */
    float (*homing_cycle_get_feedrate)(axes_signals_t axes, float rate, homing_mode_t mode);
} kinematics_t;

extern kinematics_t kinematics;

#endif
