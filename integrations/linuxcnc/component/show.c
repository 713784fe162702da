/* Shows the outputs of a cycle on pins, except those to the drives. Realtime, like cycle.c. */
#include "component.h"

static void show_contour(struct contour_pins *pins, const trueaxis_contour_t *contour, double mm_per_unit)
{
    hal_set_real(pins->error, contour->error / mm_per_unit);
    hal_set_real(pins->normal, contour->normal / mm_per_unit);
    hal_set_real(pins->binormal, contour->binormal / mm_per_unit);
    hal_set_real(pins->lag, contour->lag / mm_per_unit);
    hal_set_bool(pins->found, !(contour->flags & TRUEAXIS_CONTOUR_NOT_FOUND));
    hal_set_bool(pins->searching, (contour->flags & TRUEAXIS_CONTOUR_SEARCHING) != 0);
}

static void show_axes(const struct instance *instance, const trueaxis_input_t *input, const trueaxis_output_t *output)
{
    const trueaxis_record_t *record = &output->record;
    for (int a = 0; a < instance->setup.axes; a++) {
        if (instance->setup.joints_of_axis[a] == 0)
            continue;
        struct axis_pins *pins = &instance->pins->axis[a];
        double unit = instance->setup.mm_per_unit[a];
        hal_set_real(pins->command, input->command[a] / unit);
        if (instance->servo.phase != PHASE_BLIND)
            hal_set_real(pins->corrected, output->drive[a] / unit);
        hal_set_real(pins->correction, (record->correction[a] + record->dynamic.sent[a]) / unit);
        hal_set_bool(pins->limited, record->limited >> a & 1);
        hal_set_bool(pins->at_edge, record->at_edge >> a & 1);
    }
}

void show_cycle(const struct instance *instance, const trueaxis_input_t *input, const trueaxis_output_t *axes,
                const trueaxis_output_t joints[MAX_JOINT_TABLES])
{
    const struct setup *setup = &instance->setup;
    struct pins *pins = instance->pins;
    const trueaxis_record_t *record = &axes->record;
    uint32_t fault = record->fault;
    int fault_axis = record->fault_axis;
    bool limited = record->limited != 0, at_edge = record->at_edge != 0;
    bool frozen = record->status & TRUEAXIS_STATUS_FROZEN;
    for (int t = 0; t < setup->joint_tables; t++) {
        const trueaxis_record_t *own = &joints[t].record;
        limited |= own->limited != 0;
        at_edge |= own->at_edge != 0;
        frozen |= (own->status & TRUEAXIS_STATUS_FROZEN) != 0;
        if (fault == TRUEAXIS_FAULT_NONE && own->fault != TRUEAXIS_FAULT_NONE) {
            fault = own->fault;
            fault_axis = setup->axis_of_joint[setup->joint_of_table[t]];
        }
    }
    show_axes(instance, input, axes);
    hal_set_bool(pins->active, (record->status & TRUEAXIS_STATUS_ACTIVE) != 0);
    hal_set_bool(pins->frozen, frozen);
    hal_set_bool(pins->limited, limited);
    hal_set_bool(pins->at_edge, at_edge);
    hal_set_bool(pins->fault, fault != TRUEAXIS_FAULT_NONE);
    hal_set_ui32(pins->fault_code, fault);
    hal_set_si32(pins->fault_axis, fault != TRUEAXIS_FAULT_NONE ? fault_axis : -1);
    hal_set_bool(pins->stop_request, instance->servo.phase != PHASE_RUNNING);
    hal_set_bool(pins->feedback_out, (record->status & TRUEAXIS_STATUS_FEEDBACK_OUT) != 0);
    hal_set_bool(pins->friction_out, (record->status & TRUEAXIS_STATUS_FRICTION_OUT) != 0);
    hal_set_bool(pins->lag_out, (record->status & TRUEAXIS_STATUS_LAG_OUT) != 0);
    hal_set_bool(pins->no_output, instance->servo.phase == PHASE_BLIND);
    hal_set_ui32(pins->sequence, record->sequence);
    hal_set_ui32(pins->machine_id, record->machine_id);
    hal_set_ui32(pins->tables_crc, record->tables_crc);
    show_contour(&pins->tip, &record->tip, setup->mm_per_unit[0]);
    show_contour(&pins->encoder, &record->encoder, setup->mm_per_unit[0]);
}

void show_friction(struct instance *instance)
{
    const struct setup *setup = &instance->setup;
    struct servo *servo = &instance->servo;
    const struct tables *tables = servo->tables;
    for (int j = 0; j < setup->joints; j++) {
        int t = setup->table_of_joint[j];
        double level = 1.0, presliding = 1.0;
        /* The joint's own friction if that adapts, else that of its axis. */
        int result = t < 0 ? TRUEAXIS_ERROR_ARGUMENT
                           : trueaxis_friction_factors(&tables->joint[t], &servo->joint_state[t],
                                                       (uint32_t)tables->joint_slot[t], &level, &presliding);
        if (result != TRUEAXIS_OK)
            trueaxis_friction_factors(&tables->axes, &servo->axes_state, (uint32_t)setup->axis_of_joint[j], &level,
                                      &presliding);
        hal_set_real(instance->pins->joint[j].friction_factor, level);
        hal_set_real(instance->pins->joint[j].presliding_factor, presliding);
    }
}
