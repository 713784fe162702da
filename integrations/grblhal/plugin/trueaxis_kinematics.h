/*
 * What the parts of the plugin share.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#ifndef TRUEAXIS_KINEMATICS_H
#define TRUEAXIS_KINEMATICS_H

#include "grbl/hal.h"

#include "grbl/gcode.h"
#include "grbl/machine_limits.h"
#include "grbl/planner.h"
#include "grbl/state_machine.h"
#include "grbl/task.h"

#include "grbl/kinematics/interface.h"

#include "trueaxis_correction.h"

typedef struct {
    kinematics_t present;  /* the kinematics below: the core's, or cartesian */
    bool correcting;       /* changes only with the position taken over from the steps, and never amid a line */
    uint8_t negative;      /* bits of the drives that last moved in their negative direction */
    coord_data_t furthest; /* where each drive came to in its direction */
    coord_data_t last;     /* end of the last line, machine coordinates */
    volatile bool jog_cancelled;
} trueaxis_shared_t;
extern trueaxis_shared_t trueaxis_shared;

/* Cartesian hooks, for a core that has none. */
kinematics_t trueaxis_cartesian(void);

/* Has the core check the end of a line before it sees motor positions: neither those nor a correction of micrometres refuse
   a line to the very limit. */
void trueaxis_validate(const coord_data_t *target, plan_line_data_t *pl_data);

/* The hook of that name: lines bent so that the tool follows them. */
coord_data_t *trueaxis_segment_line(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init);

#endif
