/* Thermal growth from temperatures: the file, read while loading, and an update a second of the servo thread. */
#include "component.h"

#include <math.h>
#include <string.h>

/* Time between two updates. */
#define UPDATE_NS 1000000000u

uint32_t thermal_read(struct instance *instance, uint32_t machine_id, char line[LINE_BYTES])
{
    struct thermal *thermal = &instance->servo.thermal;
    const char *path = instance->setup.thermal_path;
    if (path[0] == '\0')
        return 0;
    char found[LINE_BYTES] = "";
    trueaxis_error_t error = {.size = sizeof error};
    size_t length = 0;
    uint32_t refused = tables_file(path, thermal->file, sizeof thermal->file, &length, found);
    if (!refused) {
        int status = trueaxis_thermal_build(&thermal->growth, sizeof thermal->growth, thermal->file, length, machine_id,
                                            &instance->setup.sensors, &error);
        if (status == TRUEAXIS_OK)
            status = trueaxis_thermal_start(&thermal->task, sizeof thermal->task);
        if (status != TRUEAXIS_OK)
            rtapi_snprintf(found, sizeof found, "%s", error.text[0] ? error.text : trueaxis_result_text(status));
        refused = (uint32_t)status;
    }
    if (refused)
        rtapi_snprintf(line, LINE_BYTES, "%s: %s", path, found);
    instance->setup.has_thermal = !refused;
    return refused;
}

/* Growth of the last update to the step: after an update, and to new tables. */
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
        size_t letter = (size_t)(strchr("XYZABC", setup->axis_letters[a]) - "XYZABC");
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
