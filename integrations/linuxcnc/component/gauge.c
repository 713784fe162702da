/* The roundness gauge in a cycle: reads probes and counts from pins, writes its results to pins. Realtime, like
 * cycle.c. */
#include "component.h"

void gauge_read(struct instance *instance, trueaxis_gauge_ride_t *ride)
{
    const struct gauge_pins *pins = &instance->pins->gauge;
    struct servo *servo = &instance->servo;
    ride->gauge = &servo->gauge;
    ride->state = &servo->gauge_state;
    ride->spindle = hal_get_si32(pins->spindle_counts);
    ride->index = hal_get_si32(pins->index_counts);
    ride->arm = hal_get_si32(pins->arm_counts);
    for (int k = 0; k < 3; k++)
        ride->readings[k] = hal_get_real(pins->probe[k]);
    ride->has_index = hal_get_bool(pins->index) && !servo->last.index;
    ride->new_part = hal_get_bool(pins->new_part) && !servo->last.new_part;
    ride->idle = hal_get_bool(pins->idle);
    servo->last.index = hal_get_bool(pins->index);
    servo->last.new_part = hal_get_bool(pins->new_part);
}

void gauge_show(struct instance *instance, const trueaxis_gauge_ride_t *ride)
{
    struct gauge_pins *pins = &instance->pins->gauge;
    struct servo *servo = &instance->servo;
    hal_set_real(pins->infeed, ride->infeed / instance->setup.mm_per_unit[0]);
    hal_set_ui32(pins->flags, ride->flags);
    trueaxis_evaluation_t latest = {.size = sizeof latest};
    if (!ride->finished || trueaxis_gauge_latest(&servo->gauge, &servo->gauge_state, &latest) != TRUEAXIS_OK)
        return;
    hal_set_real(pins->roundness, latest.peak_to_valley_um);
    hal_set_ui32(pins->evaluated, latest.evaluated);
    hal_set_ui32(pins->skipped, latest.skipped);
    hal_set_ui32(pins->discarded, latest.discarded);
    hal_set_ui32(pins->revolution_flags, latest.flags);
}
