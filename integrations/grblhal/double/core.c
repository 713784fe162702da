/*
 * A double of grblHAL's core around its kinematics hooks: starts, homes, passes lines to a planner that rounds them
 * to steps, queues them and executes them step by step; holds, drops its queue, jogs, probes, parks. The behaviour
 * follows the core's documentation and public source; no line is copied from it.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */
#include "core.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define QUEUE 10 /* the core has 35 by default; with fewer, lines wait for room more often */

kinematics_t kinematics;
settings_t settings;
system_t sys;
parser_state_t gc_state;
grbl_t grbl;
grbl_hal_t hal;

block_t blocks[BLOCKS];
unsigned block_count, core_sampling = 100000;
char told[2048];
bool soft_limit_alarm, busy;
void (*core_stepped)(void);
void (*core_held)(void);
bool (*core_touched)(void);

static int32_t planned[N_AXIS];
static sys_state_t state;
static sys_commands_t *registered;
static foreground_task_ptr startup;
static void *startup_data;

/* The planner's queue, and the block being executed, which has left the queue. */
typedef struct {
    int32_t from[N_AXIS], delta[N_AXIS], events, done;
} moving_t;
static moving_t queue[QUEUE], moving, parked_from;
static unsigned queued;
static bool stepping, parking;
static unsigned braking; /* steps until a hold has reached standstill, 0: no hold */

/* Requests to the foreground. */
enum { CYCLE_START = 1, FEED_HOLD = 2, MOTION_CANCEL = 4, DOOR = 8, CYCLE_COMPLETE = 16, RESET = 32, STOP = 64 };
static volatile unsigned requests;
static unsigned interrupt_after;
static void (*interrupt)(void);

static struct {
    bool active, motion;
    float restore_target[N_AXIS], waypoint;
    int stage;
} park;

static unsigned random_below(unsigned end) {
    static uint32_t random = 1;
    random = random * 1664525u + 1013904223u;
    return (unsigned)((random >> 8) % end);
}

static void write(const char *text) {
    strncat(told, text, sizeof told - strlen(told) - 1);
}

static void no_options(bool newopt) {
    (void)newopt;
}

static void nothing_else(sys_state_t now) {
    (void)now;
}

/* Like the core, it cannot check motor coordinates here, and reports them as outside. */
static bool within(float *target, axes_signals_t axes, bool is_cartesian, work_envelope_t *envelope) {
    for (int idx = 0; idx < N_AXIS && is_cartesian; idx++) {
        if ((sys.homed.mask & axes.mask & bit(idx)) &&
            (target[idx] < envelope->min.values[idx] || target[idx] > envelope->max.values[idx])) {
            return false;
        }
    }
    return is_cartesian;
}

/* Checks the corners of the box around the arc's whole circle; the core checks the box around the arc. */
static bool arc_within(coord_data_t *target, coord_data_t *position, point_2d_t center, float radius, plane_t plane, int32_t turns,
                       work_envelope_t *envelope) {
    coord_data_t low = *position, high = *target;
    (void)turns;
    low.values[plane.axis_0] = center.x - radius, high.values[plane.axis_0] = center.x + radius;
    low.values[plane.axis_1] = center.y - radius, high.values[plane.axis_1] = center.y + radius;
    return grbl.check_travel_limits(low.values, sys.soft_limits, true, envelope) &&
           grbl.check_travel_limits(high.values, sys.soft_limits, true, envelope);
}

/* Shortens a motion of several axes along its line to the point where it leaves the travel, then limits each axis. */
static void cut(float *target, float *position, work_envelope_t *envelope) {
    int moving_axes = 0;
    for (int idx = 0; position && idx < 3; idx++) {
        moving_axes += fabsf(target[idx] - position[idx]) > 0.001f;
    }
    for (int idx = 0; moving_axes > 1 && (sys.homed.mask & 7) == 7 && idx < 3; idx++) {
        float limit = target[idx] < envelope->min.values[idx] ? envelope->min.values[idx] : envelope->max.values[idx];
        if (target[idx] < envelope->min.values[idx] || target[idx] > envelope->max.values[idx]) {
            float along = target[idx] - position[idx]; /* zero: gives infinity, as in the core */
            for (int other = 0; other < 3; other++) {
                if (other != idx) {
                    target[other] = (target[other] - position[other]) / along * (limit - position[idx]) + position[other];
                }
            }
            target[idx] = limit;
        }
    }
    for (int idx = 0; idx < N_AXIS; idx++) {
        if (sys.homed.mask & bit(idx)) {
            target[idx] = fmaxf(fminf(target[idx], envelope->max.values[idx]), envelope->min.values[idx]);
        }
    }
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
    kinematics.transform_steps_to_cartesian((coord_data_t *)position, (mpos_t *)steps);
}

/* Returns NULL also while the last block is executed, because that block is no longer in the queue. */
plan_block_t *plan_get_current_block(void) {
    return busy ? (plan_block_t *)blocks : queued ? (plan_block_t *)queue : NULL;
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

void plan_data_init(plan_line_data_t *pl_data) {
    memset(pl_data, 0, sizeof *pl_data);
    pl_data->condition.target_validated = pl_data->condition.target_valid = sys.soft_limits.mask == 0;
}

bool st_is_stepping(void) {
    return stepping;
}

static void st_reset(void) {
    stepping = parking = false;
    braking = 0;
    moving.events = 0;
}

/* Plans a block, with zero events if nothing moves. System motions start from the motors' position. */
static moving_t planned_block(const float *target, const int32_t *from, int32_t *end) {
    moving_t block = { 0 };
    for (int idx = 0; idx < N_AXIS; idx++) {
        end[idx] = (int32_t)lroundf(target[idx] * settings.axis[idx].steps_per_mm);
        block.from[idx] = from[idx];
        block.delta[idx] = end[idx] - from[idx];
        block.events = block.events > abs(block.delta[idx]) ? block.events : abs(block.delta[idx]);
    }
    return block;
}

/* Returns false if nothing moves. */
static bool plan_buffer_line(const float *target, const plan_line_data_t *pl_data) {
    int32_t end[N_AXIS];
    moving_t block = planned_block(target, pl_data->condition.system_motion ? sys.position : planned, end);
    if (!block.events) {
        return false;
    }
    if (pl_data->condition.system_motion) {
        parked_from = moving;
        moving = block;
        parking = true;
        return true;
    }
    memcpy(planned, end, sizeof planned);
    queue[queued++] = block;
    if (block_count < BLOCKS) {
        block_t *record = &blocks[block_count++];
        memcpy(record->steps, planned, sizeof planned);
        record->feed_rate = pl_data->feed_rate;
        record->inverse_time = pl_data->condition.inverse_time;
    }
    return true;
}

/* Takes steps of the longest axis, each with its interrupt. If nobody waits for an interrupt, takes up to a whole block
 * at once. */
static unsigned step(unsigned most) {
    if (!moving.events || moving.done == moving.events) {
        moving.events = 0;
        if (parking || !queued) {
            stepping = false;
            braking = 0;
            requests |= CYCLE_COMPLETE;
            return most;
        }
        moving = queue[0];
        memmove(queue, queue + 1, --queued * sizeof *queue);
    }
    unsigned left = (unsigned)(moving.events - moving.done), steps = most < left ? most : left;
    if (core_stepped || sys.probing_state == Probing_Active || interrupt_after || braking) {
        steps = 1;
    }
    moving.done += (int32_t)steps;
    for (int idx = 0; idx < N_AXIS; idx++) {
        int64_t size = abs(moving.delta[idx]), done = (size * moving.done + moving.events / 2) / moving.events;
        sys.position[idx] = moving.from[idx] + (int32_t)(moving.delta[idx] < 0 ? -done : done);
    }
    if (core_stepped) {
        core_stepped();
    }
    if (sys.probing_state == Probing_Active && core_touched && core_touched()) {
        sys.probing_state = Probing_Off;
        memcpy(sys.probe_position, sys.position, sizeof sys.position);
        requests |= MOTION_CANCEL;
    }
    if (interrupt_after && --interrupt_after == 0) {
        interrupt();
    }
    if (braking && --braking == 0) {
        stepping = false;
        requests |= CYCLE_COMPLETE;
    }
    return moving.done == moving.events ? most : steps; /* the foreground prepares the next block */
}

static void brake(void) {
    braking = 1 + random_below(60);
}

static void drop_queue(void) {
    queued = 0;
    st_reset();
    sync_position();
}

static void wake_up(void) {
    stepping = true;
}

/* Passes tool coordinates, as they were read, straight to the planner. */
static bool parking_motion(float *target) {
    plan_line_data_t pl_data = { .condition.system_motion = 1 };
    bool moves = plan_buffer_line(target, &pl_data);
    if (moves) {
        sys.step_control.execute_sys_motion = On;
        wake_up();
    }
    return moves;
}

static void parking_done(void) {
    if (sys.step_control.execute_sys_motion) {
        sys.step_control.execute_sys_motion = Off;
        moving = parked_from;
        parking = false;
    }
}

/* Parks in stages: out of the workpiece, to the parking place, back to in front of the workpiece, into it. */
static void park_on(void) {
    float target[N_AXIS];
    bool moves = false;
    while (!moves && park.active) {
        parking_done();
        memcpy(target, park.restore_target, sizeof target);
        switch (park.stage++) {
        case 0:
            target[settings.parking.axis] = park.waypoint;
            moves = park.motion && parking_motion(target);
            break;
        case 1:
            target[settings.parking.axis] = settings.parking.target;
            moves = park.motion && parking_motion(target);
            break;
        case 2:
            sys.parking_state = Parking_DoorClosed;
            if (core_held) {
                core_held(); /* no report until the operator has closed the door */
            }
            return;
        case 3:
            sys.parking_state = Parking_Resuming;
            target[settings.parking.axis] = park.waypoint;
            moves = park.motion && parking_motion(target);
            break;
        case 4:
            moves = park.motion && parking_motion(target);
            break;
        default:
            park.active = false;
            sys.suspend = false;
            sys.parking_state = Parking_DoorClosed;
            core_state(STATE_IDLE);
            requests |= CYCLE_START;
        }
    }
}

static void at_standstill(void) {
    switch (state) {
    case STATE_JOG:
        if (sys.suspend) { /* cancelled */
            sys.step_control.flags = 0;
            drop_queue();
            sys.suspend = false;
        }
        core_state(STATE_IDLE);
        break;
    case STATE_CYCLE: /* at the end of the queue, or after a probe has triggered */
        sys.suspend = false;
        sys.step_control.flags = 0;
        core_state(STATE_IDLE);
        break;
    case STATE_HOLD:
        sys.step_control.flags = 0;
        if (core_held) {
            core_held();
        }
        break;
    case STATE_SAFETY_DOOR:
        if (!park.active) {
            sys.step_control.flags = 0;
            park.active = true;
            park.stage = 0;
            system_convert_array_steps_to_mpos(park.restore_target, sys.position);
            float at = park.restore_target[settings.parking.axis];
            park.motion = settings.parking.flags.enabled && (sys.homed.mask & bit(settings.parking.axis)) && at < settings.parking.target;
            park.waypoint = fminf(at + settings.parking.pullout_increment, settings.parking.target);
        }
        park_on();
        break;
    }
}

static void serve(void) {
    unsigned now = requests;
    requests = 0;
    if (now & RESET) {
        sys.abort = true;
        return;
    }
    if (now & STOP) {
        sys.cancel = true;
        sys.step_control.flags = 0;
        if (stepping) {
            brake();
        }
        while (stepping) {
            step(1);
            grbl.on_execute_realtime(state);
        }
        requests = 0;
        drop_queue();
        sys.suspend = false;
        core_state(STATE_IDLE);
        return;
    }
    if (now & (FEED_HOLD | DOOR) && (state == STATE_CYCLE || state == STATE_IDLE)) {
        bool moves = stepping;
        now &= ~(unsigned)(CYCLE_COMPLETE | CYCLE_START);
        sys.suspend = true;
        if (now & DOOR) {
            sys.parking_state = Parking_Retracting;
            park.active = false;
        }
        if (moves) {
            sys.step_control.execute_hold = On;
            brake();
        }
        core_state(now & DOOR ? STATE_SAFETY_DOOR : STATE_HOLD);
        if (!moves) {
            at_standstill();
        }
    }
    if ((now & MOTION_CANCEL) && (state & (STATE_JOG | STATE_CYCLE)) && stepping && !sys.suspend) {
        sys.suspend = true;
        sys.step_control.execute_hold = On;
        brake();
    }
    if (now & CYCLE_COMPLETE) {
        at_standstill();
    }
    if (now & CYCLE_START) {
        if (state == STATE_HOLD && !stepping) {
            sys.suspend = false;
            core_state(STATE_IDLE);
        }
        if (state == STATE_SAFETY_DOOR && park.stage == 3) {
            park_on();
        } else if (state == STATE_IDLE && (moving.events || queued)) {
            core_state(STATE_CYCLE);
            wake_up();
        }
    }
}

/* Runs one pass of the foreground loop and takes the steps during it. Returns false on a reset or a stop; the caller then
 * gives up. */
static bool protocol_execute_realtime(void) {
    do {
        if (requests) {
            serve();
        }
        grbl.on_execute_realtime(state);
        for (unsigned steps = 1 + random_below(core_sampling); stepping && steps;) {
            steps -= step(steps);
        }
    } while (sys.suspend && !sys.abort && (stepping || requests));
    return !(sys.abort || sys.cancel);
}

static void auto_cycle_start(void) {
    if (plan_get_current_block()) {
        requests |= CYCLE_START;
    }
}

/* The main loop restarts after a reset. Position is lost if the motors were moving. */
static void start_anew(void) {
    if (sys.abort) {
        bool lost = stepping;
        sys.abort = sys.cancel = sys.suspend = false;
        sys.step_control.flags = 0;
        sys.parking_state = Parking_DoorClosed;
        park.active = false;
        requests = 0;
        drop_queue();
        core_state(lost ? STATE_ALARM : STATE_IDLE);
    }
    sys.cancel = false;
}

void core_finish(void) {
    do {
        auto_cycle_start();
        protocol_execute_realtime();
    } while (!sys.abort && (stepping || requests || (state == STATE_IDLE && queued)));
    start_anew();
}

status_code_t mc_line(float *target, plan_line_data_t *pl_data) {
    float feed_rate = pl_data->feed_rate;

    pl_data->rate_multiplier = 1.0f;
    float *point = kinematics.segment_line((coord_data_t *)target, (coord_data_t *)plan_get_position(), pl_data, true)->values;
    soft_limit_alarm = pl_data->condition.target_validated
                           ? !pl_data->condition.target_valid
                           : !grbl.check_travel_limits(point, sys.soft_limits, false, &sys.work_envelope);
    if (soft_limit_alarm) {
        return Status_Aborted;
    }
    if (state != STATE_CHECK_MODE && protocol_execute_realtime()) {
        /* All points share one storage, and the feed returns to the programmed one after every block. */
        while (kinematics.segment_line((coord_data_t *)point, NULL, pl_data, false)) {
            for (;;) {
                if (!protocol_execute_realtime()) {
                    return Status_Aborted;
                }
                if (queued < QUEUE) {
                    break;
                }
                auto_cycle_start();
            }
            /* Moves to the present value of the point: the queue may have been dropped while it was full. */
            plan_buffer_line(point, pl_data);
            if (pl_data->condition.jog_motion && state == STATE_IDLE && plan_get_current_block()) {
                core_state(STATE_JOG);
                wake_up();
            }
            pl_data->feed_rate = feed_rate;
        }
    }
    return sys.abort || sys.cancel ? Status_Aborted : Status_Handled;
}

bool mc_arc(float *target, plan_line_data_t *pl_data, float *offset, float radius, int32_t turns) {
    static const plane_t plane = { 0, 1, 2 };
    coord_data_t from, to;
    memcpy(from.values, gc_state.position, sizeof from.values);
    memcpy(to.values, target, sizeof to.values);
    point_2d_t center = { from.x + offset[0], from.y + offset[1] };
    float begin = atan2f(from.y - center.y, from.x - center.x), angle = atan2f(to.y - center.y, to.x - center.x) - begin;
    angle += turns > 0 && angle <= 0.0f ? 6.2831853f : turns < 0 && angle >= 0.0f ? -6.2831853f : 0.0f;
    if (!pl_data->condition.target_validated && grbl.check_arc_travel_limits) {
        pl_data->condition.target_validated = On;
        pl_data->condition.target_valid =
            grbl.check_arc_travel_limits(&to, &from, center, radius, plane, turns, &sys.work_envelope);
    }
    int segments = 1 + (int)fabsf(0.5f * angle * radius / sqrtf(settings.arc_tolerance * (2.0f * radius - settings.arc_tolerance)));
    for (int i = 1; i <= segments; i++) {
        float share = (float)i / (float)segments, chord[N_AXIS];
        memcpy(chord, target, sizeof chord);
        chord[0] = i == segments ? target[0] : center.x + radius * cosf(begin + angle * share);
        chord[1] = i == segments ? target[1] : center.y + radius * sinf(begin + angle * share);
        chord[2] = from.z + (to.z - from.z) * share;
        if (!mc_line(chord, pl_data)) {
            return false;
        }
    }
    return true;
}

/* Updates the program's position as the parser does. */
status_code_t core_line(const float *target, plan_line_data_t pl_data) {
    float end[N_AXIS];
    memcpy(end, target, sizeof end);
    status_code_t status = mc_line(end, &pl_data);
    if (status && !sys.cancel) {
        memcpy(gc_state.position, end, sizeof gc_state.position);
    }
    start_anew();
    return status;
}

/* The target of the jog becomes the program's position, however the jog ended. */
status_code_t core_jog(const float *target, plan_line_data_t pl_data) {
    float end[N_AXIS];
    memcpy(end, target, sizeof end);
    pl_data.condition.jog_motion = pl_data.condition.target_validated = pl_data.condition.target_valid = On;
    if (settings.limits.flags.jog_soft_limited) {
        grbl.apply_travel_limits(end, gc_state.position, &sys.work_envelope);
    } else if (sys.soft_limits.mask && !grbl.check_travel_limits(end, sys.soft_limits, true, &sys.work_envelope)) {
        return Status_TravelExceeded;
    }
    mc_line(end, &pl_data);
    memcpy(gc_state.position, end, sizeof gc_state.position);
    start_anew();
    return Status_OK;
}

/* Returns whether the probe triggered. */
bool core_probe(const float *target, plan_line_data_t pl_data) {
    float end[N_AXIS];
    memcpy(end, target, sizeof end);
    core_finish();
    if (settings.probe.soft_limited) {
        grbl.apply_travel_limits(end, NULL, &sys.work_envelope);
    }
    sys.flags.probe_succeeded = Off;
    if (!mc_line(end, &pl_data)) {
        start_anew();
        return false;
    }
    sys.probing_state = Probing_Active;
    requests |= CYCLE_START;
    do {
        protocol_execute_realtime();
    } while (!sys.abort && state != STATE_IDLE);
    if (sys.probing_state == Probing_Active) {
        memcpy(sys.probe_position, sys.position, sizeof sys.position);
    } else {
        sys.flags.probe_succeeded = On;
    }
    sys.probing_state = Probing_Off;
    queued = 0;
    st_reset();
    plan_sync_position();
    gc_sync_position();
    start_anew();
    return sys.flags.probe_succeeded;
}

void core_interrupt(unsigned steps, void (*request)(void)) {
    interrupt_after = steps;
    interrupt = request;
}

void core_jog_cancel(void) {
    if (state & STATE_JOG) {
        requests |= MOTION_CANCEL;
    }
    if (grbl.on_jog_cancel) {
        grbl.on_jog_cancel(state);
    }
}

void core_feed_hold(void) {
    requests |= FEED_HOLD;
}

void core_door(void) {
    requests |= DOOR;
}

void core_stop(void) {
    requests |= STOP;
}

void core_cycle_start(void) {
    requests |= CYCLE_START;
}

void core_reset(void) {
    requests |= RESET;
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
            /* A move towards the switch and beyond it; the other axes do not move. */
            coord_data_t target, motors;
            plan_line_data_t pl_data = { .feed_rate = 500.0f };
            system_convert_array_steps_to_mpos(target.values, sys.position);
            kinematics.limits_set_target_pos((uint_fast8_t)idx);
            target.values[idx] = 1.5f * settings.axis[idx].max_travel;
            plan_sync_position();
            plan_buffer_line(kinematics.transform_from_cartesian(&motors, &target)->values, &pl_data);
            memcpy(sys.position, planned, sizeof planned); /* at once */
            queued = 0;
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
    grbl.on_execute_realtime = nothing_else;
    grbl.check_travel_limits = within;
    grbl.check_arc_travel_limits = arc_within;
    grbl.apply_travel_limits = cut;
    queued = 0;
    requests = 0;
    interrupt_after = 0;
    st_reset();
    my_plugin_init(); /* called by the driver, before the core's own kinematics are set */
    if (own_kinematics) {
        own_kinematics();
    }
    sync_position();
    startup(startup_data);
}
