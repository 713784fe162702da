/*
 * A double of grblHAL's core around its kinematics hooks: starts, homes, takes lines to a planner that rounds them to
 * steps and executes them at once. Behaviour from the core's documentation and public source, no line of it.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */
#include "core.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

kinematics_t kinematics;
settings_t settings;
system_t sys;
parser_state_t gc_state;
grbl_t grbl;
grbl_hal_t hal;

block_t blocks[BLOCKS];
unsigned block_count;
char told[2048];
bool soft_limit_alarm, busy;

static int32_t planned[N_AXIS];
static sys_state_t state;
static sys_commands_t *registered;
static foreground_task_ptr startup;
static void *startup_data;

static void write(const char *text) {
    strncat(told, text, sizeof told - strlen(told) - 1);
}

static void no_options(bool newopt) {
    (void)newopt;
}

/* Motor coordinates cannot be checked here: the core answers "outside". */
static bool within(float *target, axes_signals_t axes, bool is_cartesian, work_envelope_t *envelope) {
    for (int idx = 0; idx < N_AXIS && is_cartesian; idx++) {
        if ((sys.homed.mask & axes.mask & bit(idx)) &&
            (target[idx] < envelope->min.values[idx] || target[idx] > envelope->max.values[idx])) {
            return false;
        }
    }
    return is_cartesian;
}

void system_register_commands(sys_commands_t *commands) {
    registered = commands;
}

bool task_run_on_startup(foreground_task_ptr fn, void *data) {
    startup = fn;
    startup_data = data;
    return true;
}

sys_state_t state_get(void) {
    return state;
}

void core_state(sys_state_t next) {
    state = next;
    if (grbl.on_state_change) {
        grbl.on_state_change(next);
    }
}

void report_message(const char *text, message_type_t type) {
    write(type == Message_Warning ? "[MSG:Warning: " : type == Message_Info ? "[MSG:Info: " : "[MSG:");
    write(text);
    write("]" ASCII_EOL);
}

void report_plugin(const char *name, const char *version) {
    write("[PLUGIN:");
    write(name);
    write(" v");
    write(version);
    write("]" ASCII_EOL);
}

char *ftoa(float value, uint8_t decimals) {
    static char text[24];
    snprintf(text, sizeof text, "%.*f", decimals, (double)value);
    return text;
}

void system_convert_array_steps_to_mpos(float *position, int32_t *steps) {
    coord_data_t found;
    mpos_t from;
    memcpy(from.values, steps, sizeof from.values);
    kinematics.transform_steps_to_cartesian(&found, &from);
    memcpy(position, found.values, sizeof found.values);
}

plan_block_t *plan_get_current_block(void) {
    return busy ? (plan_block_t *)blocks : NULL;
}

float *plan_get_position(void) {
    static float position[N_AXIS];
    for (int idx = 0; idx < N_AXIS; idx++) {
        position[idx] = (float)planned[idx] / settings.axis[idx].steps_per_mm;
    }
    return position;
}

void plan_sync_position(void) {
    memcpy(planned, sys.position, sizeof planned);
}

/* False where nothing is to be moved. */
static bool plan_buffer_line(const float *target, const plan_line_data_t *pl_data) {
    bool moves = false;
    for (int idx = 0; idx < N_AXIS; idx++) {
        int32_t steps = (int32_t)lroundf(target[idx] * settings.axis[idx].steps_per_mm);
        moves = moves || steps != planned[idx];
        planned[idx] = steps;
    }
    if (moves && block_count < BLOCKS) {
        block_t *block = &blocks[block_count++];
        memcpy(block->steps, planned, sizeof planned);
        block->feed_rate = pl_data->feed_rate;
        block->inverse_time = pl_data->condition.inverse_time;
    }
    memcpy(sys.position, planned, sizeof planned);
    return moves;
}

bool mc_line(float *target, plan_line_data_t *pl_data) {
    float feed_rate = pl_data->feed_rate;
    coord_data_t end;
    memcpy(end.values, target, sizeof end.values);

    pl_data->rate_multiplier = 1.0f;
    float *point = kinematics.segment_line(&end, (coord_data_t *)plan_get_position(), pl_data, true)->values;
    soft_limit_alarm = pl_data->condition.target_validated
                           ? !pl_data->condition.target_valid
                           : !grbl.check_travel_limits(point, sys.soft_limits, false, &sys.work_envelope);
    if (soft_limit_alarm) {
        return false;
    }
    /* The same storage throughout, and the feed as programmed after every block. */
    while (kinematics.segment_line((coord_data_t *)point, NULL, pl_data, false)) {
        plan_buffer_line(point, pl_data);
        pl_data->feed_rate = feed_rate;
    }
    memcpy(gc_state.position, target, sizeof gc_state.position);
    return true;
}

coord_data_t *limits_homing_pulloff(coord_data_t *distance) {
    static coord_data_t pulloff;
    if (distance) {
        pulloff = *distance;
    }
    return &pulloff;
}

void core_home(axes_signals_t cycle, bool success) {
    sys.homed.mask &= (uint8_t)~cycle.mask;
    core_state(STATE_HOMING);
    for (int idx = 0; idx < N_AXIS; idx++) {
        if (cycle.mask & bit(idx)) {
            /* A move towards the switch and beyond; the others stay where they are. */
            coord_data_t target, motors;
            plan_line_data_t pl_data = { .feed_rate = 500.0f };
            system_convert_array_steps_to_mpos(target.values, sys.position);
            kinematics.limits_set_target_pos((uint_fast8_t)idx);
            target.values[idx] = 1.5f * settings.axis[idx].max_travel;
            plan_buffer_line(kinematics.transform_from_cartesian(&motors, &target)->values, &pl_data);
        }
    }
    if (success) {
        kinematics.limits_set_machine_positions(cycle);
        sys.homed.mask |= cycle.mask;
        for (int idx = 0; idx < N_AXIS; idx++) {
            sys.work_envelope.min.values[idx] = settings.axis[idx].max_travel;
            sys.work_envelope.max.values[idx] = 0.0f;
        }
        sync_position();
        core_state(STATE_IDLE);
    } else {
        core_state(STATE_ALARM);
    }
    if (grbl.on_homing_completed) {
        grbl.on_homing_completed(cycle, success);
    }
}

status_code_t core_command(const char *line) {
    static char text[80];
    strncpy(text, line, sizeof text - 1);
    char *args = strchr(text, '=');
    if (args) {
        *args++ = '\0';
    }
    for (uint8_t i = 0; registered && i < registered->n_commands; i++) {
        if (!strcmp(registered->commands[i].command, text)) {
            return registered->commands[i].execute(state, args);
        }
    }
    return Status_InvalidStatement;
}

void core_start(void (*own_kinematics)(void)) {
    memset(&kinematics, 0, sizeof kinematics);
    hal.stream.write = write;
    grbl.on_report_options = no_options;
    grbl.check_travel_limits = within;
    my_plugin_init(); /* of the driver, before the core's own kinematics */
    if (own_kinematics) {
        own_kinematics();
    }
    sync_position();
    startup(startup_data);
}
