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
extern block_t blocks[BLOCKS];
extern unsigned block_count;
extern char told[2048];       /* all that was written since it was last cleared */
extern bool soft_limit_alarm; /* of the last line */
extern bool busy;             /* a block is under way */

void core_start(void (*own_kinematics)(void));
bool mc_line(float *target, plan_line_data_t *pl_data);
void core_home(axes_signals_t cycle, bool success);
void core_state(sys_state_t state);
status_code_t core_command(const char *line);
void my_plugin_init(void);

#endif
