/* Instructions and stack of the plugin's parts, on QEMU boards under -icount.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "machine.h"
#include "trueaxis_correction.h"

#define CALLS 1000
#define STACK 131072

/* The board's timer 0 counts down 3.2 ticks per instruction. */
static volatile uint32_t *const timer = (volatile uint32_t *)0x40000000;

static uint32_t instructions(uint32_t before, uint32_t after) {
    return (uint32_t)((((uint64_t)(before - after)) * 40 + 64) >> 7);
}

typedef struct {
    uint32_t calls, worst;
    uint64_t sum;
} tally_t;

static void add(tally_t *tally, uint32_t count) {
    tally->calls++;
    tally->sum += count;
    tally->worst = count > tally->worst ? count : tally->worst;
}

static void tell(const char *name, const tally_t *tally) {
    printf("%s.mean %lu\n%s.worst %lu\n", name, (unsigned long)(tally->sum / tally->calls), name, (unsigned long)tally->worst);
}

/* Number of bytes of stack below the caller that `function` has written to. */
static __attribute__((noinline)) unsigned stack_of(void (*function)(void)) {
    volatile uint8_t *low = (volatile uint8_t *)__builtin_frame_address(0) - STACK;
    for (volatile uint8_t *at = low; at < low + STACK - 256; at++) {
        *at = 0xA5;
    }
    function();
    unsigned untouched = 0;
    while (untouched < STACK && low[untouched] == 0xA5) {
        untouched++;
    }
    return STACK - untouched;
}

static void start(void) {
    core_start(NULL);
}

static void line(void) {
    line_to(-10, -20, -30, (plan_line_data_t){ 0 });
}

int main(void) {
    tally_t nothing = { 0 }, forward = { 0 }, inverse = { 0 }, report = { 0 }, begin = { 0 }, stretch = { 0 }, sample = { 0 };
    uint32_t random = 1, before;

    timer[2] = UINT32_MAX;
    timer[1] = UINT32_MAX;
    timer[0] = 1;
    machine(400.0f);
    printf("stack.start %u\n", stack_of(start));
    core_home((axes_signals_t){ .mask = 7 }, true);
    printf("stack.line %u\n", stack_of(line));

    for (int i = 0; i < CALLS; i++) {
        coord_data_t p, q, found;
        mpos_t steps;
        for (int idx = 0; idx < N_AXIS; idx++) {
            random = random * 1664525u + 1013904223u;
            p.values[idx] = settings.axis[idx].max_travel * (float)(random >> 8) / 16777216.0f;
            steps.values[idx] = (int32_t)(p.values[idx] * 400.0f);
        }
        before = timer[1];
        add(&nothing, instructions(before, timer[1]));
        before = timer[1];
        trueaxis_correction_forward(p.values, 0, q.values);
        add(&forward, instructions(before, timer[1]));
        before = timer[1];
        trueaxis_correction_inverse(q.values, 0, found.values);
        add(&inverse, instructions(before, timer[1]));
        before = timer[1];
        kinematics.transform_steps_to_cartesian(&found, &steps);
        add(&report, instructions(before, timer[1]));
    }
    for (int i = 0; i < 40; i++) {
        coord_data_t target = { { -5.0f - 7.3f * (float)i, -100.0f + 2.3f * (float)(i * 7 % 40), -390.0f + 9.0f * (float)i } };
        plan_line_data_t pl_data = { .feed_rate = 600.0f, .condition = { .target_validated = 1, .target_valid = 1 } };
        before = timer[1];
        coord_data_t *point = kinematics.segment_line(&target, (coord_data_t *)plan_get_position(), &pl_data, true);
        add(&begin, instructions(before, timer[1]));
        for (;;) {
            before = timer[1];
            if (!kinematics.segment_line(point, NULL, &pl_data, false)) {
                break;
            }
            add(&stretch, instructions(before, timer[1]));
            for (int idx = 0; idx < N_AXIS; idx++) {
                sys.position[idx] = (int32_t)lroundf(point->values[idx] * 400.0f);
            }
            plan_sync_position();
            before = timer[1];
            grbl.on_execute_realtime(STATE_CYCLE);
            add(&sample, instructions(before, timer[1]));
        }
    }
    tell("timer", &nothing);
    tell("forward", &forward);
    tell("inverse", &inverse);
    tell("position", &report);
    tell("line", &begin);
    tell("stretch", &stretch);
    tell("sample", &sample);
    return 0;
}
