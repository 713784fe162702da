/* The two functions of the servo thread: feedback on its way to motion-controller, command on its way to the drives.
 *
 *   motor-pos-fb  --update-feedback-->  joint.N.motor-pos-fb  = raw - correction sent
 *   motion-controller
 *   joint.N.motor-pos-cmd  --update-output-->  drive  = motor command + correction at joint.N.pos-cmd
 *
 * Nothing here allocates, opens, prints or waits; every loop is bounded by the number of joints or axes.
 */
#include "component.h"

#include <math.h>
#include <string.h>

/* A correction of zero passes a position bit for bit. */
static inline double plus(double position, double correction)
{
    return correction == 0.0 ? position : position + correction;
}

void cycle_update_feedback(void *arg, long period)
{
    struct instance *instance = arg;
    struct pins *pins = instance->pins;
    (void)period;
    for (int j = 0; j < instance->joints; j++) {
        struct joint *joint = &instance->joint[j];
        struct joint_pins *p = &pins->joint[j];
        double reading = *p->motor_fb_in;
        /* Both pins still show the cycle before, which is the one that this reading answers. */
        double offset = *p->motor_cmd_in - *p->pos_cmd;
        if (isfinite(offset))
            joint->offset = offset;
        joint->reading = reading;
        /* Motion must never see a NaN: it keeps the last reading, and LinuxCNC's own following error limit decides. */
        if (isfinite(reading))
            joint->passed = plus(reading, -joint->sent);
        *p->motor_fb_out = joint->passed;
    }
}

/* Exchanges the tables for those that the thread has offered, between two cycles. */
static void take_tables(struct instance *instance)
{
    const struct tables *next = atomic_exchange_explicit(&instance->offered, NULL, memory_order_acq_rel);
    if (next) {
        instance->tables = next;
        instance->growth_told = false;
        atomic_store_explicit(&instance->in_force, next, memory_order_release);
    }
}

static void start(struct instance *instance, uint32_t period_ns)
{
    const struct tables *tables = instance->tables;
    int status = trueaxis_start(&tables->axes, &instance->axes_state, sizeof instance->axes_state, period_ns);
    for (int t = 0; t < instance->joint_tables && status == TRUEAXIS_OK; t++)
        status = trueaxis_start(&tables->joint[t], &instance->joint_state[t], sizeof instance->joint_state[t], period_ns);
    atomic_store(&instance->thread_period_ns, period_ns);
    atomic_store(&instance->refused, status == TRUEAXIS_OK ? 0u : (unsigned)status);
    for (int j = 0; j < instance->joints; j++) {
        struct joint *joint = &instance->joint[j];
        joint->known = isfinite(joint->reading);
        if (joint->known)
            joint->drive = joint->reading;
    }
    instance->started = true;
}

/* Whether motion commands every joint to where it stands: without power for the drives, its command follows them. */
static bool standing(const struct instance *instance)
{
    for (int j = 0; j < instance->joints; j++) {
        const struct joint *joint = &instance->joint[j];
        const struct joint_pins *p = &instance->pins->joint[j];
        double way = fabs(*p->motor_cmd_in - joint->reading + joint->sent) * instance->mm_per_unit[joint->axis];
        if (!(way <= STANDING) || !isfinite(*p->pos_cmd))
            return false;
    }
    return true;
}

/* A machine that lost its power at speed comes to rest away from the held output, where the library would release the
 * stop. Nothing can jump there: it begins anew from where the machine stands. */
static void release_without_power(struct instance *instance, uint32_t period_ns)
{
    bool reset = *instance->pins->reset && !instance->reset_before;
    instance->reset_before = *instance->pins->reset;
    if (!reset || !instance->held || *instance->pins->motion_enabled || !standing(instance))
        return;
    start(instance, period_ns);
    trueaxis_follow_restart(&instance->follow);
    instance->growth_told = false;
    instance->held = instance->axes_stopped = false;
    memset(instance->joint_stopped, 0, sizeof instance->joint_stopped);
}

/* The axis' position in the command: that of its first joint. A motor command that is not a number stops the axis too. */
static void gather(const struct instance *instance, trueaxis_input_t *input)
{
    const struct pins *pins = instance->pins;
    bool seen[MAX_AXES] = {false};
    for (int j = 0; j < instance->joints; j++) {
        const struct joint *joint = &instance->joint[j];
        const struct joint_pins *p = &pins->joint[j];
        int a = joint->axis;
        double command = *p->pos_cmd;
        if (!seen[a])
            input->command[a] = command * instance->mm_per_unit[a];
        seen[a] = true;
        if (!isfinite(command) || !isfinite(*p->motor_cmd_in))
            input->command[a] = NAN;
        double share = instance->mm_per_unit[a] / instance->joints_of_axis[a];
        input->feedback[a] += (joint->reading - joint->offset - joint->own) * share;
        if (*p->alarm)
            input->encoder_alarm |= (uint8_t)(1u << a);
        if (!*p->homed)
            input->homed = 0;
    }
}

/* Heated axes: hands a changed temperature on, and every one to new tables; a reading that is not a number keeps the
 * last one. */
static void follow_temperature(struct instance *instance)
{
    for (int a = 0; a < instance->axes; a++) {
        if (instance->joints_of_axis[a] == 0)
            continue;
        double rise = *instance->pins->axis[a].temperature_rise;
        if (isfinite(rise) && (rise != instance->temperature_rise[a] || !instance->growth_told)) {
            instance->temperature_rise[a] = rise;
            trueaxis_set_thermal(&instance->tables->axes, &instance->axes_state, (uint32_t)a, rise);
        }
    }
    instance->growth_told = true;
}

/* The tables that belong to one joint only: a step of its own, in which no other axis moves. */
static int step_joint(struct instance *instance, int t, const trueaxis_input_t *axes, trueaxis_output_t *output)
{
    struct joint *joint = &instance->joint[instance->joint_of_table[t]];
    const struct joint_pins *p = &instance->pins->joint[instance->joint_of_table[t]];
    trueaxis_input_t input = *axes;
    memset(input.command, 0, sizeof input.command);
    memset(input.feedback, 0, sizeof input.feedback);
    double unit = instance->mm_per_unit[joint->axis];
    double command = *p->pos_cmd * unit;
    /* A stop of the axes is a stop of the joint, by the same latch; and the other way round. */
    bool stopped_elsewhere = instance->held && !instance->joint_stopped[t];
    int place = instance->tables->joint_place[t];
    input.command[place] = isfinite(*p->motor_cmd_in) && !stopped_elsewhere ? command : NAN;
    input.feedback[place] = (joint->reading - joint->offset - (joint->sent - joint->own)) * unit;
    input.encoder_alarm = *p->alarm ? (uint8_t)(1u << place) : 0;
    return trueaxis_step(&instance->tables->joint[t], &instance->joint_state[t], &input, NULL, NULL, output);
}

/* The path is what was commanded last, from homing on; a machine with a gauge measures its part instead. */
static int step_axes(struct instance *instance, const trueaxis_input_t *input, trueaxis_output_t *output)
{
    if (instance->has_gauge)
        return gauge_step(instance, input, output);
    if (input->homed && !instance->homed_before)
        trueaxis_follow_restart(&instance->follow);
    instance->homed_before = input->homed;
    const struct tables *tables = instance->tables;
    trueaxis_state_t *state = &instance->axes_state;
    return trueaxis_step_following(&tables->axes, state, input, &instance->follow, output);
}

static void show_contour(struct contour_pins *pins, const trueaxis_contour_t *contour, double mm_per_unit)
{
    *pins->error = contour->error / mm_per_unit;
    *pins->normal = contour->normal / mm_per_unit;
    *pins->binormal = contour->binormal / mm_per_unit;
    *pins->lag = contour->lag / mm_per_unit;
    *pins->found = !(contour->flags & TRUEAXIS_CONTOUR_NOT_FOUND);
}

static void show_axes(const struct instance *instance, const trueaxis_input_t *input, const trueaxis_output_t *output)
{
    const trueaxis_record_t *record = &output->record;
    for (int a = 0; a < instance->axes; a++) {
        if (instance->joints_of_axis[a] == 0)
            continue;
        struct axis_pins *pins = &instance->pins->axis[a];
        double unit = instance->mm_per_unit[a];
        *pins->command = input->command[a] / unit;
        if (!instance->no_output)
            *pins->corrected = output->drive[a] / unit;
        *pins->correction = record->correction[a] / unit;
        *pins->limited = record->limited >> a & 1;
        *pins->at_edge = record->at_edge >> a & 1;
    }
}

/* Neither a command nor, of every axis, a reading that can be used has ever come. HAL has no pin without a value: the
 * outputs follow what is read, and the others stay what they are. Where all is read, that is what is held. */
static void stand(struct instance *instance)
{
    for (int j = 0; j < instance->joints; j++) {
        struct joint *joint = &instance->joint[j];
        if (!isfinite(joint->reading) || *instance->pins->joint[j].alarm)
            continue;
        joint->drive = joint->reading;
        joint->known = true;
    }
}

/* One of the steps stops the machine: what the others have advanced in this cycle is not sent either. */
static void take_back(struct instance *instance)
{
    if (instance->joint_tables == 0)
        return;
    if (!instance->axes_stopped)
        instance->axes_state = instance->axes_before;
    for (int t = 0; t < instance->joint_tables; t++)
        if (!instance->joint_stopped[t])
            instance->joint_state[t] = instance->joint_before[t];
}

/* What goes to the drives: the motor's command plus its corrections, or what went there last while a stop is wanted. */
static void drive(struct instance *instance, const trueaxis_output_t *axes, const trueaxis_output_t *joints)
{
    for (int j = 0; j < instance->joints; j++) {
        struct joint *joint = &instance->joint[j];
        struct joint_pins *p = &instance->pins->joint[j];
        if (!instance->held) {
            double unit = instance->mm_per_unit[joint->axis];
            if (joint->table >= 0)
                joint->own = joints[joint->table].record.correction[instance->tables->joint_place[joint->table]] / unit;
            joint->sent = axes->record.correction[joint->axis] / unit + joint->own;
            joint->drive = plus(*p->motor_cmd_in, joint->sent);
            joint->known = true;
        }
        if (joint->known)
            *p->motor_cmd_out = joint->drive;
        *p->correction = joint->sent;
    }
}

static void show(struct instance *instance, const trueaxis_output_t *axes, const trueaxis_output_t *joints)
{
    struct pins *pins = instance->pins;
    const trueaxis_record_t *record = &axes->record;
    uint32_t fault = record->fault;
    int fault_axis = record->fault_axis;
    bool limited = record->limited != 0, at_edge = record->at_edge != 0;
    bool frozen = record->status & TRUEAXIS_STATUS_FROZEN;
    for (int t = 0; t < instance->joint_tables; t++) {
        const trueaxis_record_t *own = &joints[t].record;
        limited |= own->limited != 0;
        at_edge |= own->at_edge != 0;
        frozen |= (own->status & TRUEAXIS_STATUS_FROZEN) != 0;
        if (fault == TRUEAXIS_FAULT_NONE && own->fault != TRUEAXIS_FAULT_NONE) {
            fault = own->fault;
            fault_axis = instance->joint[instance->joint_of_table[t]].axis;
        }
    }
    *pins->active = (record->status & TRUEAXIS_STATUS_ACTIVE) != 0;
    *pins->frozen = frozen;
    *pins->limited = limited;
    *pins->at_edge = at_edge;
    *pins->fault = fault != TRUEAXIS_FAULT_NONE;
    *pins->fault_code = fault;
    *pins->fault_axis = fault != TRUEAXIS_FAULT_NONE ? fault_axis : -1;
    *pins->stop_request = instance->held;
    *pins->no_output = instance->no_output;
    *pins->sequence = record->sequence;
    *pins->machine_id = record->machine_id;
    *pins->tables_crc = record->tables_crc;
    show_contour(&pins->tip, &record->tip, instance->mm_per_unit[0]);
    show_contour(&pins->encoder, &record->encoder, instance->mm_per_unit[0]);
}

/* The library refuses the thread's period, or a call: the command passes with the correction as it was, and a stop is
 * requested. */
static void pass(struct instance *instance, uint32_t fault)
{
    struct pins *pins = instance->pins;
    bool known = true;
    for (int j = 0; j < instance->joints; j++) {
        struct joint *joint = &instance->joint[j];
        double command = *pins->joint[j].motor_cmd_in;
        if (isfinite(command)) {
            joint->drive = plus(command, joint->sent);
            joint->known = true;
        }
        known &= joint->known;
        if (joint->known)
            *pins->joint[j].motor_cmd_out = joint->drive;
    }
    *pins->no_output = !known;
    *pins->active = 0;
    *pins->fault = 1;
    *pins->fault_code = fault;
    *pins->stop_request = 1;
}

void cycle_update_output(void *arg, long period)
{
    struct instance *instance = arg;
    struct pins *pins = instance->pins;
    uint32_t period_ns = (uint32_t)period;

    take_tables(instance);
    if (!instance->started)
        start(instance, period_ns);
    if (atomic_load(&instance->refused)) {
        pass(instance, TRUEAXIS_FAULT_PERIOD_MISMATCH);
        return;
    }
    if (*pins->reload && !instance->reload_before)
        atomic_fetch_add_explicit(&instance->reload_wanted, 1, memory_order_release);
    instance->reload_before = *pins->reload;
    release_without_power(instance, period_ns);
    follow_temperature(instance);

    /* Motion advances by the nominal period in every call, and so does the step. */
    trueaxis_input_t input = {.size = sizeof input, .elapsed_ns = period_ns, .homed = 1};
    bool permitted = atomic_load_explicit(&instance->permitted, memory_order_acquire);
    /* Without power, motion's command follows the drives, with a jump of the following error: nothing to judge. */
    input.enable = *pins->enable && *pins->motion_enabled && permitted;
    input.reset = *pins->reset;
    gather(instance, &input);

    trueaxis_output_t axes = {.size = sizeof axes};
    trueaxis_output_t joints[MAX_JOINT_TABLES];
    trueaxis_input_t shown = input;
    if (instance->held && !instance->axes_stopped)
        input.command[0] = NAN;
    bool stood = instance->no_output, held = instance->held;
    if (instance->joint_tables > 0) {
        instance->axes_before = instance->axes_state;
        memcpy(instance->joint_before, instance->joint_state, sizeof instance->joint_before);
    }
    int status = step_axes(instance, &input, &axes);
    instance->no_output = status == TRUEAXIS_ERROR_NO_OUTPUT;
    for (int t = 0; t < instance->joint_tables && (status == TRUEAXIS_OK || status == TRUEAXIS_ERROR_NO_OUTPUT); t++) {
        joints[t].size = sizeof joints[t];
        status = step_joint(instance, t, &shown, &joints[t]);
        instance->no_output |= status == TRUEAXIS_ERROR_NO_OUTPUT;
    }
    if (status != TRUEAXIS_OK && status != TRUEAXIS_ERROR_NO_OUTPUT) {
        pass(instance, TRUEAXIS_FAULT_TABLES_REFUSED);
        return;
    }
    if (instance->no_output || stood)
        stand(instance);
    instance->axes_stopped = axes.record.status & TRUEAXIS_STATUS_STOP_REQUEST;
    instance->held = instance->axes_stopped;
    for (int t = 0; t < instance->joint_tables; t++) {
        instance->joint_stopped[t] = joints[t].record.status & TRUEAXIS_STATUS_STOP_REQUEST;
        instance->held |= instance->joint_stopped[t];
    }
    if (instance->held && !held)
        take_back(instance);
    drive(instance, &axes, joints);
    show_axes(instance, &shown, &axes);
    show(instance, &axes, joints);
}
