/* The double's interface for the tests, in addition to grblHAL's own names.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#ifndef DOUBLE_TESTS_H
#define DOUBLE_TESTS_H

#include "grbl/kinematics/interface.h"

typedef struct {
    int32_t steps[N_AXIS]; /* motor positions at the end of the block */
    float feed_rate;
    bool inverse_time;
} block_t;

#ifndef BLOCKS
#define BLOCKS 4096
#endif
extern block_t blocks[BLOCKS]; /* all that were passed to the planner since `block_count` was last set to 0 */
extern unsigned block_count;
extern char told[2048];       /* all text written since it was last cleared */
extern bool soft_limit_alarm; /* result for the last line */
extern bool busy;             /* acts as if a block were being executed */

extern unsigned core_sampling;         /* largest number of steps between two passes of the foreground loop */
extern void (*core_stepped)(void); /* called after every step, in interrupt context */
extern void (*core_held)(void);    /* called at the stop in a hold or when parked: the operator's turn */
extern bool (*core_touched)(void); /* state of the probe */

void core_start(void (*own_kinematics)(void));
void core_home(axes_signals_t cycle, bool success);
void core_state(sys_state_t state);
status_code_t core_command(const char *line);

/* Lines of a program, and jogs; they are queued and executed later. */
status_code_t mc_line(float *target, plan_line_data_t *pl_data);
bool mc_arc(float *target, plan_line_data_t *pl_data, float *offset, float radius, int32_t turns); /* in the plane XY */
status_code_t core_line(const float *target, plan_line_data_t pl_data);
status_code_t core_jog(const float *target, plan_line_data_t pl_data);
bool core_probe(const float *target, plan_line_data_t pl_data);
void core_finish(void); /* returns when everything has been executed or dropped */

/* Issues the request, one of those below, after `steps` steps. */
void core_interrupt(unsigned steps, void (*request)(void));
void core_jog_cancel(void);
void core_feed_hold(void);
void core_door(void);
void core_stop(void);
void core_cycle_start(void);
void core_reset(void);

void my_plugin_init(void);

#endif
