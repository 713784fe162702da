/* Behaviour of the plugin on the double, and moves for checks.py, which compares them with the exact machine.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "machine.h"
#include "trueaxis_correction.h"

#define CHECK(holds)                                                                                                   \
    do {                                                                                                               \
        if (!(holds)) {                                                                                                \
            printf("FAILED line %d: %s; told: %s\n", __LINE__, #holds, told);                                          \
            exit(1);                                                                                                   \
        }                                                                                                              \
    } while (0)

#define FINE 20000.0f /* steps/mm at which rounding hides nothing */
#define COARSE 400.0f /* of an ordinary machine */
static const axes_signals_t all = { .mask = 7 };
static const plan_line_data_t feed, rapid = { .condition.rapid_motion = 1 };

/* Resets everything except constants to the state at power-up. */
static void power_up(float steps_per_mm, void (*own_kinematics)(void)) {
    memset(&sys, 0, sizeof sys);
    memset(&grbl, 0, sizeof grbl);
    told[0] = '\0';
    core_state(STATE_IDLE);
    machine(steps_per_mm);
    core_start(own_kinematics);
}

#ifndef MOVES_ONLY
static bool at(int x, int y, int z) {
    return sys.position[0] == x && sys.position[1] == y && sys.position[2] == z;
}

static void nothing_before_homing(void) {
    power_up(COARSE, NULL);
    CHECK(!strcmp(told, "[MSG:Info: trueaxis: mill-3axis, uncompensated until homed]\r\n"));
    CHECK(line_to(-100, -50, -20, feed) && block_count == 1 && at(-40000, -20000, -8000));
    told[0] = '\0';
    CHECK(core_command("TRUEAXIS") == Status_OK && !strcmp(told, "[TRUEAXIS:uncompensated, not homed|mill-3axis]\r\n"));
    core_home((axes_signals_t){ .mask = 3 }, true); /* not all axes */
    CHECK(line_to(-100, -50, -20, feed) && at(-40000, -20000, -8000));
    core_home(all, false);
    core_state(STATE_IDLE);
    CHECK(line_to(-100, -50, -20, feed) && at(-40000, -20000, -8000));
}

static void homing_comes_off_the_switches(void) {
    coord_data_t pulloff = { .x = 1.0f, .y = 2.0f, .z = 3.0f }, none = { 0 };
    limits_homing_pulloff(&pulloff);
    power_up(COARSE, NULL);
    core_home(all, true);
    CHECK(at(-299 * 400, -198 * 400, -397 * 400) && sys.home_position[1] == -198.0f);
    power_up(COARSE, NULL);
    settings.homing.dir_mask.mask = 2;
    core_home(all, true);
    CHECK(at(-400, -198 * 400, -1200));
    power_up(COARSE, NULL);
    settings.homing.flags.force_set_origin = true;
    core_home(all, true);
    CHECK(at(0, 0, 0));
    settings.homing.flags.force_set_origin = false;
    limits_homing_pulloff(&none);
}

static void homing_switches_on_without_a_move(void) {
    power_up(COARSE, NULL);
    told[0] = '\0';
    core_home(all, true);
    CHECK(at(-120000, -80000, -160000)); /* the drives are at the switches, as without the plugin */
    CHECK(!strcmp(told, "[MSG:Info: trueaxis: correction on]\r\n"));
    /* The tool is not exactly at the switches. The program's position shows the difference to well below a step. */
    float drive[N_AXIS], most = 0.0f;
    trueaxis_correction_forward(gc_state.position, 0, drive);
    for (int idx = 0; idx < N_AXIS; idx++) {
        CHECK(fabsf(drive[idx] - settings.axis[idx].max_travel) < 1e-4f);
        most = fmaxf(most, fabsf(gc_state.position[idx] - settings.axis[idx].max_travel));
    }
    CHECK(most > 0.005f);
    /* A line to the program's position moves nothing. */
    CHECK(line_to(gc_state.position[0], gc_state.position[1], gc_state.position[2], feed));
    CHECK(block_count == 0 && at(-120000, -80000, -160000));
    core_state(STATE_HOMING); /* homing again switches the correction off from the first move on */
    float p[N_AXIS];
    system_convert_array_steps_to_mpos(p, sys.position);
    CHECK(p[0] == -300.0f && p[1] == -200.0f && p[2] == -400.0f);
    core_home(all, true);
    told[0] = '\0';
    CHECK(core_command("TRUEAXIS") == Status_OK && !strncmp(told, "[TRUEAXIS:on|mill-3axis|C:", 26));
}

static void switched_by_command(void) {
    CHECK(line_to(-120, -80, -60, feed));
    CHECK(!at(-48000, -32000, -24000));
    int32_t before[N_AXIS];
    memcpy(before, sys.position, sizeof before);
    core_state(STATE_CYCLE);
    CHECK(core_command("TRUEAXIS=0") == Status_IdleError);
    core_state(STATE_IDLE);
    busy = true;
    CHECK(core_command("TRUEAXIS=0") == Status_IdleError);
    busy = false;
    CHECK(core_command("TRUEAXIS=2") == Status_InvalidStatement && core_command("TRUEAXIS=11") == Status_InvalidStatement);
    for (int on = 0; on <= 1; on++) {
        CHECK(core_command(on ? "TRUEAXIS=1" : "TRUEAXIS=0") == Status_OK);
        CHECK(!memcmp(before, sys.position, sizeof before));
        /* While the correction is off, the program's position is the steps'. Switched on again, it returns within half a
         * step. */
        for (int idx = 0; idx < N_AXIS; idx++) {
            float is = gc_state.position[idx], was = (float[]){ -120, -80, -60 }[idx];
            CHECK(on ? fabsf(is - was) < 0.6f / COARSE : fabsf(is - (float)before[idx] / COARSE) < 1e-6f);
        }
        CHECK(line_to(gc_state.position[0], gc_state.position[1], gc_state.position[2], feed));
        CHECK(!memcmp(before, sys.position, sizeof before));
    }
    CHECK(core_command("TRUEAXIS=0") == Status_OK);
    core_home(all, true); /* remains off */
    CHECK(line_to(-120, -80, -60, feed) && block_count == 1 && at(-48000, -32000, -24000));
    CHECK(core_command("TRUEAXIS=1") == Status_OK);
}

static void position_lost(void) {
    told[0] = '\0';
    sys.homed.mask = 0;
    core_state(STATE_ALARM);
    CHECK(!strcmp(told, "[MSG:Warning: trueaxis: position lost, running uncompensated until homed]\r\n"));
    core_state(STATE_IDLE);
    CHECK(line_to(-10, -10, -10, feed) && at(-4000, -4000, -4000));
    told[0] = '\0';
    grbl.on_report_options(false);
    CHECK(!strcmp(told, "[PLUGIN:trueaxis v1]\r\n[TRUEAXIS:uncompensated, not homed]\r\n"));
    core_home(all, true);
}

static void limits_and_feeds(void) {
    unsigned turns = 0;
    CHECK(line_to(-300, -200, -400, rapid) && !soft_limit_alarm); /* to the corner of the travel */
    CHECK(line_to(0, 0, 0, rapid) && !soft_limit_alarm);
    CHECK(!line_to(0.11f, 0, 0, feed) && soft_limit_alarm);
    CHECK(!line_to(-300.11f, 0, 0, feed) && soft_limit_alarm);
    /* Starts from every corner at which the drives can be after homing. */
    for (int corner = 0; corner < 8; corner++) {
        float p[N_AXIS];
        for (int idx = 0; idx < N_AXIS; idx++) {
            p[idx] = corner & 1 << idx ? settings.axis[idx].max_travel : 0.0f;
        }
        trueaxis_correction_inverse(p, 0, p);
        CHECK(line_to(p[0], p[1], p[2], rapid) && !soft_limit_alarm);
    }
    /* Rounding to steps turns no drive: only one axis moves, and the others take up no lost motion. */
    CHECK(line_to(-290, -50, -20, rapid) && line_to(-280, -50, -20, feed));
    for (int i = 1; i <= 100; i++) {
        CHECK(line_to(-280 + 2.5f * (float)i, -50, -20, feed) && block_count <= 3);
        turns += block_count - 2;
    }
    CHECK(turns <= 8); /* turns due to the correction itself */
    CHECK(line_to(0, 0, 0, rapid));
    /* Rapids are not divided; feed moves are divided into equal segments of at most 2 mm. */
    int32_t zero[N_AXIS];
    memcpy(zero, sys.position, sizeof zero);
    CHECK(line_to(-100, -50, -20, rapid) && block_count == 2); /* Y turns: its lost motion of 2.2 um comes first */
    CHECK(blocks[0].steps[1] - zero[1] == -1 && abs(blocks[0].steps[0] - zero[0]) <= 1 && blocks[0].steps[2] == zero[2]);
    CHECK(line_to(-50, -50, -20, feed) && block_count >= 26);
    for (unsigned i = 0; i < block_count; i++) {
        CHECK(blocks[i].feed_rate == 600.0f);
        CHECK(i == 0 || abs(blocks[i].steps[0] - blocks[i - 1].steps[0]) <= 2 * (int)COARSE);
    }
    /* In inverse time, all segments together take as long as the whole line. */
    int32_t from[N_AXIS];
    memcpy(from, sys.position, sizeof from);
    CHECK(line_to(-90, -20, -30, (plan_line_data_t){ .feed_rate = 10.0f, .condition.inverse_time = 1 }));
    double minutes = 0.0;
    for (unsigned i = 0; i < block_count; i++) {
        CHECK(blocks[i].inverse_time && blocks[i].feed_rate >= 10.0f);
        minutes += 1.0 / (double)blocks[i].feed_rate;
    }
    CHECK(fabs(minutes - 0.1) < 1e-4);
}

static void jog_cancelled(void) {
    float target[N_AXIS] = { -200, -50, -20 };
    plan_line_data_t pl_data = { .feed_rate = 600.0f, .condition.jog_motion = 1 };
    CHECK(line_to(-100, -50, -20, rapid));
    float *point = kinematics.segment_line((coord_data_t *)target, (coord_data_t *)plan_get_position(), &pl_data, true)->values;
    for (int i = 0; i < 5; i++) {
        CHECK(kinematics.segment_line((coord_data_t *)point, NULL, &pl_data, false));
    }
    grbl.on_jog_cancel(STATE_IDLE);
    CHECK(!kinematics.segment_line((coord_data_t *)point, NULL, &pl_data, false));
    /* The jog did not reach its target; the next line nevertheless starts from the planner's steps. */
    CHECK(line_to(-100, -60, -20, feed) && block_count <= 12);
}

/* CoreXY kinematics below: motors a = x + y, b = x - y, with equal steps. */
static coord_data_t *corexy_steps(coord_data_t *position, mpos_t *steps) {
    position->x = 0.5f * (float)(steps->x + steps->y) / settings.axis[0].steps_per_mm;
    position->y = 0.5f * (float)(steps->x - steps->y) / settings.axis[0].steps_per_mm;
    position->z = (float)steps->z / settings.axis[2].steps_per_mm;
    return position;
}
static coord_data_t *corexy_motors(coord_data_t *target, coord_data_t *position) {
    coord_data_t from = *position;
    *target = (coord_data_t){ .x = from.x + from.y, .y = from.x - from.y, .z = from.z };
    return target;
}
static coord_data_t *corexy_line(coord_data_t *target, coord_data_t *position, plan_line_data_t *pl_data, bool init) {
    static coord_data_t end;
    static int left;
    if (init) {
        CHECK(position);
        corexy_motors(&end, target);
        pl_data->feed_rate *= 1.25f; /* whatever it makes of the feed, once for every block */
        left = 1;
        return &end;
    }
    return left-- > 0 ? &end : NULL;
}
static void corexy_target(uint_fast8_t idx) {
    sys.position[idx] = 0;
}
static void corexy(void) {
    kinematics = (kinematics_t){ .transform_steps_to_cartesian = corexy_steps,
                                 .transform_from_cartesian = corexy_motors,
                                 .segment_line = corexy_line,
                                 .limits_set_target_pos = corexy_target,
                                 .limits_set_machine_positions = at_switches };
}

static void around_corexy(void) {
    int32_t cartesian[64][N_AXIS];
    unsigned count;
    for (int wrapped = 0; wrapped <= 1; wrapped++) {
        power_up(FINE, wrapped ? corexy : NULL);
        core_home(all, true);
        CHECK(line_to(-100, -100, -100, rapid) && line_to(-110, -95, -103, feed));
        if (!wrapped) {
            CHECK(block_count < 64);
            count = block_count;
            for (unsigned i = 0; i < block_count; i++) {
                memcpy(cartesian[i], blocks[i].steps, sizeof cartesian[i]);
            }
        }
    }
    CHECK(block_count == count);
    for (unsigned i = 0; i < block_count; i++) {
        CHECK(fabsf(blocks[i].feed_rate - 750.0f) < 0.001f);
        CHECK(abs(blocks[i].steps[0] - cartesian[i][0] - cartesian[i][1]) <= 3);
        CHECK(abs(blocks[i].steps[1] - cartesian[i][0] + cartesian[i][1]) <= 3);
        CHECK(abs(blocks[i].steps[2] - cartesian[i][2]) <= 2);
    }
    coord_data_t p;
    system_convert_array_steps_to_mpos(p.values, sys.position);
    CHECK(fabsf(p.x + 110) < 2e-4f && fabsf(p.y + 95) < 2e-4f && fabsf(p.z + 103) < 2e-4f);
}

#endif

/* Converts steps to machine coordinates and back, over the whole travel. */
static void there_and_back(float steps_per_mm) {
    double worst = 0.0;
    uint32_t random = 1;
    power_up(steps_per_mm, NULL);
    core_home(all, true);
    for (int i = 0; i < 2000; i++) {
        float p[N_AXIS], q[N_AXIS];
        int32_t steps[N_AXIS];
        for (int idx = 0; idx < N_AXIS; idx++) {
            random = random * 1664525u + 1013904223u;
            steps[idx] = (int32_t)((double)settings.axis[idx].max_travel * steps_per_mm * (random >> 8) / 16777216.0);
        }
        system_convert_array_steps_to_mpos(p, steps);
        kinematics.transform_from_cartesian((coord_data_t *)q, (coord_data_t *)p);
        for (int idx = 0; idx < N_AXIS; idx++) {
            worst = fmax(worst, fabs((double)q[idx] * steps_per_mm - steps[idx]));
        }
    }
    printf("there and back at %.0f steps/mm: worst %.4f steps\n", (double)steps_per_mm, worst);
    CHECK(worst < (steps_per_mm > 1000.0f ? 2.0 : 0.04));
}

/* The search of the tables finds at least the largest correction at random points, and less than twice as much. */
static void largest_correction(void) {
    float most[3] = { 0 };
    uint32_t random = 1;
    for (int i = 0; i < 4000; i++) {
        float p[N_AXIS], q[N_AXIS];
        for (int idx = 0; idx < N_AXIS; idx++) {
            random = random * 1664525u + 1013904223u;
            p[idx] = settings.axis[idx].max_travel * fminf(1.0f, 1.2f * (float)(random >> 8) / 16777216.0f);
        }
        trueaxis_correction_forward(p, i & 1 ? 0 : 7, q);
        for (int idx = 0; idx < 3; idx++) {
            most[idx] = fmaxf(most[idx], fabsf(q[idx] - p[idx]));
        }
    }
    for (unsigned idx = 0; idx < 3; idx++) {
        float largest = trueaxis_correction_largest(idx);
        CHECK(largest > most[idx] && largest < 2.0f * most[idx]);
    }
    printf("largest corrections: %.4f %.4f %.4f mm\n", (double)trueaxis_correction_largest(0),
           (double)trueaxis_correction_largest(1), (double)trueaxis_correction_largest(2));
}

/* Moves to compare with the exact machine: lines in all directions, with reversals, short and long, and an arc of
 * chords. */
static void moves(void) {
    static const float points[][N_AXIS] = {
        { -290, -190, -390 }, { -10, -10, -10 },   { -10, -190, -10 },  { -290, -190, -10 }, { -150, -100, -200 },
        { -149, -100, -200 }, { -150, -100, -200 }, { -150, -99.5f, -200 }, { -20, -20, -350 },  { -280, -180, -350.5f },
        { -280, -20, -350 },  { -281, -20, -350 },  { -279, -20, -350 },
    };
    power_up(FINE, NULL);
    core_home(all, true);
    printf("steps %.0f\n", (double)FINE);
    CHECK(line_to(-200, -150, -300, rapid));
    printf("block %ld %ld %ld\n", (long)sys.position[0], (long)sys.position[1], (long)sys.position[2]);
    for (unsigned i = 0; i < sizeof points / sizeof *points + 90; i++) {
        const unsigned lines = sizeof points / sizeof *points;
        float arc = (float)(i - lines) * 0.06f, x = -180 + 40 * cosf(arc), y = -90 + 40 * sinf(arc), z = -150 - 0.3f * arc;
        if (i < lines) {
            x = points[i][0], y = points[i][1], z = points[i][2];
        }
        printf("%s %.9g %.9g %.9g\n", i == lines ? "rapid" : "line", (double)x, (double)y, (double)z);
        CHECK(line_to(x, y, z, i == lines ? rapid : feed));
        for (unsigned b = 0; b < block_count; b++) {
            printf("block %ld %ld %ld\n", (long)blocks[b].steps[0], (long)blocks[b].steps[1], (long)blocks[b].steps[2]);
        }
    }
}

#if N_AXIS > 3
/* Three-axis tables on a controller with a fourth axis, which passes unchanged and is not homed. */
static void fourth_axis_passes(void) {
    float target[N_AXIS] = { -100, -50, -20, 12.5f };
    plan_line_data_t pl_data = { .feed_rate = 600.0f };
    power_up(COARSE, NULL);
    core_home(all, true);
    for (int i = 0; i < 3; i++, target[0] -= 5.0f, target[3] += 2.5f) {
        block_count = 0;
        CHECK(core_line(target, pl_data) && block_count >= 3);
        core_finish();
        CHECK(sys.position[3] == (int32_t)(target[3] * COARSE) && sys.position[0] != (int32_t)(target[0] * COARSE));
        CHECK(blocks[block_count - 2].steps[3] < sys.position[3] && blocks[0].steps[3] >= 0);
    }
    CHECK(gc_state.position[3] == 17.5f);
    sys.position[3] = 20000; /* moved elsewhere: the next line starts there */
    plan_sync_position();
    target[3] = 60.0f;
    block_count = 0;
    CHECK(core_line(target, pl_data) && blocks[0].steps[3] > 20000);
    core_finish();
    CHECK(sys.position[3] == 24000);
}
#endif

int main(void) {
#if N_AXIS > 3
    fourth_axis_passes();
    return 0;
#endif
#ifndef MOVES_ONLY /* of tables with lost motion */
    nothing_before_homing();
    homing_comes_off_the_switches();
    homing_switches_on_without_a_move();
    switched_by_command();
    position_lost();
    limits_and_feeds();
    jog_cancelled();
    around_corexy();
#endif
    there_and_back(COARSE);
    largest_correction();
    there_and_back(FINE);
    moves();
    printf("passed\n");
    return 0;
}
