/* The library's steps in a cycle: one for the axes, and one for each joint with its own tables. Realtime, like
 * cycle.c. */
#include "component.h"

#include <math.h>
#include <string.h>

/* Replaces the tables, between two cycles, with those that the loader has offered. */
void steps_take_tables(struct instance *instance)
{
    const struct tables *next = atomic_exchange_explicit(&instance->shared.offered, NULL, memory_order_acq_rel);
    if (next) {
        instance->servo.tables = next;
        instance->servo.growth_told = false;
        atomic_store_explicit(&instance->shared.in_force, next, memory_order_release);
    }
}

void steps_start(struct instance *instance, uint32_t period_ns)
{
    struct servo *servo = &instance->servo;
    const struct tables *tables = servo->tables;
    int result = trueaxis_start(&tables->axes, &servo->axes_state, sizeof servo->axes_state, period_ns);
    for (int t = 0; t < instance->setup.joint_tables && result == TRUEAXIS_OK; t++)
        result = trueaxis_start(&tables->joint[t], &servo->joint_state[t], sizeof servo->joint_state[t], period_ns);
    atomic_store(&instance->shared.thread_period_ns, period_ns);
    atomic_store(&instance->shared.refused, (unsigned)result);
    trueaxis_command_window_restart(&servo->window);
    servo->growth_told = false;
    memset(&servo->stopped, 0, sizeof servo->stopped);
    /* A state that starts is not frozen. */
    servo->last.adapt_freeze = false;
    servo->phase = result == TRUEAXIS_OK ? PHASE_RUNNING : PHASE_REFUSED;
    for (int j = 0; j < instance->setup.joints; j++) {
        struct joint *joint = &servo->joint[j];
        joint->known = isfinite(joint->reading);
        if (joint->known)
            joint->drive = joint->reading;
    }
}

/* Passes a changed temperature to heated axes, and every temperature to new tables. If a reading is NaN, the last one
 * remains. */
void steps_temperature(struct instance *instance)
{
    struct servo *servo = &instance->servo;
    for (int a = 0; a < instance->setup.axes; a++) {
        if (instance->setup.joints_of_axis[a] == 0)
            continue;
        double rise = hal_get_real(instance->pins->axis[a].temperature_rise);
        if (isfinite(rise) && (rise != servo->temperature_rise[a] || !servo->growth_told)) {
            servo->temperature_rise[a] = rise;
            trueaxis_set_thermal(&servo->tables->axes, &servo->axes_state, (uint32_t)a, rise);
        }
    }
    servo->growth_told = true;
}

void steps_adaptation(struct instance *instance)
{
    struct servo *servo = &instance->servo;
    const struct tables *tables = servo->tables;
    bool freeze = hal_get_bool(instance->pins->adapt_freeze), reset = hal_get_bool(instance->pins->adapt_reset);
    if (freeze != servo->last.adapt_freeze) {
        trueaxis_friction_freeze(&tables->axes, &servo->axes_state, freeze);
        for (int t = 0; t < instance->setup.joint_tables; t++)
            trueaxis_friction_freeze(&tables->joint[t], &servo->joint_state[t], freeze);
    }
    if (reset && !servo->last.adapt_reset) {
        trueaxis_friction_reset(&tables->axes, &servo->axes_state);
        for (int t = 0; t < instance->setup.joint_tables; t++)
            trueaxis_friction_reset(&tables->joint[t], &servo->joint_state[t]);
    }
    servo->last.adapt_freeze = freeze;
    servo->last.adapt_reset = reset;
}

/* Collects command and readings. The commanded position of an axis is that of its first joint. A motor command that is not
 * finite also stops the axis. */
void steps_gather(const struct instance *instance, trueaxis_input_t *input)
{
    const struct setup *setup = &instance->setup;
    bool seen[MAX_AXES] = {false};
    for (int j = 0; j < setup->joints; j++) {
        const struct joint *joint = &instance->servo.joint[j];
        const struct joint_pins *p = &instance->pins->joint[j];
        int a = setup->axis_of_joint[j];
        double command = hal_get_real(p->pos_cmd);
        if (!seen[a])
            input->command[a] = command * setup->mm_per_unit[a];
        seen[a] = true;
        if (!isfinite(command) || !isfinite(hal_get_real(p->motor_cmd_in)))
            input->command[a] = NAN;
        if (a < 3)
            input->learned[a] = hal_get_real(instance->pins->axis[a].learned) * setup->mm_per_unit[a];
        double share = setup->mm_per_unit[a] / setup->joints_of_axis[a];
        input->feedback[a] += (joint->reading - joint->offset - joint->own) * share;
        if (hal_get_bool(p->alarm))
            input->encoder_alarm |= (uint8_t)(1u << a);
        if (!hal_get_bool(p->homed))
            input->homed = 0;
    }
}

/* Runs the tables of a single joint: a separate step, in which no other axis moves. */
static int step_joint(struct instance *instance, int t, const trueaxis_input_t *axes, trueaxis_output_t *output)
{
    struct servo *servo = &instance->servo;
    int j = instance->setup.joint_of_table[t];
    struct joint *joint = &servo->joint[j];
    const struct joint_pins *p = &instance->pins->joint[j];
    trueaxis_input_t input = *axes;
    memset(input.command, 0, sizeof input.command);
    memset(input.feedback, 0, sizeof input.feedback);
    /* The learned correction belongs to the axis. */
    memset(input.learned, 0, sizeof input.learned);
    double unit = instance->setup.mm_per_unit[instance->setup.axis_of_joint[j]];
    /* A stop of the axes also stops the joint, through the same latch, and vice versa. */
    bool stopped_elsewhere = servo->phase != PHASE_RUNNING && !servo->stopped.joint[t];
    int slot = servo->tables->joint_slot[t];
    input.command[slot] = isfinite(hal_get_real(p->motor_cmd_in)) && !stopped_elsewhere ? hal_get_real(p->pos_cmd) * unit : NAN;
    input.feedback[slot] = (joint->reading - joint->offset - (joint->sent - joint->own)) * unit;
    input.encoder_alarm = hal_get_bool(p->alarm) ? (uint8_t)(1u << slot) : 0;
    /* This step measures no contour error, so nothing could show that a part helps. */
    input.dynamics_off &= (uint8_t)~TRUEAXIS_DYNAMICS_ON_TRIAL;
    return trueaxis_step(&servo->tables->joint[t], &servo->joint_state[t], &input, NULL, NULL, output);
}

/* Runs the step of the axes. Its path consists of the last commands since homing. */
static int step_axes(struct instance *instance, const trueaxis_input_t *given, trueaxis_output_t *output)
{
    struct servo *servo = &instance->servo;
    trueaxis_input_t input = *given;
    if (servo->phase != PHASE_RUNNING && !servo->stopped.axes)
        input.command[0] = NAN;
    if (input.homed && !servo->last.homed)
        trueaxis_command_window_restart(&servo->window);
    servo->last.homed = input.homed;
    trueaxis_measure_t measure = {.size = sizeof measure, .kind = TRUEAXIS_MEASURE_COMMANDS, .window = &servo->window};
    trueaxis_gauge_ride_t ride = {.size = sizeof ride};
    if (instance->setup.has_gauge)
        gauge_read(instance, &ride);
    int result = trueaxis_step(&servo->tables->axes, &servo->axes_state, &input, &measure,
                               instance->setup.has_gauge ? &ride : NULL, output);
    if (instance->setup.has_gauge && (result == TRUEAXIS_OK || result == TRUEAXIS_ERROR_NO_OUTPUT))
        gauge_show(instance, &ride);
    return result;
}

/* Takes back the progress of the other steps in this cycle, because one of the steps stops the machine. */
static void take_back(struct instance *instance)
{
    struct servo *servo = &instance->servo;
    if (instance->setup.joint_tables == 0)
        return;
    if (!servo->stopped.axes)
        servo->axes_state = servo->axes_before;
    for (int t = 0; t < instance->setup.joint_tables; t++)
        if (!servo->stopped.joint[t])
            servo->joint_state[t] = servo->joint_before[t];
}

bool steps_run(struct instance *instance, const trueaxis_input_t *input, trueaxis_output_t *axes,
               trueaxis_output_t joints[MAX_JOINT_TABLES])
{
    struct servo *servo = &instance->servo;
    int tables = instance->setup.joint_tables;
    if (tables > 0) {
        servo->axes_before = servo->axes_state;
        memcpy(servo->joint_before, servo->joint_state, sizeof servo->joint_before);
    }
    int result = step_axes(instance, input, axes);
    bool blind = result == TRUEAXIS_ERROR_NO_OUTPUT;
    for (int t = 0; t < tables && (result == TRUEAXIS_OK || result == TRUEAXIS_ERROR_NO_OUTPUT); t++) {
        joints[t].size = sizeof joints[t];
        result = step_joint(instance, t, input, &joints[t]);
        blind |= result == TRUEAXIS_ERROR_NO_OUTPUT;
    }
    if (result != TRUEAXIS_OK && result != TRUEAXIS_ERROR_NO_OUTPUT)
        return false;
    servo->stopped.axes = axes->record.status & TRUEAXIS_STATUS_STOP_REQUEST;
    bool stopped = servo->stopped.axes;
    for (int t = 0; t < tables; t++) {
        servo->stopped.joint[t] = joints[t].record.status & TRUEAXIS_STATUS_STOP_REQUEST;
        stopped |= servo->stopped.joint[t];
    }
    if (stopped && servo->phase == PHASE_RUNNING)
        take_back(instance);
    servo->phase = blind ? PHASE_BLIND : stopped ? PHASE_HOLDING : PHASE_RUNNING;
    return true;
}
