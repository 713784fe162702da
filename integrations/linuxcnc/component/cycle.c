/* The two functions of the servo thread: feedback for motion-controller, and commands for the drives.
 *
 *   motor-pos-fb  --update-feedback-->  joint.N.motor-pos-fb  = raw - correction sent
 *   motion-controller
 *   joint.N.motor-pos-cmd  --update-output-->  drive  = motor command + correction at joint.N.pos-cmd
 *
 * Nothing here allocates, opens, prints or waits; every loop is bounded by the number of joints or axes.
 */
#include "component.h"

#include <math.h>

/* A correction of zero leaves a position unchanged in every bit. */
static inline double plus(double position, double correction)
{
    return correction == 0.0 ? position : position + correction;
}

void cycle_update_feedback(void *arg, long period)
{
    struct instance *instance = arg;
    struct pins *pins = instance->pins;
    (void)period;
    for (int j = 0; j < instance->setup.joints; j++) {
        struct joint *joint = &instance->servo.joint[j];
        struct joint_pins *p = &pins->joint[j];
        double reading = hal_get_real(p->motor_fb_in);
        /* Both pins still show the previous cycle, to which this reading belongs. */
        double offset = hal_get_real(p->motor_cmd_in) - hal_get_real(p->pos_cmd);
        if (isfinite(offset))
            joint->offset = offset;
        joint->reading = reading;
        /* Motion must never see a NaN. It keeps the last reading, and LinuxCNC's own following error limit decides. */
        if (isfinite(reading))
            joint->passed = plus(reading, -joint->sent);
        hal_set_real(p->motor_fb_out, joint->passed);
    }
}

/* Whether motion commands every joint to its present position. Without drive power, the command follows the drives. */
static bool standing(const struct instance *instance)
{
    for (int j = 0; j < instance->setup.joints; j++) {
        const struct joint *joint = &instance->servo.joint[j];
        const struct joint_pins *p = &instance->pins->joint[j];
        double unit = instance->setup.mm_per_unit[instance->setup.axis_of_joint[j]];
        double distance = fabs(hal_get_real(p->motor_cmd_in) - joint->reading + joint->sent) * unit;
        if (!(distance <= STANDING) || !isfinite(hal_get_real(p->pos_cmd)))
            return false;
    }
    return true;
}

/* Releases a stop without drive power. A machine that lost its power at speed stops away from the held output, and the
 * library releases the stop only there. Nothing can jump at standstill, so a reset restarts the steps from the machine's
 * position. */
static void release_without_power(struct instance *instance, uint32_t period_ns)
{
    struct servo *servo = &instance->servo;
    bool reset = hal_get_bool(instance->pins->reset) && !servo->last.reset;
    servo->last.reset = hal_get_bool(instance->pins->reset);
    bool held = servo->phase == PHASE_HOLDING || servo->phase == PHASE_BLIND;
    if (reset && held && !hal_get_bool(instance->pins->motion_enabled) && standing(instance))
        steps_start(instance, period_ns);
}

/* Sets the outputs before any usable command and before every axis has had a usable reading. A HAL pin always has a value,
 * so the outputs follow the usable readings and the others do not change. Once all axes have been read, the step holds
 * their positions. */
static void follow_readings(struct instance *instance)
{
    for (int j = 0; j < instance->setup.joints; j++) {
        struct joint *joint = &instance->servo.joint[j];
        if (!isfinite(joint->reading) || hal_get_bool(instance->pins->joint[j].alarm))
            continue;
        joint->drive = joint->reading;
        joint->known = true;
    }
}

/* Shows the dynamic part of a joint's correction on pins: that of its axis plus, if `more`, that of its own tables. */
static void show_dynamic(struct joint_pins *p, const trueaxis_dynamic_t *of, int slot, double unit, bool more)
{
    hal_set_real(p->dynamic, of->sent[slot] / unit + (more ? hal_get_real(p->dynamic) : 0.0));
    hal_set_real(p->feed_forward, of->feed_forward[slot] / unit + (more ? hal_get_real(p->feed_forward) : 0.0));
    hal_set_real(p->contour_feedback, of->feedback[slot] / unit + (more ? hal_get_real(p->contour_feedback) : 0.0));
    hal_set_real(p->crosstalk, of->crosstalk[slot] / unit + (more ? hal_get_real(p->crosstalk) : 0.0));
    hal_set_real(p->learned, of->learned[slot] / unit + (more ? hal_get_real(p->learned) : 0.0));
}

/* Whole correction of an axis. */
static double correction(const trueaxis_record_t *record, int slot)
{
    return record->correction[slot] + record->dynamic.sent[slot];
}

/* Writes the outputs to the drives: the motor's command plus its corrections, or the last output while a stop is
 * requested. */
static void drive(struct instance *instance, const trueaxis_output_t *axes, const trueaxis_output_t *joints)
{
    const struct setup *setup = &instance->setup;
    struct servo *servo = &instance->servo;
    for (int j = 0; j < setup->joints; j++) {
        struct joint *joint = &servo->joint[j];
        struct joint_pins *p = &instance->pins->joint[j];
        if (servo->phase == PHASE_RUNNING) {
            int axis = setup->axis_of_joint[j], table = setup->table_of_joint[j];
            double unit = setup->mm_per_unit[axis];
            show_dynamic(p, &axes->record.dynamic, axis, unit, false);
            if (table >= 0) {
                int slot = servo->tables->joint_slot[table];
                joint->own = correction(&joints[table].record, slot) / unit;
                show_dynamic(p, &joints[table].record.dynamic, slot, unit, true);
            }
            joint->sent = correction(&axes->record, axis) / unit + joint->own;
            joint->drive = plus(hal_get_real(p->motor_cmd_in), joint->sent);
            joint->known = true;
        }
        if (joint->known)
            hal_set_real(p->motor_cmd_out, joint->drive);
        hal_set_real(p->correction, joint->sent);
    }
}

/* Passes the command with the last correction and requests a stop, if the library refuses the thread's period or a
 * call. */
static void pass(struct instance *instance, uint32_t fault)
{
    struct pins *pins = instance->pins;
    bool known = true;
    for (int j = 0; j < instance->setup.joints; j++) {
        struct joint *joint = &instance->servo.joint[j];
        double command = hal_get_real(pins->joint[j].motor_cmd_in);
        if (isfinite(command)) {
            joint->drive = plus(command, joint->sent);
            joint->known = true;
        }
        known &= joint->known;
        if (joint->known)
            hal_set_real(pins->joint[j].motor_cmd_out, joint->drive);
    }
    hal_set_bool(pins->no_output, !known);
    hal_set_bool(pins->active, 0);
    hal_set_bool(pins->fault, 1);
    hal_set_ui32(pins->fault_code, fault);
    hal_set_bool(pins->stop_request, 1);
}

void cycle_update_output(void *arg, long period)
{
    struct instance *instance = arg;
    struct servo *servo = &instance->servo;
    struct pins *pins = instance->pins;
    uint32_t period_ns = trueaxis_elapsed_ns(period);

    steps_take_tables(instance);
    if (servo->phase == PHASE_NEW)
        steps_start(instance, period_ns);
    release_without_power(instance, period_ns);
    if (servo->phase == PHASE_REFUSED) {
        pass(instance, TRUEAXIS_FAULT_PERIOD_MISMATCH);
        return;
    }
    if (hal_get_bool(pins->reload) && !servo->last.reload)
        atomic_fetch_add_explicit(&instance->shared.reload_wanted, 1, memory_order_release);
    servo->last.reload = hal_get_bool(pins->reload);
    /* Only one of the two may be used, because the later call replaces the growth set by the other. */
    if (instance->setup.has_thermal)
        thermal_update(instance, period_ns);
    else
        steps_temperature(instance);

    /* Motion advances by the nominal period in every call, and so does the step. */
    trueaxis_input_t input = {.size = sizeof input, .elapsed_ns = period_ns, .homed = 1};
    bool permitted = atomic_load_explicit(&instance->shared.permitted, memory_order_acquire);
    /* Without power, motion's command follows the drives, and a jump of the following error must not count as a fault. */
    input.enable = hal_get_bool(pins->enable) && hal_get_bool(pins->motion_enabled) && permitted;
    input.reset = hal_get_bool(pins->reset);
    input.dynamics_off = pins_parts_off(pins);
    steps_adaptation(instance);
    steps_gather(instance, &input);

    trueaxis_output_t axes = {.size = sizeof axes};
    trueaxis_output_t joints[MAX_JOINT_TABLES];
    bool was_blind = servo->phase == PHASE_BLIND;
    if (!steps_run(instance, &input, &axes, joints)) {
        pass(instance, TRUEAXIS_FAULT_TABLES_REFUSED);
        return;
    }
    if (was_blind || servo->phase == PHASE_BLIND)
        follow_readings(instance);
    drive(instance, &axes, joints);
    show_cycle(instance, &input, &axes, joints);
    show_friction(instance);
}
