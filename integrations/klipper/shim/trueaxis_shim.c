/*
 * Wraps a stepper's kinematics so that every step is solved at p + c(p): the host's solver requests the motor's position
 * at a time, and the wrapper evaluates the original kinematics at the corrected position.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later
 */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "itersolve.h"
#include "trapq.h"
#include "trueaxis.h"

#define EXPORT __attribute__((visibility("default")))
#define PERIOD_NS 1000000 /* of no effect on a correction at a position, but a loop has one */
#define STILL_T 500.0     /* within a move at rest, far from its ends */
#define PASSES 16
#define SETTLED_MM 1e-9
#define GRID 24
#define LINE 2000

struct tables {
    trueaxis_loop_t loop;
    trueaxis_tables_info_t info;
    trueaxis_error_t error;
    double limit;
    double largest, steepest; /* largest values on the grid: mm, mm/mm */
    uint64_t *memory;
};

/* State shared by all steppers of a machine. Changed only while no steps are generated. */
struct machine {
    struct tables *tables; /* NULL: uncorrected */
    int held;              /* the correction is held at `hold` */
    double hold[3];
    double datum_z;
};

struct corrected {
    struct stepper_kinematics sk;
    struct stepper_kinematics *inner;
    struct machine *machine;
    struct move still;
};

/* Mean of both directions of travel, because a jump at a reversal would produce a burst of steps. */
static void mean(const struct tables *t, const double *p, double *c) {
    double inside[3], there[TRUEAXIS_AXES_MAX], back[TRUEAXIS_AXES_MAX];
    for (int i = 0; i < 3; i++)
        inside[i] = fmin(fmax(p[i], t->info.travel_low[i]), t->info.travel_high[i]);
    if (trueaxis_correction_at(&t->loop, inside, 0, NULL, there) != TRUEAXIS_OK
        || trueaxis_correction_at(&t->loop, inside, 7, NULL, back) != TRUEAXIS_OK) {
        memset(c, 0, 3 * sizeof *c);
        return;
    }
    for (int i = 0; i < 3; i++)
        c[i] = fmin(fmax(.5 * (there[i] + back[i]), -t->limit), t->limit);
}

static void correction(const struct machine *m, const double *p, double *c) {
    mean(m->tables, p, c);
    c[2] -= m->datum_z;
}

static double calc_position(struct stepper_kinematics *sk, struct move *m, double time) {
    struct corrected *k = (struct corrected *)((char *)sk - offsetof(struct corrected, sk));
    const struct machine *machine = k->machine;
    if (!machine->tables)
        return k->inner->calc_position_cb(k->inner, m, time);
    double way = (m->start_v + m->half_accel * time) * time, p[3], c[3];
    for (int i = 0; i < 3; i++)
        p[i] = m->start_pos.axis[i] + m->axes_r.axis[i] * way;
    if (machine->held)
        memcpy(c, machine->hold, sizeof c);
    else
        correction(machine, p, c);
    for (int i = 0; i < 3; i++)
        k->still.start_pos.axis[i] = p[i] + c[i];
    return k->inner->calc_position_cb(k->inner, &k->still, STILL_T);
}

static void post(struct stepper_kinematics *sk) {
    struct corrected *k = (struct corrected *)((char *)sk - offsetof(struct corrected, sk));
    k->inner->commanded_pos = sk->commanded_pos;
    k->inner->post_cb(k->inner);
    sk->commanded_pos = k->inner->commanded_pos;
}

EXPORT struct machine *trueaxis_shim_machine(void) { return calloc(1, sizeof(struct machine)); }

EXPORT struct stepper_kinematics *trueaxis_shim_wrap(struct machine *machine, struct stepper_kinematics *inner) {
    struct corrected *k = calloc(1, sizeof *k);
    if (!k)
        return NULL;
    k->sk = *inner;
    k->sk.calc_position_cb = calc_position;
    k->sk.post_cb = inner->post_cb ? post : NULL;
    k->inner = inner;
    k->machine = machine;
    k->still.move_t = 2. * STILL_T;
    return &k->sk;
}

EXPORT void trueaxis_shim_active(struct stepper_kinematics *sk, int flags) { sk->active_flags = flags; }
EXPORT int trueaxis_shim_flags(struct stepper_kinematics *sk) { return sk->active_flags; }

EXPORT void trueaxis_shim_use(struct machine *m, struct tables *t) { m->tables = t; m->held = 0; }

EXPORT void trueaxis_shim_correction(const struct machine *m, const double *p, double *c) {
    memset(c, 0, 3 * sizeof *c);
    if (m->tables)
        correction(m, p, c);
}

/* Holds the correction at its value at p; with NULL it follows the position again. */
EXPORT void trueaxis_shim_hold(struct machine *m, const double *p) {
    m->held = p && m->tables;
    if (m->held)
        correction(m, p, m->hold);
}

/* Sets the datum: the correction of Z becomes zero where the probe touched, at the uncorrected position `probed` of the
 * drives. NULL removes the datum. */
EXPORT void trueaxis_shim_datum(struct machine *m, const struct tables *t, const double *probed) {
    double p[3], c[3] = { 0 };
    if (t && probed) {
        memcpy(p, probed, sizeof p);
        for (int pass = 0; pass < PASSES; pass++) {
            mean(t, p, c);
            p[0] = probed[0] - c[0];
            p[1] = probed[1] - c[1];
        }
    }
    m->datum_z = c[2];
}

/* Solves q = p + c(p) for p. Since the slope is limited, every pass adds two digits. */
EXPORT void trueaxis_shim_inverse(const struct machine *m, const double *q, double *p) {
    memcpy(p, q, 3 * sizeof *p);
    for (int pass = 0; m->tables && pass < PASSES; pass++) {
        double c[3], change = 0;
        correction(m, p, c);
        for (int i = 0; i < 3; i++) {
            double next = q[i] - c[i];
            change = fmax(change, fabs(next - p[i]));
            p[i] = next;
        }
        if (change < SETTLED_MM)
            break;
    }
}

static void look(struct tables *t, const double *p, double way, double *was, int first) {
    double c[3];
    mean(t, p, c);
    for (int i = 0; i < 3; i++) {
        t->largest = fmax(t->largest, fabs(c[i]));
        if (!first)
            t->steepest = fmax(t->steepest, fabs(c[i] - was[i]) / way);
        was[i] = c[i];
    }
}

/* Finds the largest correction on a grid over the travel, and the steepest slope on fine lines along each axis through the
 * ends and the middle of the others. */
static void survey(struct tables *t) {
    const double *low = t->info.travel_low, *high = t->info.travel_high;
    double was[3];
    for (int axis = 0; axis < 3; axis++) {
        int others[2] = { (axis + 1) % 3, (axis + 2) % 3 };
        double way = (high[axis] - low[axis]) / LINE;
        for (int place = 0; place < 9 && way > 0; place++) {
            double p[3];
            p[others[0]] = low[others[0]] + (high[others[0]] - low[others[0]]) * (place % 3) / 2;
            p[others[1]] = low[others[1]] + (high[others[1]] - low[others[1]]) * (place / 3) / 2;
            for (int i = 0; i <= LINE; i++) {
                p[axis] = low[axis] + way * i;
                look(t, p, way, was, i == 0);
            }
        }
    }
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++)
            for (int k = 0; k <= GRID; k++) {
                double p[3] = { low[0] + (high[0] - low[0]) * i / GRID, low[1] + (high[1] - low[1]) * j / GRID,
                                low[2] + (high[2] - low[2]) * k / GRID };
                look(t, p, 1, was, 1);
            }
}

EXPORT void trueaxis_shim_free(struct tables *t) {
    if (t)
        free(t->memory);
    free(t);
}

/* Loads a file. Returns NULL, with one line in `told`, if it is refused. */
EXPORT struct tables *trueaxis_shim_load(const unsigned char *file, size_t length, unsigned machine_id, double max_correction,
                                         double max_slope, char *told, size_t told_size) {
    struct tables *t = calloc(1, sizeof *t);
    if (!t) {
        snprintf(told, told_size, "no memory for the tables");
        return NULL;
    }
    t->error.size = sizeof t->error;
    t->info.size = sizeof t->info;
    t->limit = INFINITY;
    if (trueaxis_check_abi(TRUEAXIS_ABI_VERSION) != TRUEAXIS_OK)
        snprintf(told, told_size, "header and library differ in version or precision");
    else if (trueaxis_tables_info(file, length, &t->info, &t->error) != TRUEAXIS_OK)
        snprintf(told, told_size, "%s", t->error.text);
    else if (t->info.axes != 3)
        snprintf(told, told_size, "the tables are for axes %s, needed XYZ", t->info.letters);
    else if (!(t->memory = malloc(t->info.memory_bytes + 8)))
        snprintf(told, told_size, "no memory for the tables");
    else if (trueaxis_loop_build(&t->loop, sizeof t->loop, file, length, machine_id, PERIOD_NS, t->memory,
                                 t->info.memory_bytes, &t->error) != TRUEAXIS_OK)
        snprintf(told, told_size, "%s", t->error.text);
    else {
        survey(t);
        t->limit = max_correction;
        if (t->largest > max_correction)
            snprintf(told, told_size, "found a correction of %.4f mm, needed at most %.4f (max_correction)", t->largest,
                     max_correction);
        else if (t->steepest > max_slope)
            snprintf(told, told_size, "found a correction that changes by %.5f mm/mm, needed at most %.5f (max_slope)",
                     t->steepest, max_slope);
        else
            return t;
    }
    trueaxis_shim_free(t);
    return NULL;
}

EXPORT void trueaxis_shim_travel(const struct tables *t, double *low, double *high) {
    memcpy(low, t->info.travel_low, 3 * sizeof *low);
    memcpy(high, t->info.travel_high, 3 * sizeof *high);
}
EXPORT const char *trueaxis_shim_name(const struct tables *t) { return t->info.name; }
EXPORT unsigned trueaxis_shim_crc(const struct tables *t) { return t->info.tables_crc; }
EXPORT double trueaxis_shim_largest(const struct tables *t) { return t->largest; }
EXPORT double trueaxis_shim_steepest(const struct tables *t) { return t->steepest; }
/* CRC-32 of the host's headers at the time of the build. */
EXPORT unsigned trueaxis_shim_headers(void) { return TRUEAXIS_HEADERS; }
