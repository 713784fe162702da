/* HAL pins and parameters of an instance; the man page describes them. */
#include "component.h"

#include <errno.h>

/* Stops at the first pin that HAL refuses; HAL has said why. */
#define TRY(call)           \
    do {                    \
        int refused = call; \
        if (refused)        \
            return refused; \
    } while (0)

static const char *small(char letter)
{
    static const char *const names[] = {"x", "y", "z", "a", "b", "c"};
    switch (letter) {
    case 'X': return names[0];
    case 'Y': return names[1];
    case 'Z': return names[2];
    case 'A': return names[3];
    case 'B': return names[4];
    default: return names[5];
    }
}

/* Parts of the dynamic correction. */
static const struct {
    const char *name;
    uint8_t bit;
} parts[DYNAMIC_PARTS] = {
    {"friction", TRUEAXIS_DYNAMICS_FRICTION},         {"lag", TRUEAXIS_DYNAMICS_LAG},
    {"acceleration", TRUEAXIS_DYNAMICS_ACCELERATION}, {"feedback", TRUEAXIS_DYNAMICS_FEEDBACK},
    {"crosstalk", TRUEAXIS_DYNAMICS_CROSSTALK},       {"learned", TRUEAXIS_DYNAMICS_LEARNED},
    {"take-up", TRUEAXIS_DYNAMICS_TAKE_UP},
};

void pins_enable_parts(struct pins *pins)
{
    for (int k = 0; k < DYNAMIC_PARTS; k++)
        *pins->enable_part[k] = 1;
}

uint8_t pins_parts_off(const struct pins *pins)
{
    uint8_t off = 0;
    for (int k = 0; k < DYNAMIC_PARTS; k++)
        if (!*pins->enable_part[k])
            off |= parts[k].bit;
    return off;
}

static int whole(struct pins *p, int id, const char *name)
{
    TRY(hal_pin_bit_newf(HAL_IN, &p->enable, id, "%s.enable", name));
    for (int k = 0; k < DYNAMIC_PARTS; k++)
        TRY(hal_pin_bit_newf(HAL_IN, &p->enable_part[k], id, "%s.enable-%s", name, parts[k].name));
    TRY(hal_pin_bit_newf(HAL_IN, &p->motion_enabled, id, "%s.motion-enabled", name));
    TRY(hal_pin_bit_newf(HAL_IN, &p->reset, id, "%s.reset", name));
    TRY(hal_pin_bit_newf(HAL_IN, &p->reload, id, "%s.reload", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->active, id, "%s.active", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->frozen, id, "%s.frozen", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->limited, id, "%s.limited", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->at_edge, id, "%s.at-edge", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->fault, id, "%s.fault", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->fault_code, id, "%s.fault-code", name));
    TRY(hal_pin_s32_newf(HAL_OUT, &p->fault_axis, id, "%s.fault-axis", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->stop_request, id, "%s.stop-request", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->no_output, id, "%s.no-output", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->feedback_out, id, "%s.feedback-out", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->tables_ok, id, "%s.tables-ok", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->reload_busy, id, "%s.reload-busy", name));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->reload_failed, id, "%s.reload-failed", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->reload_code, id, "%s.reload-code", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->reloads, id, "%s.reloads", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->sequence, id, "%s.sequence", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->machine_id, id, "%s.machine-id", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->tables_crc, id, "%s.tables-crc", name));
    return 0;
}

static int contour(struct contour_pins *p, int id, const char *name, const char *of)
{
    TRY(hal_pin_float_newf(HAL_OUT, &p->error, id, "%s.contour.%s.error", name, of));
    TRY(hal_pin_float_newf(HAL_OUT, &p->normal, id, "%s.contour.%s.normal", name, of));
    TRY(hal_pin_float_newf(HAL_OUT, &p->binormal, id, "%s.contour.%s.binormal", name, of));
    TRY(hal_pin_float_newf(HAL_OUT, &p->lag, id, "%s.contour.%s.lag", name, of));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->found, id, "%s.contour.%s.found", name, of));
    return 0;
}

static int joint(struct joint_pins *p, int id, const char *name, int j)
{
    TRY(hal_pin_float_newf(HAL_IN, &p->pos_cmd, id, "%s.joint.%d.pos-cmd", name, j));
    TRY(hal_pin_float_newf(HAL_IN, &p->motor_cmd_in, id, "%s.joint.%d.motor-pos-cmd-in", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->motor_cmd_out, id, "%s.joint.%d.motor-pos-cmd-out", name, j));
    TRY(hal_pin_float_newf(HAL_IN, &p->motor_fb_in, id, "%s.joint.%d.motor-pos-fb-in", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->motor_fb_out, id, "%s.joint.%d.motor-pos-fb-out", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->correction, id, "%s.joint.%d.correction", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->dynamic, id, "%s.joint.%d.dynamic", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->feed_forward, id, "%s.joint.%d.feed-forward", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->contour_feedback, id, "%s.joint.%d.contour-feedback", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->crosstalk, id, "%s.joint.%d.crosstalk", name, j));
    TRY(hal_pin_float_newf(HAL_OUT, &p->learned, id, "%s.joint.%d.learned", name, j));
    TRY(hal_pin_bit_newf(HAL_IN, &p->homed, id, "%s.joint.%d.homed", name, j));
    TRY(hal_pin_bit_newf(HAL_IN, &p->alarm, id, "%s.joint.%d.alarm", name, j));
    return 0;
}

static int axis(struct axis_pins *p, int id, const char *name, const char *letter)
{
    TRY(hal_pin_float_newf(HAL_OUT, &p->command, id, "%s.%s.command", name, letter));
    TRY(hal_pin_float_newf(HAL_OUT, &p->corrected, id, "%s.%s.corrected", name, letter));
    TRY(hal_pin_float_newf(HAL_OUT, &p->correction, id, "%s.%s.correction", name, letter));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->limited, id, "%s.%s.limited", name, letter));
    TRY(hal_pin_bit_newf(HAL_OUT, &p->at_edge, id, "%s.%s.at-edge", name, letter));
    TRY(hal_pin_float_newf(HAL_IN, &p->temperature_rise, id, "%s.%s.temperature-rise", name, letter));
    if (letter[0] >= 'x')
        TRY(hal_pin_float_newf(HAL_IN, &p->learned, id, "%s.%s.learned", name, letter));
    TRY(hal_param_float_newf(HAL_RO, &p->magnitude, id, "%s.%s.magnitude", name, letter));
    TRY(hal_param_float_newf(HAL_RO, &p->slope, id, "%s.%s.slope", name, letter));
    TRY(hal_param_float_newf(HAL_RO, &p->acceleration, id, "%s.%s.acceleration", name, letter));
    TRY(hal_param_float_newf(HAL_RO, &p->travel_min, id, "%s.%s.travel-min", name, letter));
    TRY(hal_param_float_newf(HAL_RO, &p->travel_max, id, "%s.%s.travel-max", name, letter));
    TRY(hal_param_float_newf(HAL_RW, &p->max_magnitude, id, "%s.%s.max-magnitude", name, letter));
    TRY(hal_param_float_newf(HAL_RW, &p->max_slope, id, "%s.%s.max-slope", name, letter));
    TRY(hal_param_float_newf(HAL_RW, &p->max_acceleration, id, "%s.%s.max-acceleration", name, letter));
    return 0;
}

static int gauge(struct gauge_pins *p, int id, const char *name)
{
    TRY(hal_pin_s32_newf(HAL_IN, &p->spindle_counts, id, "%s.gauge.spindle-counts", name));
    TRY(hal_pin_s32_newf(HAL_IN, &p->index_counts, id, "%s.gauge.index-counts", name));
    TRY(hal_pin_bit_newf(HAL_IN, &p->index, id, "%s.gauge.index", name));
    TRY(hal_pin_s32_newf(HAL_IN, &p->arm_counts, id, "%s.gauge.arm-counts", name));
    TRY(hal_pin_bit_newf(HAL_IN, &p->new_part, id, "%s.gauge.new-part", name));
    TRY(hal_pin_bit_newf(HAL_IN, &p->idle, id, "%s.gauge.idle", name));
    for (int k = 0; k < 3; k++)
        TRY(hal_pin_float_newf(HAL_IN, &p->probe[k], id, "%s.gauge.probe-%d", name, k + 1));
    TRY(hal_pin_float_newf(HAL_OUT, &p->roundness, id, "%s.gauge.roundness", name));
    TRY(hal_pin_float_newf(HAL_OUT, &p->infeed, id, "%s.gauge.infeed", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->evaluated, id, "%s.gauge.evaluated", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->skipped, id, "%s.gauge.skipped", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->discarded, id, "%s.gauge.discarded", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->flags, id, "%s.gauge.flags", name));
    TRY(hal_pin_u32_newf(HAL_OUT, &p->revolution_flags, id, "%s.gauge.revolution-flags", name));
    return 0;
}

int pins_export(struct instance *instance, int id)
{
    const char *name = instance->setup.name;
    struct pins *pins = hal_malloc(sizeof *pins);
    if (!pins)
        return -ENOMEM;
    instance->pins = pins;
    TRY(whole(pins, id, name));
    TRY(contour(&pins->tip, id, name, "tip"));
    TRY(contour(&pins->encoder, id, name, "encoder"));
    for (int j = 0; j < instance->setup.joints; j++)
        TRY(joint(&pins->joint[j], id, name, j));
    for (int a = 0; a < instance->setup.axes; a++)
        if (instance->setup.joints_of_axis[a] > 0)
            TRY(axis(&pins->axis[a], id, name, small(instance->setup.axis_letters[a])));
    if (instance->setup.has_gauge)
        TRY(gauge(&pins->gauge, id, name));
    return 0;
}

void pins_limits(struct instance *instance, const struct tables *tables)
{
    const trueaxis_tables_info_t *info = &tables->info;
    for (int a = 0; a < instance->setup.axes; a++) {
        if (instance->setup.joints_of_axis[a] == 0)
            continue;
        struct axis_pins *p = &instance->pins->axis[a];
        double unit = instance->setup.mm_per_unit[a];
        p->magnitude = info->correction_limit[a] / unit;
        p->slope = info->slope_limit_per_s[a] / unit;
        p->acceleration = info->acceleration_limit_per_s2[a] / unit;
        p->travel_min = info->travel_low[a] / unit;
        p->travel_max = info->travel_high[a] / unit;
    }
}

static bool within(double limit, double unit, double accepted)
{
    return accepted == 0.0 || limit / unit <= accepted;
}

bool pins_limits_accepted(const struct instance *instance, const struct tables *tables)
{
    const trueaxis_tables_info_t *info = &tables->info;
    for (int a = 0; a < instance->setup.axes; a++) {
        if (instance->setup.joints_of_axis[a] == 0)
            continue;
        const struct axis_pins *p = &instance->pins->axis[a];
        double unit = instance->setup.mm_per_unit[a];
        if (!within(info->correction_limit[a], unit, p->max_magnitude) ||
            !within(info->slope_limit_per_s[a], unit, p->max_slope) ||
            !within(info->acceleration_limit_per_s2[a], unit, p->max_acceleration))
            return false;
    }
    return true;
}
