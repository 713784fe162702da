/*
 * Geometric error compensation for grblHAL, around the existing kinematics.
 *
 * These files become part of a grblHAL firmware and use its interface, so they are under grblHAL's licence.
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#include <math.h>
#include <string.h>

#include "trueaxis_kinematics.h"

#ifndef TRUEAXIS_MACHINE_ID
#define TRUEAXIS_MACHINE_ID 0 /* any; `trueaxis tables show` prints a machine's */
#endif

/* Defined in tables.S, or elsewhere in the image. */
extern const uint8_t trueaxis_tables[], trueaxis_tables_end[];

trueaxis_shared_t trueaxis_shared;

static on_state_change_ptr on_state_change;
static on_homing_completed_ptr on_homing_completed;
static on_jog_cancel_ptr on_jog_cancel;
static on_report_options_ptr on_report_options;
static on_execute_realtime_ptr on_execute_realtime;
static travel_limits_ptr check_travel_limits;
static apply_travel_limits_ptr apply_travel_limits;

static bool loaded;        /* the tables are valid for this machine */
static bool wanted = true; /* by the operator */
static const char *refusal = "not started";

/* The corrected hooks. */

/* Whether the core is about to send the drives to a parking place and back. It then passes the position that it reads now
 * to the planner unchanged, bypassing `segment_line`. Status reports may come in between, but only while a motion is
 * running. */
static bool about_to_park(void) {
    return (state_get() & (STATE_SAFETY_DOOR | STATE_SLEEP)) && sys.parking_state == Parking_Retracting && !sys.step_control.flags;
}

static coord_data_t *from_steps(coord_data_t *position, mpos_t *steps) {
    if (!trueaxis_shared.correcting) {
        return trueaxis_shared.present.transform_steps_to_cartesian(position, steps);
    }
    trueaxis_follow();
    if (steps->values == sys.position || trueaxis_same_steps(steps->values, sys.position)) {
        trueaxis_line_dropped();
        if (about_to_park()) {
            trueaxis_drives(position);
        } else if (position->values == gc_state.position) {
            trueaxis_program(position);
        } else {
            trueaxis_tool(position);
        }
    } else if (steps->values == sys.probe_position) {
        trueaxis_probed(position);
    } else {
        trueaxis_shared.present.transform_steps_to_cartesian(position, steps);
        trueaxis_correction_inverse(position->values, trueaxis_shared.executed.negative, position->values);
    }
    return position;
}

static coord_data_t *to_motors(coord_data_t *target, coord_data_t *position) {
    coord_data_t drive = *position;
    if (trueaxis_shared.correcting) {
        trueaxis_correction_forward(drive.values, trueaxis_shared.planned.negative, drive.values);
    }
    return trueaxis_shared.present.transform_from_cartesian(target, &drive);
}

/* At the switch of a homed axis the tool differs from the drive's position by the correction there, and may therefore be
 * outside the limits. The limits are widened by the tables' largest correction; otherwise the core would refuse every
 * line that leaves the axis at its position. */
static bool within_travel(float *target, axes_signals_t axes, bool is_cartesian, work_envelope_t *envelope) {
    work_envelope_t wider = *envelope;

    for (unsigned slot = 0; trueaxis_shared.correcting && is_cartesian && slot < trueaxis_correction_tables()->axes; slot++) {
        unsigned idx = trueaxis_correction_axis(slot);
        wider.min.values[idx] -= trueaxis_correction_largest(slot);
        wider.max.values[idx] += trueaxis_correction_largest(slot);
    }
    return check_travel_limits(target, axes, is_cartesian, &wider);
}

/* The core limits jogs and probing to the travel. An axis that is outside it because of its correction stays there:
 * limiting it would move an uncommanded axis, and the slope of the move to the limit would be undefined. */
static void cut_to_travel(float *target, float *position, work_envelope_t *envelope) {
    const float *from = position ? position : gc_state.position;
    work_envelope_t wider = *envelope;

    for (unsigned slot = 0; trueaxis_shared.correcting && slot < trueaxis_correction_tables()->axes; slot++) {
        unsigned idx = trueaxis_correction_axis(slot);
        float low = wider.min.values[idx], high = wider.max.values[idx], largest = trueaxis_correction_largest(slot);
        wider.min.values[idx] = fmaxf(fminf(low, from[idx]), low - largest);
        wider.max.values[idx] = fminf(fmaxf(high, from[idx]), high + largest);
    }
    apply_travel_limits(target, position, &wider);
}

/* Switches the correction. Nothing moves; the program's position is computed again from the steps. */

static void correct(bool on) {
    if (trueaxis_shared.correcting != on) {
        trueaxis_shared.correcting = on;
        for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
            trueaxis_shared.last.values[idx] = NAN; /* take the program's position from the steps */
        }
        sync_position();
        trueaxis_take_over();
    }
}

static bool homed(void) {
    uint8_t needed = trueaxis_correction_axes();
    return (sys.homed.mask & needed) == needed;
}

static void homing_completed(axes_signals_t cycle, bool success) {
    if (success && loaded && wanted && homed()) {
        trueaxis_follow_from_here((uint8_t)~settings.homing.dir_mask.mask); /* each axis last moved off its switch */
        correct(true);
        report_message("trueaxis: correction on", Message_Info);
    }
    if (on_homing_completed) {
        on_homing_completed(cycle, success);
    }
}

/* Homing determines the drives' own zero, without which no position is known. */
static void state_changed(sys_state_t state) {
    if (trueaxis_shared.correcting && (state == STATE_HOMING || ((state == STATE_IDLE || state == STATE_ALARM) && !homed()))) {
        correct(false);
        if (state != STATE_HOMING) {
            report_message("trueaxis: position lost, running uncompensated until homed", Message_Warning);
        }
    }
    if (on_state_change) {
        on_state_change(state);
    }
}

/* Called in every pass of the foreground loop. */
static void sample_drives(sys_state_t state) {
    trueaxis_follow();
    on_execute_realtime(state);
}

/* Called in interrupt context. */
static void jog_cancel(sys_state_t state) {
    trueaxis_shared.jog_cancelled = true;
    if (on_jog_cancel) {
        on_jog_cancel(state);
    }
}

/* Messages. */

static void tell_state(void) {
    hal.stream.write(trueaxis_shared.correcting ? "[TRUEAXIS:on" : "[TRUEAXIS:uncompensated, ");
    hal.stream.write(trueaxis_shared.correcting ? "" : !loaded ? refusal : !wanted ? "switched off" : "not homed");
}

static void report_options(bool newopt) {
    on_report_options(newopt);
    if (!newopt) {
        report_plugin("trueaxis", "1");
        tell_state();
        hal.stream.write("]" ASCII_EOL);
    }
}

/* $TRUEAXIS reports the state; $TRUEAXIS=1 and =0 switch the correction. */
static status_code_t command(sys_state_t state, char *args) {
    if (args && *args) {
        if ((*args != '0' && *args != '1') || args[1]) {
            return Status_InvalidStatement;
        }
        if (state != STATE_IDLE || plan_get_current_block()) {
            return Status_IdleError;
        }
        wanted = *args == '1';
        correct(wanted && loaded && homed());
    }
    tell_state();
    if (loaded) {
        hal.stream.write("|");
        hal.stream.write(trueaxis_correction_tables()->name);
    }
    if (trueaxis_shared.correcting) {
        coord_data_t here, drive;
        system_convert_array_steps_to_mpos(here.values, sys.position);
        trueaxis_correction_forward(here.values, trueaxis_shared.executed.negative, drive.values);
        for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
            hal.stream.write(idx ? "," : "|C:");
            hal.stream.write(ftoa(drive.values[idx] - here.values[idx], 4));
        }
    }
    hal.stream.write("]" ASCII_EOL);
    return Status_OK;
}

/* Returns NULL, or the refusal of an axis whose travel does not overlap the tables' travel: the tables were measured in
 * other coordinates or on another machine. */
static const char *beside_the_travel(void) {
    static char text[] = "the tables' travel of ? has nothing in common with the machine's";
    const trueaxis_tables_info_t *info = trueaxis_correction_tables();

    for (unsigned slot = 0; slot < info->axes; slot++) {
        unsigned idx = trueaxis_correction_axis(slot);
        float travel = settings.axis[idx].max_travel; /* negative */
        bool up = settings.homing.flags.force_set_origin && (settings.homing.dir_mask.mask & bit(idx));
        float low = up ? 0.0f : travel, high = up ? -travel : 0.0f;
        if (travel < 0.0f && info->travel_low[slot] < info->travel_high[slot] &&
            (high <= (float)info->travel_low[slot] || low >= (float)info->travel_high[slot])) {
            *strchr(text, '?') = info->letters[slot];
            return text;
        }
    }
    return NULL;
}

/* Runs after everything else has started and before the first line is read; wraps the kinematics present by then. */
static void start(void *data) {
    static char text[320];
    (void)data;

    refusal = trueaxis_correction_load(trueaxis_tables, (size_t)(trueaxis_tables_end - trueaxis_tables), TRUEAXIS_MACHINE_ID,
                                       N_AXIS);
    if (!refusal) {
        refusal = beside_the_travel();
    }
    loaded = !refusal;
    strcpy(text, "trueaxis: ");
    if (refusal) {
        strncat(text, refusal, sizeof text - 48);
        strcat(text, "; running uncompensated");
        report_message(text, Message_Warning);
        return;
    }
    strcat(text, trueaxis_correction_tables()->name);
    strcat(text, ", uncompensated until homed");
    report_message(text, Message_Info);

    trueaxis_shared.present = kinematics;
    kinematics.transform_steps_to_cartesian = from_steps;
    kinematics.transform_from_cartesian = to_motors;
    kinematics.segment_line = trueaxis_segment_line;
    check_travel_limits = grbl.check_travel_limits;
    grbl.check_travel_limits = within_travel;
    apply_travel_limits = grbl.apply_travel_limits;
    grbl.apply_travel_limits = cut_to_travel;
    on_state_change = grbl.on_state_change;
    grbl.on_state_change = state_changed;
    on_homing_completed = grbl.on_homing_completed;
    grbl.on_homing_completed = homing_completed;
    on_jog_cancel = grbl.on_jog_cancel;
    grbl.on_jog_cancel = jog_cancel;
    on_execute_realtime = grbl.on_execute_realtime;
    grbl.on_execute_realtime = sample_drives;
    trueaxis_follow_from_here(0);
}

void my_plugin_init(void) {
    static const sys_command_t commands[] = {
        { "TRUEAXIS", command, { .allow_blocking = On }, { .str = "correction: state; =1 on, =0 off" } },
    };
    static sys_commands_t registered = { .n_commands = 1, .commands = commands };

    /* The core calls the hooks before `start`; its own kinematics are set later and overwrite them. */
    if (!kinematics.segment_line) {
        kinematics = trueaxis_cartesian();
    }
    on_report_options = grbl.on_report_options;
    grbl.on_report_options = report_options;
    system_register_commands(&registered);
    task_run_on_startup(start, NULL);
}
