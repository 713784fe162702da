/* The roundness gauge in a cycle: probes and counts from pins, its results to pins. Realtime, as cycle.c. */
#include "component.h"

static void show(struct instance *instance, const trueaxis_gauge_cycle_t *cycle)
{
    struct gauge_pins *pins = &instance->pins->gauge;
    *pins->infeed = cycle->infeed / instance->mm_per_unit[0];
    *pins->flags = cycle->flags;
    trueaxis_evaluation_t latest = {.size = sizeof latest};
    if (!cycle->finished || trueaxis_gauge_latest(&instance->gauge, &instance->gauge_state, &latest) != TRUEAXIS_OK)
        return;
    *pins->roundness = latest.peak_to_valley_um;
    *pins->evaluated = latest.evaluated;
    *pins->skipped = latest.skipped;
    *pins->discarded = latest.discarded;
    *pins->revolution_flags = latest.flags;
}

int gauge_step(struct instance *instance, const trueaxis_input_t *input, trueaxis_output_t *output)
{
    const struct gauge_pins *pins = &instance->pins->gauge;
    trueaxis_probes_t probes = {.size = sizeof probes};
    probes.spindle = *pins->spindle_counts;
    probes.index = *pins->index_counts;
    probes.arm = *pins->arm_counts;
    for (int k = 0; k < 3; k++)
        probes.readings[k] = *pins->probe[k];
    probes.has_index = *pins->index && !instance->index_before;
    probes.new_part = *pins->new_part && !instance->new_part_before;
    probes.idle = *pins->idle;
    instance->index_before = *pins->index;
    instance->new_part_before = *pins->new_part;
    trueaxis_gauge_cycle_t cycle = {.size = sizeof cycle};
    const trueaxis_loop_t *axes = &instance->tables->axes;
    int status = trueaxis_step_with_gauge(axes, &instance->axes_state, input, NULL, NULL, &instance->gauge,
                                          &instance->gauge_state, &probes, output, &cycle);
    if (status == TRUEAXIS_OK || status == TRUEAXIS_ERROR_NO_OUTPUT)
        show(instance, &cycle);
    return status;
}
