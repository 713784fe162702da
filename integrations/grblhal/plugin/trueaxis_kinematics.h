/*
 * Declarations shared by the parts of the plugin.
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

/* At M850 and M851, RTCP_AC replaces `segment_line` and `transform_steps_to_cartesian`, and the plugin's hooks with them. */
#if RTCP_AC
#error "trueaxis cannot wrap RTCP_AC: M850 and M851 would take the correction off. Build without RTCP_AC."
#endif

#ifndef TRUEAXIS_HYSTERESIS_MM
#define TRUEAXIS_HYSTERESIS_MM 0.0003f /* a drive that comes back by more has turned */
#endif

/* Side of its lost motion on which each drive is. */
typedef struct {
    uint8_t negative;      /* bits of the drives whose last motion was in their negative direction */
    coord_data_t furthest; /* extreme position of each drive in its direction */
} trueaxis_sides_t;

typedef struct {
    kinematics_t present;      /* the kinematics below: the core's, or Cartesian */
    bool correcting;           /* changes only when the position is taken over from the steps, never within a line */
    trueaxis_sides_t planned;  /* at the end of the planner's last target */
    trueaxis_sides_t executed; /* from the steps taken */
    coord_data_t last;         /* end of the last line, machine coordinates */
    mpos_t sent;               /* motors: the last point passed to the planner */
    volatile bool jog_cancelled;
} trueaxis_shared_t;
extern trueaxis_shared_t trueaxis_shared;

/* Cartesian hooks, for a core without kinematics. */
kinematics_t trueaxis_cartesian(void);

/* Makes the core check the end of a line before it sees motor positions. Otherwise motor positions, or a correction of
 * micrometres, would make it refuse a line up to the limit. */
void trueaxis_validate(const coord_data_t *target, plan_line_data_t *pl_data);

/* The hook `segment_line`: bends lines so that the tool follows them. */
coord_data_t *trueaxis_segment_line(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init);

/* Ends a line that is being passed to the planner, if the core has dropped its queue. */
void trueaxis_line_dropped(void);

/* The planner's position, in motor steps. */
mpos_t trueaxis_planner_steps(void);

bool trueaxis_same_steps(const int32_t *a, const int32_t *b);

/* Follows the drives to the steps taken. Call it often while they move. */
void trueaxis_follow(void);

/* Starts following from the present steps, each drive on the side given by its bit. */
void trueaxis_follow_from_here(uint8_t negative);

/* Positions of the drives, and of the tool, from the steps taken. */
void trueaxis_drives(coord_data_t *drive);
void trueaxis_tool(coord_data_t *tool);

/* The program's position: the tool's, or the program's own value if the two differ only by rounding to steps and the
 * hysteresis. If it were read again at every stop, an uncommanded axis would drift. */
void trueaxis_program(coord_data_t *position);

/* Position of the tool at which the probe triggered. */
void trueaxis_probed(coord_data_t *tool);

/* Makes the planner restart at the drives' position. */
void trueaxis_take_over(void);

#endif
