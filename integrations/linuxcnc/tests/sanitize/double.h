/* A double of HAL in one process: the functions of HAL and RTAPI that the component calls. Each pin has separate
 * memory, so that a sanitizer sees every access beyond it or after its lifetime.
 *
 *   double.c   HAL and RTAPI
 *   inputs.c   inputs of a cycle: a machine that moves, and an attack
 *   files.c    files that are exchanged while the component runs
 *   drive.c    loading, the servo thread, unloading
 *
 * License: MIT OR Apache-2.0
 */
#ifndef DOUBLE_H
#define DOUBLE_H

#include <stdbool.h>
#include <stdint.h>

#include "hal_compat.h"

#define MAX_PINS 2048
#define MAX_FUNCTIONS 8

struct pin {
    char name[HAL_NAME_LEN + 1];
    hal_type_t type;
    bool input, parameter, given; /* given: in the component's memory */
    hal_data_u *value; /* in memory of the pin alone */
};

struct function {
    char name[HAL_NAME_LEN + 1];
    void (*call)(void *, long);
    void *argument;
};

extern struct pin double_pins[MAX_PINS];
extern int double_pin_count;
extern struct function double_functions[MAX_FUNCTIONS];
extern int double_function_count;
/* Number of the HAL call that fails, counted from 1; 0: none. And the number of calls so far. */
extern int double_fails, double_calls;
/* Receives the component's messages; NULL: discarded. */
extern void (*double_hears)(const char *line);

/* Returns the pin or parameter of that name; exits if none exists. */
struct pin *double_pin(const char *instance, const char *name);

/* inputs.c: sets every input of an instance. */
enum inputs {
    SOUND,    /* a homed machine with power that moves */
    STANDING, /* without power, at the commanded position */
    ATTACK,   /* any values that the types allow */
};
struct motion {
    uint64_t random;
    double at, way, unit; /* unit: mm */
    int left;
};
uint64_t inputs_random(struct motion *motion);
void inputs_set(const char *instance, struct motion *motion, enum inputs kind);

/* files.c: replaces the file `path` with one of those given, whole or damaged, or with other content. */
void files_change(const char *path, char **whole, int count, struct motion *motion);

#endif
