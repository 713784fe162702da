/*
 * Divides a line into segments whose ends are corrected.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#include <math.h>
#include <string.h>

#include "trueaxis_kinematics.h"

#ifndef TRUEAXIS_SEGMENT_MM
#define TRUEAXIS_SEGMENT_MM 2.0f /* longest stretch between two look-ups on a line */
#endif
#ifndef TRUEAXIS_CHORD_MM
#define TRUEAXIS_CHORD_MM 0.0005f /* a stretch is halved while its middle lies further off */
#endif
#define HALVINGS 4
#define TICKS (1u << HALVINGS) /* of a longest stretch */

static struct {
    bool corrected, inside; /* the line began with correction; `present` is processing a segment */
    uint32_t tick, ticks, stretch;
    float length, rate_multiplier;
    coord_data_t start, change; /* machine coordinates: start, end − start */
    coord_data_t drive;         /* corrected, at `tick` */
    coord_data_t from, motor;   /* motors: position of the planner, and next target */
    coord_data_t *below;        /* of the segment in `present` */
    bool rapid, turned;         /* `turned`: lost motion was taken up at `tick` */
    bool amid;                  /* the drives stopped within their lost motion before this line */
    bool jog, handing;          /* `handing`: more of its points follow */
    coord_data_t *target;       /* the core's, while it passes the line on */
    mpos_t before;              /* motors: the point passed to the planner before `sent` */
} line;

/* Corrected position after `tick` of the line; for half ticks, double both arguments. */
static void drive_at(uint32_t tick, uint32_t ticks, coord_data_t *drive) {
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        drive->values[idx] = line.start.values[idx] + line.change.values[idx] * ((float)tick / (float)ticks);
    }
    trueaxis_correction_forward(drive->values, trueaxis_shared.planned.negative, drive->values);
}

static float distance(const coord_data_t *a, const coord_data_t *b) {
    float sum = 0.0f;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        sum += (a->values[idx] - b->values[idx]) * (a->values[idx] - b->values[idx]);
    }
    return sqrtf(sum);
}

/* Largest component of |a − b|, in steps of its axis. */
static float steps_between(const coord_data_t *a, const coord_data_t *b) {
    float most = 0.0f;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        most = fmaxf(most, fabsf(a->values[idx] - b->values[idx]) * settings.axis[idx].steps_per_mm);
    }
    return most;
}

static mpos_t to_steps(const coord_data_t *motor) {
    mpos_t steps;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        steps.values[idx] = (int32_t)lroundf(motor->values[idx] * settings.axis[idx].steps_per_mm);
    }
    return steps;
}

mpos_t trueaxis_planner_steps(void) {
    return to_steps((coord_data_t *)plan_get_position());
}

/* Whether the core has dropped the rest of its queue: the drives are at rest and the queue is empty, but the drives are
 * not at the planned end. If the steps agree, the program's position still shows the side of the lost motion. */
static bool stopped_elsewhere(const mpos_t *steps) {
    coord_data_t program;

    if (plan_get_current_block() || st_is_stepping() || !trueaxis_same_steps(steps->values, sys.position)) {
        return false;
    }
    trueaxis_follow();
    if (!trueaxis_same_steps(steps->values, trueaxis_shared.sent.values)) {
        return true;
    }
    if (trueaxis_shared.executed.negative == trueaxis_shared.planned.negative) {
        return false;
    }
    trueaxis_program(&program);
    return steps_between(&program, &trueaxis_shared.last) > 0.0f;
}

/* Begins a line: determines its start from the planner's steps, and its segments. */
static coord_data_t *begin(coord_data_t *target, const coord_data_t *position, plan_line_data_t *pl_data) {
    static const coord_data_t nowhere;
    coord_data_t end;
    mpos_t steps = to_steps(position);

    trueaxis_validate(target, pl_data);
    line.from = *position;
    line.before = steps;
    line.amid = false;
    if (stopped_elsewhere(&steps)) {
        trueaxis_take_over();
        line.start = trueaxis_shared.last;
        line.amid = true;
    } else {
        trueaxis_shared.sent = steps;
        trueaxis_shared.present.transform_steps_to_cartesian(&line.start, &steps);
        trueaxis_correction_inverse(line.start.values, trueaxis_shared.planned.negative, line.start.values);
    }
    /* Use the end of the previous line if the planner rounded it to these steps, so that an uncommanded axis does not move
     * at all. */
    if (steps_between(&line.start, &trueaxis_shared.last) < 1.5f) {
        line.start = trueaxis_shared.last;
    }
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        line.change.values[idx] = target->values[idx] - line.start.values[idx];
    }
    trueaxis_shared.last = *target;
    line.length = distance(&line.change, &nowhere);
    line.rate_multiplier = pl_data->rate_multiplier;
    line.tick = 0;
    line.ticks = TICKS * (pl_data->condition.rapid_motion ? 1 : 1 + (uint32_t)(line.length / TRUEAXIS_SEGMENT_MM));
    line.stretch = TICKS;
    line.rapid = pl_data->condition.rapid_motion;

    line.inside = line.turned = false;
    line.jog = pl_data->condition.jog_motion;
    line.handing = true;
    line.target = target;
    if (line.amid) {
        trueaxis_drives(&line.drive);
    } else {
        drive_at(0, line.ticks, &line.drive);
    }
    drive_at(line.ticks, line.ticks, &end);
    return trueaxis_shared.present.transform_from_cartesian(&line.motor, &end);
}

/* Returns the drives that turn on the way to `ahead`, and changes their bits. A drive also turns if its axis is not
 * commanded and only the correction for the motion of other axes moves it. */
static uint8_t turn(const coord_data_t *ahead) {
    uint8_t turned = 0;
    for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
        float back = trueaxis_shared.planned.furthest.values[idx] - ahead->values[idx];
        if ((trueaxis_shared.planned.negative & bit(idx) ? -back : back) > TRUEAXIS_HYSTERESIS_MM) {
            trueaxis_shared.planned.negative ^= (uint8_t)bit(idx);
            turned |= (uint8_t)bit(idx);
        }
    }
    return turned;
}

/* Finds the next segment; `drive` becomes its end. */
static void find_stretch(void) {
    coord_data_t reached, middle, chord;

    if (line.stretch < TICKS && line.tick % (2 * line.stretch) == 0) {
        line.stretch *= 2;
    }
    coord_data_t ahead;
    drive_at(line.tick + line.stretch, line.ticks, &ahead);
    uint8_t turned = line.turned ? 0 : turn(&ahead);
    if (turned || line.amid) {
        /* The drives take up lost motion before the tool continues. */
        line.amid = false;
        reached = line.drive;
        drive_at(line.tick, line.ticks, &line.drive);
        line.turned = true;
        for (uint_fast8_t idx = 0; idx < N_AXIS; idx++) {
            if (turned & bit(idx)) {
                trueaxis_shared.planned.furthest.values[idx] = line.drive.values[idx];
            }
        }
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
        float *furthest = &trueaxis_shared.planned.furthest.values[idx];
        if (trueaxis_shared.planned.negative & bit(idx) ? ahead.values[idx] < *furthest : ahead.values[idx] > *furthest) {
            *furthest = ahead.values[idx];
        }
    }
}

/* Passes the next segment to the kinematics below. */
static void next_stretch(plan_line_data_t *pl_data) {
    coord_data_t reached = line.drive;

    find_stretch();
    pl_data->rate_multiplier = line.rate_multiplier; /* the core restores the feed itself after every block */
    float stretch = distance(&reached, &line.drive);
    if (pl_data->condition.inverse_time && stretch > 0.0f) {
        pl_data->feed_rate *= line.length / stretch;
    }
    coord_data_t target = line.drive;
    line.below = trueaxis_shared.present.segment_line(&target, &line.from, pl_data, true);
    line.inside = true;
}

/* Whether a cancelled jog ends here. The core reports the command during program lines too, which must not end. */
static bool cancelled(void) {
    return line.jog && trueaxis_shared.jog_cancelled;
}

void trueaxis_line_dropped(void) {
    mpos_t steps = trueaxis_planner_steps();

    if (line.handing && !plan_get_current_block() &&
        (cancelled() || !(trueaxis_same_steps(steps.values, trueaxis_shared.sent.values) ||
                          trueaxis_same_steps(steps.values, line.before.values)))) {
        /* The core may hold the address of a point while it waits for room in the queue. Turn that point into a move of
         * zero length; otherwise the machine would continue to it from where it was stopped. */
        memcpy(line.motor.values, plan_get_position(), sizeof line.motor.values);
        line.handing = false;
        if (line.jog) {
            trueaxis_program(line.target); /* the core takes the program's position from here, not from where the jog stopped */
        }
    }
}

coord_data_t *trueaxis_segment_line(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init) {
    if (init) {
        line.corrected = trueaxis_shared.correcting;
        line.handing = false;
        trueaxis_shared.jog_cancelled = false;
    }
    if (!line.corrected) {
        return trueaxis_shared.present.segment_line(target, position, pl_data, init);
    }
    if (init) {
        return begin(target, position, pl_data);
    }
    while (line.handing && !cancelled()) {
        if (line.inside) {
            coord_data_t *point = trueaxis_shared.present.segment_line(line.below, NULL, pl_data, false);
            if (point) {
                line.before = trueaxis_shared.sent;
                line.motor = line.from = *point;
                trueaxis_shared.sent = to_steps(&line.motor);
                return &line.motor;
            }
            line.inside = false;
        } else if (line.tick < line.ticks) {
            next_stretch(pl_data);
        } else {
            break;
        }
    }
    line.handing = false;
    return NULL;
}
