/* What the tests see of the double of the core beside grblHAL's own names. SPDX-License-Identifier: MIT OR Apache-2.0 */
#ifndef DOUBLE_TESTS_H
#define DOUBLE_TESTS_H

#include "grbl/kinematics/interface.h"

typedef struct {
    int32_t steps[N_AXIS]; /* of the motors, at the end */
    float feed_rate;
    bool inverse_time;
} block_t;

#define BLOCKS 4096
extern block_t blocks[BLOCKS]; /* all that were handed to the planner since `block_count` was last set to 0 */
extern unsigned block_count;
extern char told[2048];       /* all that was written since it was last cleared */
extern bool soft_limit_alarm; /* of the last line */
extern bool busy;             /* as if a block were under way */

extern unsigned core_sampling;         /* most steps between two rounds of the foreground loop */
extern void (*core_stepped)(void); /* after every step, in interrupt context */
extern void (*core_held)(void);    /* when the machine has stopped in a hold or is parked: the operator's turn */
extern bool (*core_touched)(void); /* the probe */

void core_start(void (*own_kinematics)(void));
void core_home(axes_signals_t cycle, bool success);
void core_state(sys_state_t state);
status_code_t core_command(const char *line);

/* Lines of a program and jogs, which are queued and executed later. */
status_code_t mc_line(float *target, plan_line_data_t *pl_data);
bool mc_arc(float *target, plan_line_data_t *pl_data, float *offset, float radius, int32_t turns); /* in the plane XY */
status_code_t core_line(const float *target, plan_line_data_t pl_data);
status_code_t core_jog(const float *target, plan_line_data_t pl_data);
bool core_probe(const float *target, plan_line_data_t pl_data);
void core_finish(void); /* until all is executed, or dropped */

/* After so many steps, the request comes: one of those below. */
void core_interrupt(unsigned steps, void (*request)(void));
void core_jog_cancel(void);
void core_feed_hold(void);
void core_door(void);
void core_stop(void);
void core_cycle_start(void);
void core_reset(void);

void my_plugin_init(void);

#endif
