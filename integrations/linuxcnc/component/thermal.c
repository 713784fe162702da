/* Thermal growth from temperatures: one update per second. Realtime, like cycle.c. */
#include "component.h"

/* Time between two updates. */
#define UPDATE_NS 1000000000u

/* Passes the growth of the last update to the step: after an update, and to new tables. */
static void tell(struct instance *instance)
{
    struct servo *servo = &instance->servo;
    trueaxis_set_growth(&servo->tables->axes, &servo->axes_state, &servo->thermal.last);
    servo->growth_told = true;
}

static void show(struct instance *instance)
{
    const trueaxis_growth_t *last = &instance->servo.thermal.last;
    const struct setup *setup = &instance->setup;
    struct thermal_pins *p = &instance->pins->thermal;
    for (uint32_t k = 0; k < setup->sensors; k++)
        hal_set_ui32(p->status[k], last->sensors[k]);
    hal_set_bool(p->good, last->good);
    hal_set_bool(p->at_edge, last->at_edge != 0);
    hal_set_bool(p->spindle_missing, last->spindle_missing);
    for (int a = 0; a < setup->axes; a++) {
        if (setup->joints_of_axis[a] == 0)
            continue;
        int letter = setup->letter_of_axis[a];
        hal_set_real(instance->pins->axis[a].growth_offset, last->offset[letter] / setup->mm_per_unit[a]);
        hal_set_real(instance->pins->axis[a].growth_slope, last->slope[letter]);
    }
}

void thermal_update(struct instance *instance, uint32_t period_ns)
{
    struct servo *servo = &instance->servo;
    struct thermal *thermal = &servo->thermal;
    struct thermal_pins *p = &instance->pins->thermal;
    bool believe = hal_get_bool(p->believe);
    for (uint32_t k = 0; k < instance->setup.sensors && believe && !thermal->believed; k++)
        if (thermal->last.sensors[k] == TRUEAXIS_SENSOR_JUMPED)
            trueaxis_thermal_believe(&thermal->task, k);
    thermal->believed = believe;
    thermal->since_ns += period_ns;
    if (thermal->last.size != 0 && thermal->since_ns < UPDATE_NS) {
        if (!servo->growth_told)
            tell(instance);
        return;
    }
    trueaxis_thermal_readings_t readings = {.size = sizeof readings, .count = instance->setup.sensors};
    readings.dt_s = thermal->last.size == 0 ? 0.0 : 1e-9 * (double)thermal->since_ns;
    for (uint32_t k = 0; k < readings.count; k++)
        readings.temperatures_c[k] = hal_get_real(p->temperature[k]);
    readings.spindle_rpm = hal_get_real(p->spindle_speed);
    readings.tool_mm = hal_get_real(p->tool_length) * (instance->setup.inch ? 25.4 : 1.0);
    thermal->last.size = sizeof thermal->last;
    thermal->since_ns = 0;
    if (trueaxis_thermal_update(&thermal->growth, &thermal->task, &readings, &thermal->last) == TRUEAXIS_OK)
        tell(instance);
    show(instance);
}
