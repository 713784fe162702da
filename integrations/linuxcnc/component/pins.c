/* HAL pins and parameters of an instance; the man page describes them. */
#include "component.h"

#include <errno.h>
#include <math.h>

/* Stops at the first pin that HAL refuses; HAL has printed the reason. */
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

uint8_t pins_parts_off(const struct pins *pins)
{
    uint8_t off = hal_get_bool(pins->on_trial) ? TRUEAXIS_DYNAMICS_ON_TRIAL : 0;
    for (int k = 0; k < DYNAMIC_PARTS; k++)
        if (!hal_get_bool(pins->enable_part[k]))
            off |= parts[k].bit;
    return off;
}

static int whole(struct pins *p, int id, const char *name)
{
    TRY(hal_pin_new_bool(id, HAL_IN, &p->enable, false, "%s.enable", name));
    /* Every part of the dynamic correction, and motion, is on unless its pin is connected. */
    for (int k = 0; k < DYNAMIC_PARTS; k++)
        TRY(hal_pin_new_bool(id, HAL_IN, &p->enable_part[k], true, "%s.enable-%s", name, parts[k].name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->on_trial, false, "%s.on-trial", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->adapt_freeze, false, "%s.adapt-freeze", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->adapt_reset, false, "%s.adapt-reset", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->motion_enabled, true, "%s.motion-enabled", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->reset, false, "%s.reset", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->reload, false, "%s.reload", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->active, false, "%s.active", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->frozen, false, "%s.frozen", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->limited, false, "%s.limited", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->at_edge, false, "%s.at-edge", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->fault, false, "%s.fault", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->fault_code, 0, "%s.fault-code", name));
    TRY(hal_pin_new_si32(id, HAL_OUT, &p->fault_axis, 0, "%s.fault-axis", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->stop_request, false, "%s.stop-request", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->no_output, false, "%s.no-output", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->feedback_out, false, "%s.feedback-out", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->friction_out, false, "%s.friction-out", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->lag_out, false, "%s.lag-out", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->tables_ok, true, "%s.tables-ok", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->reload_busy, false, "%s.reload-busy", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->reload_failed, false, "%s.reload-failed", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->reload_code, 0, "%s.reload-code", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->reloads, 0, "%s.reloads", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->sequence, 0, "%s.sequence", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->machine_id, 0, "%s.machine-id", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->tables_crc, 0, "%s.tables-crc", name));
    return 0;
}

static int contour(struct contour_pins *p, int id, const char *name, const char *of)
{
    TRY(hal_pin_new_real(id, HAL_OUT, &p->error, 0.0, "%s.contour.%s.error", name, of));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->normal, 0.0, "%s.contour.%s.normal", name, of));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->binormal, 0.0, "%s.contour.%s.binormal", name, of));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->lag, 0.0, "%s.contour.%s.lag", name, of));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->found, false, "%s.contour.%s.found", name, of));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->searching, false, "%s.contour.%s.searching", name, of));
    return 0;
}

static int joint(struct joint_pins *p, int id, const char *name, int j)
{
    TRY(hal_pin_new_real(id, HAL_IN, &p->pos_cmd, 0.0, "%s.joint.%d.pos-cmd", name, j));
    TRY(hal_pin_new_real(id, HAL_IN, &p->motor_cmd_in, 0.0, "%s.joint.%d.motor-pos-cmd-in", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->motor_cmd_out, 0.0, "%s.joint.%d.motor-pos-cmd-out", name, j));
    TRY(hal_pin_new_real(id, HAL_IN, &p->motor_fb_in, 0.0, "%s.joint.%d.motor-pos-fb-in", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->motor_fb_out, 0.0, "%s.joint.%d.motor-pos-fb-out", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->correction, 0.0, "%s.joint.%d.correction", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->dynamic, 0.0, "%s.joint.%d.dynamic", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->feed_forward, 0.0, "%s.joint.%d.feed-forward", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->contour_feedback, 0.0, "%s.joint.%d.contour-feedback", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->crosstalk, 0.0, "%s.joint.%d.crosstalk", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->learned, 0.0, "%s.joint.%d.learned", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->friction_factor, 1.0, "%s.joint.%d.friction-factor", name, j));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->presliding_factor, 1.0, "%s.joint.%d.presliding-factor", name, j));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->homed, false, "%s.joint.%d.homed", name, j));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->alarm, false, "%s.joint.%d.alarm", name, j));
    return 0;
}

static int axis(struct axis_pins *p, int id, const char *name, const char *letter, bool thermal)
{
    TRY(hal_pin_new_real(id, HAL_OUT, &p->command, 0.0, "%s.%s.command", name, letter));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->corrected, 0.0, "%s.%s.corrected", name, letter));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->correction, 0.0, "%s.%s.correction", name, letter));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->limited, false, "%s.%s.limited", name, letter));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->at_edge, false, "%s.%s.at-edge", name, letter));
    if (thermal) {
        TRY(hal_pin_new_real(id, HAL_OUT, &p->growth_offset, 0.0, "%s.%s.growth-offset", name, letter));
        TRY(hal_pin_new_real(id, HAL_OUT, &p->growth_slope, 0.0, "%s.%s.growth-slope", name, letter));
    } else {
        TRY(hal_pin_new_real(id, HAL_IN, &p->temperature_rise, 0.0, "%s.%s.temperature-rise", name, letter));
    }
    if (letter[0] >= 'x')
        TRY(hal_pin_new_real(id, HAL_IN, &p->learned, 0.0, "%s.%s.learned", name, letter));
    TRY(hal_param_new_real(id, HAL_RO, &p->magnitude, 0.0, "%s.%s.magnitude", name, letter));
    TRY(hal_param_new_real(id, HAL_RO, &p->slope, 0.0, "%s.%s.slope", name, letter));
    TRY(hal_param_new_real(id, HAL_RO, &p->acceleration, 0.0, "%s.%s.acceleration", name, letter));
    TRY(hal_param_new_real(id, HAL_RO, &p->travel_min, 0.0, "%s.%s.travel-min", name, letter));
    TRY(hal_param_new_real(id, HAL_RO, &p->travel_max, 0.0, "%s.%s.travel-max", name, letter));
    TRY(hal_param_new_real(id, HAL_RW, &p->max_magnitude, 0.0, "%s.%s.max-magnitude", name, letter));
    TRY(hal_param_new_real(id, HAL_RW, &p->max_slope, 0.0, "%s.%s.max-slope", name, letter));
    TRY(hal_param_new_real(id, HAL_RW, &p->max_acceleration, 0.0, "%s.%s.max-acceleration", name, letter));
    return 0;
}

static int gauge(struct gauge_pins *p, int id, const char *name)
{
    TRY(hal_pin_new_si32(id, HAL_IN, &p->spindle_counts, 0, "%s.gauge.spindle-counts", name));
    TRY(hal_pin_new_si32(id, HAL_IN, &p->index_counts, 0, "%s.gauge.index-counts", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->index, false, "%s.gauge.index", name));
    TRY(hal_pin_new_si32(id, HAL_IN, &p->arm_counts, 0, "%s.gauge.arm-counts", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->new_part, false, "%s.gauge.new-part", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->idle, false, "%s.gauge.idle", name));
    for (int k = 0; k < 3; k++)
        TRY(hal_pin_new_real(id, HAL_IN, &p->probe[k], 0.0, "%s.gauge.probe-%d", name, k + 1));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->roundness, 0.0, "%s.gauge.roundness", name));
    TRY(hal_pin_new_real(id, HAL_OUT, &p->infeed, 0.0, "%s.gauge.infeed", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->evaluated, 0, "%s.gauge.evaluated", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->skipped, 0, "%s.gauge.skipped", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->discarded, 0, "%s.gauge.discarded", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->flags, 0, "%s.gauge.flags", name));
    TRY(hal_pin_new_ui32(id, HAL_OUT, &p->revolution_flags, 0, "%s.gauge.revolution-flags", name));
    return 0;
}

/* A sensor that is not connected counts as missing, not as 0 degrees. */
static int thermal(struct thermal_pins *p, int id, const char *name, uint32_t sensors)
{
    for (uint32_t k = 0; k < sensors; k++) {
        TRY(hal_pin_new_real(id, HAL_IN, &p->temperature[k], NAN, "%s.thermal.sensor-%d", name, (int)k + 1));
        TRY(hal_pin_new_ui32(id, HAL_OUT, &p->status[k], TRUEAXIS_SENSOR_MISSING, "%s.thermal.sensor-%d-status", name,
                             (int)k + 1));
    }
    TRY(hal_pin_new_real(id, HAL_IN, &p->spindle_speed, 0.0, "%s.thermal.spindle-speed", name));
    TRY(hal_pin_new_real(id, HAL_IN, &p->tool_length, 0.0, "%s.thermal.tool-length", name));
    TRY(hal_pin_new_bool(id, HAL_IN, &p->believe, false, "%s.thermal.believe", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->good, false, "%s.thermal.good", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->at_edge, false, "%s.thermal.at-edge", name));
    TRY(hal_pin_new_bool(id, HAL_OUT, &p->spindle_missing, false, "%s.thermal.spindle-missing", name));
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
            TRY(axis(&pins->axis[a], id, name, small(instance->setup.axis_letters[a]), instance->setup.has_thermal));
    if (instance->setup.has_gauge)
        TRY(gauge(&pins->gauge, id, name));
    if (instance->setup.has_thermal)
        TRY(thermal(&pins->thermal, id, name, instance->setup.sensors));
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
        hal_set_real(p->magnitude, info->correction_limit[a] / unit);
        hal_set_real(p->slope, info->slope_limit_per_s[a] / unit);
        hal_set_real(p->acceleration, info->acceleration_limit_per_s2[a] / unit);
        hal_set_real(p->travel_min, info->travel_low[a] / unit);
        hal_set_real(p->travel_max, info->travel_high[a] / unit);
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
        if (!within(info->correction_limit[a], unit, hal_get_real(p->max_magnitude)) ||
            !within(info->slope_limit_per_s[a], unit, hal_get_real(p->max_slope)) ||
            !within(info->acceleration_limit_per_s2[a], unit, hal_get_real(p->max_acceleration)))
            return false;
    }
    return true;
}
