/* The roundness gauge in a cycle: probes and counts from pins, its results to pins. Realtime, as cycle.c. */
#include "component.h"

void gauge_read(struct instance *instance, trueaxis_gauge_ride_t *ride)
{
    const struct gauge_pins *pins = &instance->pins->gauge;
    struct servo *servo = &instance->servo;
    ride->gauge = &servo->gauge;
    ride->state = &servo->gauge_state;
    ride->spindle = *pins->spindle_counts;
    ride->index = *pins->index_counts;
    ride->arm = *pins->arm_counts;
    for (int k = 0; k < 3; k++)
        ride->readings[k] = *pins->probe[k];
    ride->has_index = *pins->index && !servo->last.index;
    ride->new_part = *pins->new_part && !servo->last.new_part;
    ride->idle = *pins->idle;
    servo->last.index = *pins->index;
    servo->last.new_part = *pins->new_part;
}

void gauge_show(struct instance *instance, const trueaxis_gauge_ride_t *ride)
{
    struct gauge_pins *pins = &instance->pins->gauge;
    struct servo *servo = &instance->servo;
    *pins->infeed = ride->infeed / instance->setup.mm_per_unit[0];
    *pins->flags = ride->flags;
    trueaxis_evaluation_t latest = {.size = sizeof latest};
    if (!ride->finished || trueaxis_gauge_latest(&servo->gauge, &servo->gauge_state, &latest) != TRUEAXIS_OK)
        return;
    *pins->roundness = latest.peak_to_valley_um;
    *pins->evaluated = latest.evaluated;
    *pins->skipped = latest.skipped;
    *pins->discarded = latest.discarded;
    *pins->revolution_flags = latest.flags;
}
