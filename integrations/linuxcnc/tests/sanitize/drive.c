/* Loads the component into the double of HAL, runs each instance in a separate servo thread while its file is exchanged,
 * and unloads it.
 *
 *   drive CYCLES SEED FAILS PERIOD WORD... [-- FILE...]
 *
 * FAILS: number of the HAL call that fails (0: none); PERIOD of the threads, ns; WORD: as after `loadrt trueaxis`;
 * FILE: tables of the first instance's machine, which replace its file in turn, some of them damaged.
 * Prints the numbers of cycles, exchanges and refusals. Exit codes: 0; 1 if an output is not finite, something hangs,
 * or an expected event did not occur; 3 if the component refused to be loaded.
 */
#include "double.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define MAX_THREADS 4
#define CYCLES_OF_A_BURST 200
#define TRIES 4000

extern int rtapi_app_main(void);
extern void rtapi_app_exit(void);
/* The variables through which `loadrt` sets the parameters. */
#define PARAMETER(name) extern void *rtapi_info_address_##name;
PARAMETER(count) PARAMETER(names) PARAMETER(tables) PARAMETER(joints) PARAMETER(joint_tables) PARAMETER(inch)
PARAMETER(units) PARAMETER(angular_units) PARAMETER(servo_period_nsec)
extern int rtapi_info_size_names, rtapi_info_size_tables, rtapi_info_size_joints, rtapi_info_size_joint_tables,
    rtapi_info_size_inch;

struct servo_thread {
    char instance[HAL_NAME_LEN + 1];
    struct function *feedback, *output;
    long cycles, period;
    struct motion motion;
    const char *path;
    char **files;
    int file_count;
    long reloads, refused, active, stopped;
    uint64_t digest; /* of all outputs in all cycles */
    bool broken;
};

static int complained;
static void hear(const char *line)
{
    (void)line;
    __atomic_add_fetch(&complained, 1, __ATOMIC_RELAXED);
}

/* Reads pins of the component's other thread. HAL guarantees no order, and the user reads them from another process. */
__attribute__((no_sanitize("thread"), noinline)) static uint32_t seen(const struct pin *pin)
{
    return pin->type == HAL_BIT ? pin->value->b : pin->value->u;
}

static void text_parameter(void *address, int size, char *text)
{
    char **list = address, *rest = NULL;
    int n = 0;
    for (char *word = strtok_r(text, ",", &rest); word && n < size; word = strtok_r(NULL, ",", &rest))
        list[n++] = word;
}

static void parameter(char *word)
{
    char *value = strchr(word, '=');
    if (!value)
        exit(2);
    *value++ = '\0';
    if (strcmp(word, "count") == 0)
        *(int *)rtapi_info_address_count = atoi(value);
    else if (strcmp(word, "servo_period_nsec") == 0)
        *(long *)rtapi_info_address_servo_period_nsec = atol(value);
    else if (strcmp(word, "inch") == 0)
        *(int *)rtapi_info_address_inch = atoi(value);
    else if (strcmp(word, "units") == 0)
        *(char **)rtapi_info_address_units = value;
    else if (strcmp(word, "angular_units") == 0)
        *(char **)rtapi_info_address_angular_units = value;
    else if (strcmp(word, "names") == 0)
        text_parameter(rtapi_info_address_names, rtapi_info_size_names, value);
    else if (strcmp(word, "tables") == 0)
        text_parameter(rtapi_info_address_tables, rtapi_info_size_tables, value);
    else if (strcmp(word, "joints") == 0)
        text_parameter(rtapi_info_address_joints, rtapi_info_size_joints, value);
    else if (strcmp(word, "joint_tables") == 0)
        text_parameter(rtapi_info_address_joint_tables, rtapi_info_size_joint_tables, value);
    else
        exit(2);
}

/* FNV-1a over a pin's value. */
static uint64_t add_to_digest(uint64_t digest, const struct pin *pin)
{
    uint64_t bits = pin->type == HAL_BIT ? pin->value->b : pin->value->u;
    if (pin->type == HAL_FLOAT)
        memcpy(&bits, (const void *)&pin->value->f, sizeof bits);
    for (int k = 0; k < 8; k++)
        digest = (digest ^ (bits >> 8 * k & 0xff)) * 0x100000001b3u;
    return digest;
}

/* Checks that the outputs for motion and the drives are finite, whatever the inputs are. */
static void look(struct servo_thread *thread)
{
    size_t length = strlen(thread->instance);
    for (int i = 0; i < double_pin_count; i++) {
        const struct pin *pin = &double_pins[i];
        if (strncmp(pin->name, thread->instance, length) != 0 || pin->name[length] != '.')
            continue;
        /* Pins of the component's other thread change at no fixed cycle, so they are not in the digest. */
        if (!pin->input && !pin->parameter && !strstr(pin->name, ".reload") && !strstr(pin->name, ".tables-ok"))
            thread->digest = add_to_digest(thread->digest, pin);
        if (pin->type != HAL_FLOAT)
            continue;
        if ((strstr(pin->name, ".motor-pos-cmd-out") || strstr(pin->name, ".motor-pos-fb-out")) && !isfinite(pin->value->f)) {
            fprintf(stderr, "drive: %s: found %g, needed a number\n", pin->name, pin->value->f);
            thread->broken = true;
        }
    }
}

static void cycle(struct servo_thread *thread, enum inputs kind)
{
    inputs_set(thread->instance, &thread->motion, kind);
    thread->feedback->call(thread->feedback->argument, thread->period);
    thread->output->call(thread->output->argument, thread->period);
    look(thread);
    thread->active += double_pin(thread->instance, "active")->value->b;
    thread->stopped += double_pin(thread->instance, "stop-request")->value->b;
}

/* Requests an exchange and runs cycles until it is answered. */
static void reload(struct servo_thread *thread)
{
    const struct timespec pause = {0, 1000000};
    const struct pin *reloads = double_pin(thread->instance, "reloads");
    hal_data_u *wanted = double_pin(thread->instance, "reload")->value;
    uint32_t before = seen(reloads);
    files_change(thread->path, thread->files, thread->file_count, &thread->motion);
    wanted->b = 1;
    int tries = 0;
    while (seen(reloads) == before && tries++ < TRIES) {
        cycle(thread, inputs_random(&thread->motion) & 1 ? ATTACK : SOUND);
        nanosleep(&pause, NULL);
    }
    wanted->b = 0;
    cycle(thread, SOUND);
    if (seen(reloads) == before) {
        fprintf(stderr, "drive: no answer to reload\n");
        thread->broken = true;
    }
    thread->reloads++;
    thread->refused += seen(double_pin(thread->instance, "reload-failed"));
}

/* Releases a machine that is stopped after an attack: without power, at the position of motion, by a reset. */
static void release(struct servo_thread *thread)
{
    hal_data_u *reset = double_pin(thread->instance, "reset")->value;
    for (int k = 0; k < 6; k++) {
        inputs_set(thread->instance, &thread->motion, STANDING);
        reset->b = k == 3;
        thread->feedback->call(thread->feedback->argument, thread->period);
        thread->output->call(thread->output->argument, thread->period);
        look(thread);
    }
    reset->b = 0;
}

static void *run(void *argument)
{
    struct servo_thread *thread = argument;
    for (long n = 0; n < thread->cycles && !thread->broken; n += CYCLES_OF_A_BURST) {
        enum inputs kind = n > 0 && inputs_random(&thread->motion) & 1 ? ATTACK : SOUND;
        for (int k = 0; k < CYCLES_OF_A_BURST && !thread->broken; k++)
            cycle(thread, kind);
        if (thread->file_count > 0)
            reload(thread);
        release(thread);
    }
    return NULL;
}

static int run_all(struct servo_thread threads[MAX_THREADS], int count)
{
    pthread_t ids[MAX_THREADS];
    int broken = 0;
    for (int i = 0; i < count; i++)
        if (pthread_create(&ids[i], NULL, run, &threads[i]) != 0)
            return 1;
    for (int i = 0; i < count; i++) {
        struct servo_thread *thread = &threads[i];
        pthread_join(ids[i], NULL);
        printf("%s: %ld cycles, active in %ld, stopped in %ld, %ld reloads of which %ld refused, digest %016llx\n",
               thread->instance, thread->cycles, thread->active, thread->stopped, thread->reloads, thread->refused,
               (unsigned long long)thread->digest);
        /* Cycles of both kinds must occur; otherwise this was not an attack on a running machine. */
        bool fits = *(long *)rtapi_info_address_servo_period_nsec == thread->period;
        bool exchanged = thread->reloads > thread->refused && thread->refused > 0;
        if (thread->broken || thread->stopped == 0 || fits != (thread->active > 0) ||
            (thread->file_count > 0 && !exchanged))
            broken = 1;
    }
    return broken;
}

int main(int argument_count, char **arguments)
{
    static struct servo_thread threads[MAX_THREADS];
    if (argument_count < 6)
        return 2;
    long cycles = atol(arguments[1]), seed = atol(arguments[2]), period = atol(arguments[4]);
    double_fails = atoi(arguments[3]);
    double_hears = hear;
    int n = 5;
    for (; n < argument_count && strcmp(arguments[n], "--") != 0; n++)
        parameter(arguments[n]);
    n += n < argument_count;
    int refused = rtapi_app_main();
    if (refused) {
        printf("refused: %d after %d calls of HAL\n", refused, double_calls);
        return refused < 0 ? 3 : 1;
    }
    int count = double_function_count / 2;
    for (int i = 0; i < count && i < MAX_THREADS; i++) {
        struct servo_thread *thread = &threads[i];
        thread->feedback = &double_functions[2 * i];
        thread->output = &double_functions[2 * i + 1];
        strcpy(thread->instance, thread->output->name);
        *strrchr(thread->instance, '.') = '\0';
        thread->cycles = cycles;
        thread->period = period;
        thread->motion.random = (uint64_t)(seed + i);
        thread->motion.unit = ((int *)rtapi_info_address_inch)[i] == 1 ? 25.4 : 1.0;
        if (i == 0 && n < argument_count) {
            thread->path = ((char **)rtapi_info_address_tables)[0];
            thread->files = arguments + n;
            thread->file_count = argument_count - n;
        }
    }
    int broken = run_all(threads, count);
    printf("%d calls of HAL, %d lines\n", double_calls, __atomic_load_n(&complained, __ATOMIC_RELAXED));
    rtapi_app_exit();
    /* Wait, so that the sanitizer reports any code that still runs and accesses freed memory. */
    const struct timespec moment = {0, 30000000};
    nanosleep(&moment, NULL);
    return broken;
}
