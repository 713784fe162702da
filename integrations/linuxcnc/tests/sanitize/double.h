/* A double of HAL in one process: the functions of HAL and RTAPI that the component calls, each pin in separate memory, so that a
 * sanitizer sees whoever reaches beyond it or keeps it too long.
 *
 *   double.c   HAL and RTAPI
 *   inputs.c   inputs of a cycle: a machine that moves, and an attack
 *   files.c    files that come and go under a running component
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
    bool input, parameter, given; /* given: in memory of the component's */
    hal_data_u *value; /* a pin's own memory */
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
/* The call of HAL that fails, counted from 1; 0: none. And the calls so far. */
extern int double_fails, double_calls;
/* Receives the component's messages; NULL: discarded. */
extern void (*double_hears)(const char *line);

/* The pin or parameter of that name; ends the program if there is none. */
struct pin *double_pin(const char *instance, const char *name);

/* inputs.c: sets every input of an instance. */
enum inputs {
    SOUND,    /* a homed machine that is switched on and moves */
    STANDING, /* without power, where it is commanded to be */
    ATTACK,   /* anything that the types can hold */
};
struct motion {
    uint64_t random;
    double at, way, unit; /* unit: mm */
    int left;
};
uint64_t inputs_random(struct motion *motion);
void inputs_set(const char *instance, struct motion *motion, enum inputs kind);

/* files.c: overwrites the file `path` with one of those given, whole or damaged, or with other content. */
void files_change(const char *path, char **whole, int count, struct motion *motion);

#endif
