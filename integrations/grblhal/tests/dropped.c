/* Random sequences of lines, jogs, probing, holds, parking, stops and resets, compared with a model of the machine
 * that shares no code with the library: the reported position is the tool's, and an uncommanded axis does not
 * move.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "machine.h"
#include "trueaxis_correction.h"

#ifndef SEQUENCES
#define SEQUENCES 100
#endif
#ifndef FINEST
#define FINEST 4000.0f /* steps/mm */
#endif
#define OPERATIONS 40

/* The machine, with the same errors as tables.py writes into files: um at the low end of each axis' travel. */
static const double lost_um[3] = { 30, 25, 20 }, travel[3] = { 300, 200, 400 };
static const double ends_um[3][3] = { { 24, 10, -20 }, { 12, -16, 8 }, { -18, 6, 30 } };

static double drive[3], lost[3]; /* mm; lost: 0 if the axis last moved up, the full lost motion if it last moved down */
static unsigned seed, operation;
static const char *doing;

static uint32_t random_state;
static unsigned below(unsigned end) {
    random_state = random_state * 1664525u + 1013904223u;
    return (unsigned)((random_state >> 8) % end);
}

static void stepped(void) {
    for (int i = 0; i < 3; i++) {
        double to = (double)sys.position[i] / (double)settings.axis[i].steps_per_mm;
        lost[i] = fmin(fmax(lost[i] - (to - drive[i]), 0.0), 1e-3 * lost_um[i]);
        drive[i] = to;
    }
}

static double tool(int i) {
    double at = drive[i] + lost[i];
    for (int j = 0; j < 3; j++) {
        at -= 1e-3 * ends_um[i][j] * drive[j] / travel[j];
    }
    return at;
}

/* Permitted deviation: one step, the plugin's hysteresis of turns in its plan and in the steps it follows, and single
 * precision. */
static double bound(int i) {
    return 1.0 / (double)settings.axis[i].steps_per_mm + 0.00065;
}

static double worst_steps;

static void hold(const char *what, int i, double found, double needed) {
    worst_steps = fmax(worst_steps, fabs(found - needed) * (double)settings.axis[i].steps_per_mm);
    if (fabs(found - needed) > bound(i)) {
        printf("FAILED sequence %u, operation %u (%s), %g steps/mm: %s of %c is %.5f, needed %.5f\n", seed, operation, doing,
               (double)settings.axis[i].steps_per_mm, what, "XYZ"[i], found, needed);
        exit(1);
    }
}

static unsigned reports, drops, parks, probes;
static on_execute_realtime_ptr plugins;
static void report(sys_state_t state) {
    plugins(state);
    float told_at[N_AXIS];
    if (sys.homed.mask == 7 && operation && below(200) == 0) {
        system_convert_array_steps_to_mpos(told_at, sys.position);
        for (int i = 0; i < 3; i++) {
            hold("report on the way", i, told_at[i], tool(i));
        }
        reports++;
    }
}

/* Events during a motion, and the operator's actions after the stop. */
static bool dropped, parked;
static void resumed_or_reset(void) {
    if (below(2)) {
        core_cycle_start();
    } else {
        dropped = true;
        core_reset();
    }
}
static void stop(void) {
    dropped = true;
    core_stop();
}
static void cancel(void) {
    dropped = true;
    core_jog_cancel();
}
static void door(void) {
    parked = true;
    core_door();
}

static double touch_at;
static int touch_axis;
static bool touched(void) {
    return tool(touch_axis) < touch_at;
}

static double somewhere(int i) {
    return -(20.0 + below(1000) * 1e-3 * (travel[i] - 60.0));
}

/* A position near or far from `from`, possibly back along the same axis. */
static float next(int i, float from) {
    static const double far[] = { 0.003, 0.02, 0.2, 2.0, 9.0 };
    double to = from + (below(2) ? 1 : -1) * far[below(5)] * (0.2 + 1e-3 * below(1000));
    return (float)fmin(fmax(to, 10.0 - travel[i]), -10.0);
}

/* Homes at the negative ends of the axes in `low`, and at the positive ends of the others. */
static void start(float steps_per_mm, uint8_t low) {
    memset(&sys, 0, sizeof sys);
    memset(&grbl, 0, sizeof grbl);
    core_state(STATE_IDLE);
    machine(steps_per_mm);
    settings.homing.dir_mask.mask = low;
    settings.parking.flags.enabled = true;
    settings.parking.axis = 2;
    settings.parking.target = -3.0f;
    settings.parking.pullout_increment = 2.0f;
    told[0] = '\0';
    operation = 0;
    core_sampling = 20;
    core_stepped = NULL;
    core_start(NULL);
    plugins = grbl.on_execute_realtime;
    grbl.on_execute_realtime = report;
    core_home((axes_signals_t){ .mask = 7 }, true);
    for (int i = 0; i < 3; i++) {
        bool up = low & bit(i);
        drive[i] = up ? -travel[i] : 0.0;
        lost[i] = up ? 0.0 : 1e-3 * lost_um[i];
    }
    core_stepped = stepped;
    core_held = resumed_or_reset;
    core_touched = touched;
    doing = "first line";
}

static const plan_line_data_t feed = { .feed_rate = 600.0f }, rapid = { .condition.rapid_motion = 1 };

static void sequence(float steps_per_mm) {
    float wanted[3], target[N_AXIS] = { 0 }, told_at[N_AXIS];

    random_state = seed * 7919u + (unsigned)steps_per_mm;
    start(steps_per_mm, 7);
    settings.limits.flags.jog_soft_limited = below(2);
    core_sampling = 1 + below(200);
    for (int i = 0; i < 3; i++) {
        wanted[i] = (float)somewhere(i);
    }
    operation = 1;
    line_to(wanted[0], wanted[1], wanted[2], rapid);
    for (; operation <= OPERATIONS; operation++) {
        uint8_t commanded = 0;
        unsigned kind = below(8), many = 1 + below(4);
        unsigned when = 1 + below((unsigned)(steps_per_mm * (below(2) ? 0.1f : 10.0f)) + 2);
        dropped = parked = false;
        memcpy(target, wanted, sizeof wanted);
        if (kind == 0) { /* probe, then retract from the touched position */
            doing = "probe";
            int i = (int)below(3);
            target[i] = fmaxf(wanted[i] - 5.0f, 1.0f - (float)travel[i]);
            touch_axis = i;
            touch_at = tool(i) - 1e-3 * (1 + below(3000));
            core_probe(target, feed);
            commanded = (uint8_t)(1u << i);
            dropped = true;
            if (sys.flags.probe_succeeded) { /* the position is the tool's, also when read later */
                wanted[i] = gc_state.position[i];
                hold("position after probing", i, wanted[i], tool(i));
                memcpy(target, wanted, sizeof wanted);
                for (int back = 0; back < 2; back++) {
                    system_convert_array_steps_to_mpos(told_at, sys.probe_position);
                    hold(back ? "touched place, reported when off it" : "place touched", i, told_at[i], touch_at);
                    target[i] = wanted[i] + 1.0f;
                    if (!back) {
                        line_to(target[0], target[1], target[2], feed);
                    }
                }
            }
        } else {
            bool jogs = kind <= 3;
            static void (*const requests[])(void) = { core_feed_hold, door, stop };
            doing = jogs ? "jogs" : "lines";
            unsigned which = below(4);
            if (which < 3) {
                core_interrupt(when, jogs ? cancel : requests[which]);
            }
            for (unsigned n = 0; n < many && !dropped; n++) {
                int i = (int)below(3);
                target[i] = next(i, target[i]);
                commanded |= (uint8_t)(1u << i);
                if (below(3) == 0) {
                    i = (int)below(3);
                    target[i] = next(i, target[i]);
                    commanded |= (uint8_t)(1u << i);
                }
                if (jogs) {
                    core_jog(target, feed);
                } else {
                    core_line(target, (plan_line_data_t){ .feed_rate = 600.0f, .condition.rapid_motion = below(3) == 0 });
                }
            }
            core_finish();
            core_interrupt(0, NULL);
            doing = !dropped && !parked ? doing : dropped && jogs ? "jogs, cancelled" : dropped ? "lines, dropped" : "lines, parked";
        }
        drops += dropped && kind != 0;
        parks += parked;
        probes += kind == 0;
        system_convert_array_steps_to_mpos(told_at, sys.position);
        for (int i = 0; i < 3; i++) {
            hold("report", i, told_at[i], tool(i));
            if (dropped && (commanded & bit(i))) {
                wanted[i] = gc_state.position[i];
                hold("program's position", i, wanted[i], told_at[i]);
            } else {
                wanted[i] = target[i];
            }
        }
        if (parked) { /* the parking axis returns from above; the next line corrects it if it had last moved up */
            line_to(wanted[0], wanted[1], wanted[2], feed);
        }
        for (int i = 0; i < 3; i++) {
            hold(commanded & bit(i) ? "place" : "place, not commanded,", i, tool(i), wanted[i]);
        }
    }
}

static void begin(const char *what, float steps_per_mm) {
    start(steps_per_mm, 7);
    doing = what;
    operation = 1;
    line_to(-100, -60, -110, rapid);
    line_to(-100, -50, -100, rapid);
}

/* Cancels 200 jogs of X anywhere: Y and Z stay within a step of their positions. */
static void jogs_cancelled(float steps_per_mm) {
    begin("jogs of X, cancelled", steps_per_mm);
    for (int n = 0; n < 200; n++) {
        float target[N_AXIS] = { n % 2 ? -90.0f : -110.0f, gc_state.position[1], gc_state.position[2] };
        core_interrupt(1 + below(8 * (unsigned)steps_per_mm), cancel);
        core_jog(target, feed);
        core_finish();
        hold("place, not commanded,", 1, tool(1), -50);
        hold("place, not commanded,", 2, tool(2), -100);
    }
    core_interrupt(0, NULL);
}

static void probed_again_and_again(float steps_per_mm) {
    begin("probing with retracts", steps_per_mm);
    touch_axis = 2;
    touch_at = -102.5;
    for (int n = 0; n < 20; n++) {
        float target[N_AXIS] = { gc_state.position[0], gc_state.position[1], -110 };
        if (!core_probe(target, feed)) {
            printf("FAILED: nothing found\n");
            exit(1);
        }
        line_to(gc_state.position[0], gc_state.position[1], -100, feed);
        hold("place, not commanded,", 0, tool(0), -100);
        hold("place, not commanded,", 1, tool(1), -50);
        hold("place", 2, tool(2), -100);
    }
}

/* A hold before a turn that is already in the queue, then a reset: the drive has not turned. */
static void reset_before_a_turn(float steps_per_mm) {
    begin("reset before a turn", steps_per_mm);
    for (int n = 0; n < 20; n++) {
        line_to(-100, -50, -30, feed);
        core_interrupt((unsigned)steps_per_mm * 2 + below((unsigned)steps_per_mm * 6), stop);
        queue_to(-100, -50, -20, feed);
        queue_to(-100, -50, -30, feed);
        core_finish();
        line_to(-100, -50, -27.0f - 0.01f * (float)n, feed);
        hold("place", 2, tool(2), -27.0 - 0.01 * n);
    }
}

/* A stop while Z takes up its lost motion: the drive completes or reverses this before the tool continues. */
static void stopped_amid_lost_motion(void) {
    for (int up = 0; up < 2; up++) {
        begin("stopped amid lost motion", 4000.0f);
        core_interrupt(10, stop); /* within 70 of 80 steps */
        queue_to(-100, -50, -101, feed);
        core_finish();
        hold("report", 2, gc_state.position[2], -100);
        int32_t x = sys.position[0];
        line_to(-90, -50, up ? -95 : -105, feed);
        hold("place", 0, tool(0), -90);
        hold("place", 2, tool(2), up ? -95 : -105);
        if (blocks[0].steps[0] != x) {
            printf("FAILED: X moves while Z takes up lost motion\n");
            exit(1);
        }
    }
}

/* The drives reached the upper ends from below and moved back, so the tool is above the travel by the lost motion. */
static void jogs_off_the_switches(void) {
    start(4000.0f, 0);
    settings.limits.flags.jog_soft_limited = true;
    float target[N_AXIS] = { gc_state.position[0], -10, -20 };
    hold("place", 0, gc_state.position[0], 0.03);
    operation = 1;
    core_jog(target, feed);
    core_finish();
    hold("place, not commanded,", 0, tool(0), 0.03);
    hold("place", 1, tool(1), -10);
    hold("place", 2, tool(2), -20);
    target[1] = 5; /* limited to the travel */
    core_jog(target, feed);
    core_finish();
    hold("place, not commanded,", 0, tool(0), 0.03);
    hold("place", 1, tool(1), 0);
    settings.limits.flags.jog_soft_limited = false;
}

static void lines_of_a_program_are_no_jogs(void) {
    begin("jog cancel amid a program", 400.0f);
    core_interrupt(500, core_jog_cancel);
    line_to(-60, -50, -100, feed);
    hold("place", 0, tool(0), -60);
}

/* Soft limits are widened by the tables' largest correction, 64 um on X, and not by the limit of the correction, 1
 * mm. */
static void soft_limits(void) {
    begin("soft limits", 400.0f);
    bool good = fabsf(trueaxis_correction_largest(0) - 0.064f) < 0.0015f && fabsf(trueaxis_correction_largest(1) - 0.045f) < 0.0015f &&
                fabsf(trueaxis_correction_largest(2) - 0.056f) < 0.0015f;
    good = good && line_to(0.062f, -50, -100, rapid) && !line_to(0.067f, -50, -100, rapid);
    good = good && line_to(-300.062f, -50, -100, rapid) && !line_to(-300.067f, -50, -100, rapid);
    good = good && line_to(-20, -50, -100, rapid);
    float offset[N_AXIS] = { 0 }, target[N_AXIS] = { -20, -50, -100 };
    plan_line_data_t inside = feed, outside = feed;
    offset[0] = 0, offset[1] = 20;
    good = good && mc_arc(target, &inside, offset, 20.0f, 1);
    core_finish();
    hold("place after an arc", 0, tool(0), -20);
    hold("place after an arc", 1, tool(1), -50);
    offset[0] = 10.1f, offset[1] = 0;
    good = good && !mc_arc(target, &outside, offset, 10.1f, 1);
    if (!good) {
        printf("FAILED: soft limits; largest %.4f %.4f %.4f\n", (double)trueaxis_correction_largest(0),
               (double)trueaxis_correction_largest(1), (double)trueaxis_correction_largest(2));
        exit(1);
    }
}

int main(void) {
    for (float steps_per_mm = 400.0f; steps_per_mm <= FINEST; steps_per_mm *= 10.0f) {
        jogs_cancelled(steps_per_mm);
        probed_again_and_again(steps_per_mm);
        reset_before_a_turn(steps_per_mm);
    }
    stopped_amid_lost_motion();
    jogs_off_the_switches();
    lines_of_a_program_are_no_jogs();
    soft_limits();
    for (seed = 1; seed <= SEQUENCES; seed++) {
        sequence(seed % 2 ? 400.0f : 4000.0f);
    }
    printf("%u sequences: %u times dropped, %u parked, %u probed, %u reports on the way, at most %.2f steps off\n", SEQUENCES, drops,
           parks, probes, reports, worst_steps);
    return 0;
}
