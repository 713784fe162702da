/* Loads and unloads trueaxis as a component of LinuxCNC's HAL.
 *
 * License: MIT OR Apache-2.0
 */
#include "component.h"

#include <errno.h>

#include "rtapi_app.h"

MODULE_AUTHOR("trueaxis");
MODULE_DESCRIPTION("Geometric error compensation between motion-controller and the drives");
MODULE_LICENSE("MIT OR Apache-2.0");

struct instance trueaxis_instances[MAX_INSTANCES];
int trueaxis_instance_count;

static int component;

/* All refusals happen here, before HAL has the instance. */
static int instance_load(struct instance *instance)
{
    char line[LINE_BYTES] = "";
    struct tables *tables = &instance->loader.slot[0];
    uint32_t refused = tables_read(instance, NULL, tables, line);
    if (!refused)
        refused = tables_match(instance, tables, line);
    if (!refused && tables->info.gauge_points > 0)
        refused = tables_gauge(instance, tables->info.gauge_points, line);
    if (!refused)
        refused = tables_thermal(instance, tables->info.machine_id, line);
    if (!refused)
        refused = (uint32_t)trueaxis_command_window_start(&instance->servo.window, sizeof instance->servo.window, NULL,
                                                          WINDOW_SPACING_MM);
    if (refused) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trueaxis: %s: %s\n", instance->setup.name, line);
        return tables_errno(refused);
    }
    instance->servo.tables = tables;
    atomic_store(&instance->shared.in_force, tables);
    atomic_store(&instance->shared.permitted, true);
    return 0;
}

static int function_export(struct instance *instance, const char *function_name, void (*function)(void *, long))
{
    char name[HAL_NAME_LEN + 1];
    rtapi_snprintf(name, sizeof name, "%s.%s", instance->setup.name, function_name);
    return hal_export_funct(name, function, instance, 1, 0, component);
}

static int instance_export(struct instance *instance)
{
    int refused = pins_export(instance, component);
    if (!refused)
        refused = function_export(instance, "update-feedback", cycle_update_feedback);
    if (!refused)
        refused = function_export(instance, "update-output", cycle_update_output);
    if (!refused)
        pins_limits(instance, instance->servo.tables);
    return refused;
}

int rtapi_app_main(void)
{
    if (trueaxis_check_abi(TRUEAXIS_ABI_VERSION) != TRUEAXIS_OK) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trueaxis: header and library are of different versions; needed: one build\n");
        return -EINVAL;
    }
    int refused = parameters_read();
    for (int i = 0; i < trueaxis_instance_count && !refused; i++)
        refused = instance_load(&trueaxis_instances[i]);
    if (refused)
        return refused;

    component = hal_init("trueaxis");
    if (component < 0)
        return component;
    for (int i = 0; i < trueaxis_instance_count && !refused; i++)
        refused = instance_export(&trueaxis_instances[i]);
    if (!refused)
        refused = reload_start();
    if (refused) {
        hal_exit(component);
        return refused;
    }
    hal_ready(component);
    return 0;
}

void rtapi_app_exit(void)
{
    reload_stop();
    hal_exit(component);
}
