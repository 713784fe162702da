/*
 * A separate thread builds tables into the memory of the loop that is not in use, while another thread steps: as in
 * firmware, but observable by a thread sanitizer. The loop is passed over through one atomic variable.
 *
 *   exchange_threads FIRST.tcomp SECOND.tcomp
 *
 * With RACE defined that variable is not atomic, and the sanitizer must report it.
 */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

#include "trueaxis.h"

#define PERIOD_NS 100000u
#define AXES 3
#define EXCHANGES 40
#define NONE (-1)

static trueaxis_loop_t loops[2];
static uint64_t memory[2][8192];
static uint8_t files[2][1 << 18];
static size_t lengths[2];
static trueaxis_state_t state;
#ifdef RACE
static volatile int offered = NONE;
#define TAKE() offered
#define OFFER(which) (offered = (which))
#else
static atomic_int offered = NONE;
#define TAKE() atomic_load_explicit(&offered, memory_order_acquire)
#define OFFER(which) atomic_store_explicit(&offered, (which), memory_order_release)
#endif

static int build(int which) {
    trueaxis_error_t error = { .size = sizeof error };
    trueaxis_result_t result = trueaxis_loop_build(&loops[which], sizeof loops[which], files[which], lengths[which], 0,
                                                   PERIOD_NS, memory[which], sizeof memory[which], &error);
    if (result != TRUEAXIS_OK) {
        printf("refused: %s\n", error.text);
    }
    return result == TRUEAXIS_OK;
}

/* Builds the loop that is not in use, offers it, and waits until it was accepted. */
static void *task(void *argument) {
    int which = 1;
    (void)argument;
    for (int exchange = 0; exchange < EXCHANGES; ++exchange) {
        memset(memory[which], 0, sizeof memory[which]);
        if (!build(which)) {
            return argument;
        }
        OFFER(which);
        while (TAKE() != NONE) {
        }
        which = !which;
    }
    return NULL;
}

static size_t load(const char *name, uint8_t *to, size_t size) {
    FILE *stream = fopen(name, "rb");
    if (stream == NULL) {
        return 0;
    }
    const size_t length = fread(to, 1, size, stream);
    fclose(stream);
    return length;
}

int main(int count, char **arguments) {
    int failed = 0, active = 0, taken = 0;
    uint32_t cycle = 0;
    pthread_t thread;
    trueaxis_input_t input = { .size = sizeof input };
    trueaxis_output_t output = { .size = sizeof output };
    trueaxis_measure_t none = { .size = sizeof none, .kind = TRUEAXIS_MEASURE_NOTHING };
    if (count != 3) {
        fputs("usage: exchange_threads FIRST.tcomp SECOND.tcomp\n", stderr);
        return 2;
    }
    for (int which = 0; which < 2; ++which) {
        lengths[which] = load(arguments[1 + which], files[which], sizeof files[which]);
    }
    if (!build(0) || trueaxis_start(&loops[0], &state, sizeof state, PERIOD_NS) != TRUEAXIS_OK) {
        return 1;
    }
    if (pthread_create(&thread, NULL, task, &input) != 0) {
        return 1;
    }
    input.homed = input.enable = 1;
    input.elapsed_ns = PERIOD_NS;
    while (taken < EXCHANGES && !failed) {
        const int offer = TAKE();
        if (offer != NONE) {
            active = offer;
            OFFER(NONE);
            ++taken;
        }
        for (int axis = 0; axis < AXES; ++axis) {
            input.feedback[axis] = input.command[axis];
        }
        failed = trueaxis_step(&loops[active], &state, &input, &none, NULL, &output) != TRUEAXIS_OK;
        ++cycle;
    }
    pthread_join(thread, NULL);
    printf("%d exchanges in %s cycles, fault %d\n", taken, cycle > EXCHANGES ? "many" : "few", output.record.fault);
    return failed || taken != EXCHANGES;
}
