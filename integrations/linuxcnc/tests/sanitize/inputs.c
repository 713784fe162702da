/* Inputs of a cycle: see double.h. */
#include "double.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* splitmix64 */
uint64_t inputs_random(struct motion *motion)
{
    uint64_t z = motion->random += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static double any_float(struct motion *motion)
{
    static const double corners[] = {NAN, INFINITY, -INFINITY, 0.0, -0.0, 1e308, -1e308, 5e-324, 2147.483648, -2147.483649,
                                     1e10, 0.05, -1e-9};
    uint64_t bits = inputs_random(motion);
    double value;
    switch (bits % 4) {
    case 0: return corners[(bits >> 8) % (sizeof corners / sizeof *corners)];
    case 1: bits = inputs_random(motion); memcpy(&value, &bits, sizeof value); return value;
    default: return (double)(int64_t)(bits >> 4) * 0x1p-50;
    }
}

static uint32_t any_integer(struct motion *motion)
{
    static const uint32_t corners[] = {0, 1, 0x7fffffffu, 0x80000000u, 0xffffffffu, 16384, 0xffff};
    uint64_t bits = inputs_random(motion);
    return bits & 1 ? corners[(bits >> 8) % (sizeof corners / sizeof *corners)] : (uint32_t)(bits >> 32);
}

static void attack_pin(const struct pin *pin, struct motion *motion)
{
    if (inputs_random(motion) % 8 != 0)
        return;
    switch (pin->type) {
    case HAL_BIT: pin->value->b = inputs_random(motion) & 1; break;
    case HAL_FLOAT: pin->value->f = any_float(motion); break;
    case HAL_S32: pin->value->s = (int32_t)any_integer(motion); break;
    default: pin->value->u = any_integer(motion);
    }
}

static bool ends(const char *name, const char *end)
{
    size_t length = strlen(name), tail = strlen(end);
    return length >= tail && strcmp(name + length - tail, end) == 0;
}

/* A homed machine with drives that follow one cycle later. */
static void sound_pin(const char *instance, const struct pin *pin, const struct motion *motion, bool power)
{
    const char *name = pin->name + strlen(instance) + 1;
    int joint;
    switch (pin->type) {
    case HAL_BIT:
        pin->value->b = strcmp(name, "enable") == 0 || strncmp(name, "enable-", 7) == 0 ||
                        (power && strcmp(name, "motion-enabled") == 0) || ends(name, ".homed");
        break;
    case HAL_FLOAT:
        if (sscanf(name, "joint.%d.", &joint) != 1)
            pin->value->f = 0.0;
        else if (ends(name, ".motor-pos-fb-in")) {
            char out[HAL_NAME_LEN];
            snprintf(out, sizeof out, "joint.%d.%s", joint, power ? "motor-pos-cmd-out" : "correction");
            pin->value->f = double_pin(instance, out)->value->f + (power ? 0.0 : motion->at);
        } else
            pin->value->f = motion->at;
        break;
    /* Encoder counts wrap. */
    case HAL_S32: pin->value->s = (int32_t)((uint32_t)pin->value->s + 8); break;
    default: break;
    }
}

void inputs_set(const char *instance, struct motion *motion, enum inputs kind)
{
    if (motion->left-- <= 0) {
        motion->way = (double)(inputs_random(motion) % 2001) * 1e-4 - 0.1;
        motion->left = (int)(inputs_random(motion) % 400);
    }
    if (kind == SOUND)
        motion->at = fmax(-50.0 / motion->unit, fmin(40.0 / motion->unit, motion->at + motion->way / motion->unit));
    size_t length = strlen(instance);
    for (int i = 0; i < double_pin_count; i++) {
        const struct pin *pin = &double_pins[i];
        /* The user sets the parameters. */
        if (!pin->input || pin->parameter || strncmp(pin->name, instance, length) != 0 || pin->name[length] != '.')
            continue;
        if (ends(pin->name, ".reload"))
            continue;
        if (kind == ATTACK)
            attack_pin(pin, motion);
        else
            sound_pin(instance, pin, motion, kind == SOUND);
    }
}
