/*
 * trueaxis for grblHAL: geometric error compensation around the kinematics that are there.
 *
 * This file becomes part of a grblHAL firmware and uses its interface, so it stands under grblHAL's licence.
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#include <math.h>
#include <string.h>

#include "grbl/hal.h"

#include "grbl/gcode.h"
#include "grbl/machine_limits.h"
#include "grbl/planner.h"
#include "grbl/state_machine.h"
#include "grbl/task.h"

#include "grbl/kinematics/interface.h"

#include "trueaxis_correction.h"

#ifndef TRUEAXIS_MACHINE_ID
#define TRUEAXIS_MACHINE_ID 0 /* any; `trueaxis tables show` prints a machine's */
#endif
#ifndef TRUEAXIS_SEGMENT_MM
#define TRUEAXIS_SEGMENT_MM 2.0f /* longest stretch between two look-ups on a line */
#endif
#ifndef TRUEAXIS_CHORD_MM
#define TRUEAXIS_CHORD_MM 0.0005f /* a stretch is halved while its middle lies further off */
#endif
#ifndef TRUEAXIS_HYSTERESIS_MM
#define TRUEAXIS_HYSTERESIS_MM 0.0003f /* a drive that comes back by more has turned */
#endif
#define HALVINGS 4
#define TICKS (1u << HALVINGS) /* of a longest stretch */

/* tables.S, or where else the .tcomp lies. */
extern const uint8_t trueaxis_tables[], trueaxis_tables_end[];

static kinematics_t present; /* the kinematics below: the core's, or cartesian */
static on_state_change_ptr on_state_change;
static on_homing_completed_ptr on_homing_completed;
static on_jog_cancel_ptr on_jog_cancel;
static on_report_options_ptr on_report_options;
static bool (*check_travel_limits)(float *target, axes_signals_t axes, bool is_cartesian, work_envelope_t *envelope);

static bool loaded;           /* the tables hold for this machine */
static bool wanted = true;    /* by the operator */
static bool correcting;       /* changes only with the position taken over from the steps, and never amid a line */
static uint8_t negative;      /* bits of the drives that last moved in their negative direction */
static coord_data_t furthest; /* where each drive came to in its direction */
static const char *refusal = "not started";
static volatile bool jog_cancelled;

static struct {
    bool corrected, inside; /* this line was begun corrected; `present` has a stretch in work */
    uint32_t tick, ticks, stretch;
    float length, rate_multiplier;
    coord_data_t start, change, last; /* machine coordinates: begin, end − begin, end of the line before */
    coord_data_t drive;               /* corrected, at `tick` */
    coord_data_t from, motor;         /* motors: where the planner stands, what it is handed */
    coord_data_t *below;              /* of the stretch in `present` */
    bool rapid, turned;               /* `turned`: lost motion was taken up at `tick` */
} line;

/* In machine coordinates, so that neither motors nor a correction of micrometres refuse a line to the very limit. */
static void validate(const coord_data_t *target, plan_line_data_t *pl_data) {
    if (!pl_data->condition.target_validated) {
        coord_data_t end = *target;
        pl_data->condition.target_validated = On;
        pl_data->condition.target_valid = grbl.check_travel_limits(end.values, sys.soft_limits, true, &sys.work_envelope);
    }
}

/* Cartesian kinematics, for a core that has none of its own. */

static coord_data_t *cartesian_from_steps(coord_data_t *position, mpos_t *steps) {
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        position->values[idx] = (float)steps->values[idx] / settings.axis[idx].steps_per_mm;
    }
    return position;
}

static coord_data_t *cartesian_to_motors(coord_data_t *target, coord_data_t *position) {
    return memcpy(target, position, sizeof *target);
}

static coord_data_t *cartesian_line(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init) {
    static coord_data_t end;
    static bool handed;

    (void)position;
    if (init) {
        validate(target, pl_data);
        end = *target;
        handed = false;
        return &end;
    }
    return handed ? NULL : (handed = true, &end);
}

static uint_fast8_t cartesian_axis_mask(uint_fast8_t idx) {
    return bit(idx);
}

static void cartesian_homing_start(uint_fast8_t idx) {
    sys.position[idx] = 0;
}

static void cartesian_homed(axes_signals_t cycle) {
    limits_set_machine_positions(cycle, true);
}

static bool cartesian_homing_valid(axes_signals_t cycle) {
    (void)cycle;
    return true;
}

static float cartesian_homing_rate(axes_signals_t cycle, float rate, homing_mode_t mode) {
    (void)cycle, (void)mode;
    return rate;
}

/* The corrected hooks. */

static coord_data_t *from_steps(coord_data_t *position, mpos_t *steps) {
    present.transform_steps_to_cartesian(position, steps);
    if (correcting) {
        trueaxis_correction_inverse(position->values, negative, position->values);
    }
    return position;
}

static coord_data_t *to_motors(coord_data_t *target, coord_data_t *position) {
    coord_data_t drive = *position;
    if (correcting) {
        trueaxis_correction_forward(drive.values, negative, drive.values);
    }
    return present.transform_from_cartesian(target, &drive);
}

/* Corrected position after `tick` of the line; half ticks by doubling both. */
static void drive_at(uint32_t tick, uint32_t ticks, coord_data_t *drive) {
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        drive->values[idx] = line.start.values[idx] + line.change.values[idx] * ((float)tick / (float)ticks);
    }
    trueaxis_correction_forward(drive->values, negative, drive->values);
}

static float distance(const coord_data_t *a, const coord_data_t *b) {
    float sum = 0.0f;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        sum += (a->values[idx] - b->values[idx]) * (a->values[idx] - b->values[idx]);
    }
    return sqrtf(sum);
}

/* The largest of |a − b| and so on, in steps of each axis. */
static float steps_between(const coord_data_t *a, const coord_data_t *b) {
    float most = 0.0f;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        most = fmaxf(most, fabsf(a->values[idx] - b->values[idx]) * settings.axis[idx].steps_per_mm);
    }
    return most;
}

/* At the switch of a homed axis the tool stands beside the drive's position by the correction there, and with it beside the
   limits. The largest correction of the tables is allowed, or every line that leaves the axis where it is would be refused. */
static bool within_travel(float *target, axes_signals_t axes, bool is_cartesian, work_envelope_t *envelope) {
    const trueaxis_tables_info_t *info = trueaxis_correction_tables();
    coord_data_t end;

    memcpy(end.values, target, sizeof end.values);
    for (unsigned slot = 0; correcting && is_cartesian && slot < info->axes; slot++) {
        unsigned idx = trueaxis_correction_axis(slot);
        float low = envelope->min.values[idx], high = envelope->max.values[idx], slack = (float)info->correction_limit[slot];
        if (end.values[idx] < low && end.values[idx] >= low - slack) {
            end.values[idx] = low;
        } else if (end.values[idx] > high && end.values[idx] <= high + slack) {
            end.values[idx] = high;
        }
    }
    return check_travel_limits(end.values, axes, is_cartesian, envelope);
}

/* Begins a line: its start from the planner's steps, the stretches. */
static coord_data_t *begin(const coord_data_t *target, const coord_data_t *position, plan_line_data_t *pl_data) {
    static const coord_data_t nowhere;
    coord_data_t end;
    mpos_t steps;

    validate(target, pl_data);
    line.from = *position;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        steps.values[idx] = (int32_t)lroundf(position->values[idx] * settings.axis[idx].steps_per_mm);
    }
    present.transform_steps_to_cartesian(&line.drive, &steps);
    trueaxis_correction_inverse(line.drive.values, negative, line.start.values);
    /* The end of the line before, where that is what the planner rounded to its steps: an axis that is not commanded then
       does not move at all. */
    if (steps_between(&line.start, &line.last) < 1.5f) {
        line.start = line.last;
    }
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        line.change.values[idx] = target->values[idx] - line.start.values[idx];
    }
    line.last = *target;
    line.length = distance(&line.change, &nowhere);
    line.rate_multiplier = pl_data->rate_multiplier;
    line.tick = 0;
    line.ticks = TICKS * (pl_data->condition.rapid_motion ? 1 : 1 + (uint32_t)(line.length / TRUEAXIS_SEGMENT_MM));
    line.stretch = TICKS;
    line.rapid = pl_data->condition.rapid_motion;

    line.inside = line.turned = false;
    drive_at(0, line.ticks, &line.drive);
    drive_at(line.ticks, line.ticks, &end);
    return present.transform_from_cartesian(&line.motor, &end);
}

/* Do drives turn on the way to `ahead`? Their bits change. A drive turns also where its axis is not commanded and only the
   correction of the others' motion moves it. */
static bool turn(const coord_data_t *ahead) {
    bool turned = false;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        float back = furthest.values[idx] - ahead->values[idx];
        if ((negative & bit(idx) ? -back : back) > TRUEAXIS_HYSTERESIS_MM) {
            negative ^= (uint8_t)bit(idx);
            furthest.values[idx] = line.drive.values[idx];
            turned = true;
        }
    }
    return turned;
}

/* Finds the next stretch: `drive` becomes its end. */
static void find_stretch(void) {
    coord_data_t reached, middle, chord;

    if (line.stretch < TICKS && line.tick % (2 * line.stretch) == 0) {
        line.stretch *= 2;
    }
    coord_data_t ahead;
    drive_at(line.tick + line.stretch, line.ticks, &ahead);
    if (!line.turned && turn(&ahead)) {
        /* Lost motion is taken up before the tool moves on. */
        reached = line.drive;
        drive_at(line.tick, line.ticks, &line.drive);
        line.turned = true;
        if (steps_between(&reached, &line.drive) > 0.5f) {
            return;
        }
        drive_at(line.tick + line.stretch, line.ticks, &ahead);
    }
    while (!line.rapid && line.stretch > 1) {
        drive_at(2 * line.tick + line.stretch, 2 * line.ticks, &middle);
        for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
            chord.values[idx] = 0.5f * (line.drive.values[idx] + ahead.values[idx]);
        }
        if (distance(&middle, &chord) <= TRUEAXIS_CHORD_MM) {
            break;
        }
        line.stretch /= 2;
        ahead = middle;
    }
    line.turned = false;
    line.drive = ahead;
    line.tick += line.stretch;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        bool further = negative & bit(idx) ? ahead.values[idx] < furthest.values[idx] : ahead.values[idx] > furthest.values[idx];
        if (further) {
            furthest.values[idx] = ahead.values[idx];
        }
    }
}

/* Hands the next stretch to the kinematics below. */
static void next_stretch(plan_line_data_t *pl_data) {
    coord_data_t reached = line.drive;

    find_stretch();
    pl_data->rate_multiplier = line.rate_multiplier; /* the feed itself the core sets back after every block */
    float stretch = distance(&reached, &line.drive);
    if (pl_data->condition.inverse_time && stretch > 0.0f) {
        pl_data->feed_rate *= line.length / stretch;
    }
    coord_data_t target = line.drive;
    line.below = present.segment_line(&target, &line.from, pl_data, true);
    line.inside = true;
}

static coord_data_t *segment_line(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init) {
    if (init) {
        line.corrected = correcting;
        jog_cancelled = false;
    }
    if (!line.corrected) {
        return present.segment_line(target, position, pl_data, init);
    }
    if (init) {
        return begin(target, position, pl_data);
    }
    while (!jog_cancelled) {
        if (line.inside) {
            coord_data_t *point = present.segment_line(line.below, NULL, pl_data, false);
            if (point) {
                line.motor = line.from = *point;
                return &line.motor;
            }
            line.inside = false;
        } else if (line.tick < line.ticks) {
            next_stretch(pl_data);
        } else {
            break;
        }
    }
    return NULL;
}

/* Switching: nothing moves, the program's position is taken over from the steps anew. */

static void drives_at_steps(coord_data_t *drive) {
    mpos_t steps;
    memcpy(steps.values, sys.position, sizeof steps.values);
    present.transform_steps_to_cartesian(drive, &steps);
}

static void correct(bool on) {
    if (correcting != on) {
        correcting = on;
        sync_position();
        memcpy(line.last.values, gc_state.position, sizeof line.last.values);
        drives_at_steps(&furthest);
    }
}

static bool homed(void) {
    uint8_t needed = trueaxis_correction_axes();
    return (sys.homed.mask & needed) == needed;
}

static void homing_completed(axes_signals_t cycle, bool success) {
    if (success && loaded && wanted && homed()) {
        negative = (uint8_t)~settings.homing.dir_mask.mask; /* it came off the switch last */
        correct(true);
        report_message("trueaxis: correction on", Message_Info);
    }
    if (on_homing_completed) {
        on_homing_completed(cycle, success);
    }
}

/* Homing finds the drives' own zero, and without it no position is known. */
static void state_changed(sys_state_t state) {
    if (correcting && (state == STATE_HOMING || ((state == STATE_IDLE || state == STATE_ALARM) && !homed()))) {
        correct(false);
        if (state != STATE_HOMING) {
            report_message("trueaxis: position lost, running uncompensated until homed", Message_Warning);
        }
    }
    if (on_state_change) {
        on_state_change(state);
    }
}

static void jog_cancel(sys_state_t state) {
    jog_cancelled = true;
    if (on_jog_cancel) {
        on_jog_cancel(state);
    }
}

/* What is told. */

static void tell_state(void) {
    hal.stream.write(correcting ? "[TRUEAXIS:on" : "[TRUEAXIS:uncompensated, ");
    hal.stream.write(correcting ? "" : !loaded ? refusal : !wanted ? "switched off" : "not homed");
}

static void report_options(bool newopt) {
    on_report_options(newopt);
    if (!newopt) {
        report_plugin("trueaxis", "1");
        tell_state();
        hal.stream.write("]" ASCII_EOL);
    }
}

/* $TRUEAXIS tells, $TRUEAXIS=1 and =0 switch. */
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
    if (correcting) {
        coord_data_t here, drive;
        system_convert_array_steps_to_mpos(here.values, sys.position);
        drive = here;
        trueaxis_correction_forward(here.values, negative, drive.values);
        for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
            hal.stream.write(idx ? "," : "|C:");
            hal.stream.write(ftoa(drive.values[idx] - here.values[idx], 4));
        }
    }
    hal.stream.write("]" ASCII_EOL);
    return Status_OK;
}

/* NULL, or an axis whose whole travel the tables know nothing of: measured in other coordinates, or on another machine. */
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

/* After everything else has started, before a line is read: around the kinematics that are there by now. */
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

    present = kinematics;
    kinematics.transform_steps_to_cartesian = from_steps;
    kinematics.transform_from_cartesian = to_motors;
    kinematics.segment_line = segment_line;
    check_travel_limits = grbl.check_travel_limits;
    grbl.check_travel_limits = within_travel;
    on_state_change = grbl.on_state_change;
    grbl.on_state_change = state_changed;
    on_homing_completed = grbl.on_homing_completed;
    grbl.on_homing_completed = homing_completed;
    on_jog_cancel = grbl.on_jog_cancel;
    grbl.on_jog_cancel = jog_cancel;
}

void my_plugin_init(void) {
    static const sys_command_t commands[] = {
        { "TRUEAXIS", command, { .allow_blocking = On }, { .str = "correction: state; =1 on, =0 off" } },
    };
    static sys_commands_t registered = { .n_commands = 1, .commands = commands };

    /* The core calls the hooks before `start`; kinematics of its own come after this and overwrite them. */
    if (!kinematics.segment_line) {
        kinematics = (kinematics_t){
            .transform_steps_to_cartesian = cartesian_from_steps,
            .transform_from_cartesian = cartesian_to_motors,
            .segment_line = cartesian_line,
            .limits_get_axis_mask = cartesian_axis_mask,
            .limits_set_target_pos = cartesian_homing_start,
            .limits_set_machine_positions = cartesian_homed,
            .homing_cycle_validate = cartesian_homing_valid,
            .homing_cycle_get_feedrate = cartesian_homing_rate,
        };
    }
    on_report_options = grbl.on_report_options;
    grbl.on_report_options = report_options;
    system_register_commands(&registered);
    task_run_on_startup(start, NULL);
}
