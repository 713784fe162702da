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
#include "grbl/stepper.h"
#include "grbl/task.h"

#include "grbl/kinematics/interface.h"

#include "trueaxis_correction.h"

/* It replaces `segment_line` and `transform_steps_to_cartesian` at M850 and M851, and ours with them. */
#if RTCP_AC
#error "trueaxis cannot wrap RTCP_AC: M850 and M851 would take the correction off. Build without RTCP_AC."
#endif

#ifndef TRUEAXIS_HYSTERESIS_MM
#define TRUEAXIS_HYSTERESIS_MM 0.0003f /* a drive that comes back by more has turned */
#endif

/* Which side of their lost motion the drives are on. */
typedef struct {
    uint8_t negative;      /* bits of the drives that last moved in their negative direction */
    coord_data_t furthest; /* how far each drive came in its direction */
} trueaxis_sides_t;

typedef struct {
    kinematics_t present;      /* the kinematics below: the core's, or cartesian */
    bool correcting;           /* changes only with the position taken over from the steps, and never amid a line */
    trueaxis_sides_t planned;  /* at the end of the planner's last target */
    trueaxis_sides_t executed; /* by the steps that were taken */
    coord_data_t last;         /* end of the last line, machine coordinates */
    mpos_t sent;               /* motors: the last point that the planner was handed */
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

/* Ends a line that is being handed to the planner, if the core has dropped its queue. */
void trueaxis_line_dropped(void);

/* The planner's position, steps of the motors. */
mpos_t trueaxis_planner_steps(void);

bool trueaxis_same_steps(const int32_t *a, const int32_t *b);

/* Follows the drives to the steps that have been taken. To be called often while they move. */
void trueaxis_follow(void);

/* Starts to follow from the steps as they are, each drive on the side of its bit. */
void trueaxis_follow_from_here(uint8_t negative);

/* Position of the drives by the steps taken, and of the tool. */
void trueaxis_drives(coord_data_t *drive);
void trueaxis_tool(coord_data_t *tool);

/* The program's position: the tool's, and the program's own figure where rounding to steps and the hysteresis make the
   difference. Read anew at every stop, an axis that is not commanded would walk. */
void trueaxis_program(coord_data_t *position);

/* Position of the tool where the probe triggered. */
void trueaxis_probed(coord_data_t *tool);

/* The planner restarts at the drives' position. */
void trueaxis_take_over(void);

#endif
