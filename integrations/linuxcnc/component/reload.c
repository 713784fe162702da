/* The loader thread: reads files while the machine moves, and monitors the limits that the integrator accepts. */
#include "component.h"

#include <pthread.h>
#include <signal.h>
#include <time.h>

#define LOOK_EVERY_NS 5000000

static pthread_t thread;
static atomic_bool ending;

static void pause_briefly(void)
{
    const struct timespec pause = {0, LOOK_EVERY_NS};
    nanosleep(&pause, NULL);
}

static void finish(struct instance *instance, uint32_t code)
{
    struct pins *pins = instance->pins;
    instance->loader.offer = NULL;
    hal_set_ui32(pins->reload_code, code);
    hal_set_bool(pins->reload_failed, code != 0);
    hal_set_bool(pins->reload_busy, 0);
    hal_set_ui32(pins->reloads, hal_get_ui32(pins->reloads) + 1);
}

/* Reads a file into the memory that is not in force and offers it; the servo thread accepts it between two cycles. */
static void begin(struct instance *instance)
{
    const struct tables *now = atomic_load_explicit(&instance->shared.in_force, memory_order_acquire);
    struct loader *loader = &instance->loader;
    struct tables *unused = now == &loader->slot[0] ? &loader->slot[1] : &loader->slot[0];
    char line[LINE_BYTES] = "";
    hal_set_bool(instance->pins->reload_busy, 1);
    uint32_t refused = tables_read(instance, now, unused, line);
    if (!refused && !pins_limits_accepted(instance, unused)) {
        rtapi_snprintf(line, sizeof line, "%s: found limits of an axis above its max-magnitude, max-slope or "
                       "max-acceleration", instance->setup.path);
        refused = REFUSED_LIMITS;
    }
    if (refused) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trueaxis: %s: reload: %s; the tables in force stay\n", instance->setup.name, line);
        finish(instance, refused);
        return;
    }
    instance->loader.offer = unused;
    atomic_store_explicit(&instance->shared.offered, unused, memory_order_release);
}

static void reload(struct instance *instance)
{
    unsigned wanted = atomic_load_explicit(&instance->shared.reload_wanted, memory_order_acquire);
    if (instance->loader.offer && atomic_load_explicit(&instance->shared.in_force, memory_order_acquire) == instance->loader.offer) {
        pins_limits(instance, instance->loader.offer);
        finish(instance, 0);
    }
    if (!instance->loader.offer && wanted != instance->loader.reload_done) {
        instance->loader.reload_done = wanted;
        begin(instance);
    }
}

/* Switches the correction off bumplessly, as `enable` does, if the tables' limits now exceed those that the integrator
 * accepts. */
static void watch_limits(struct instance *instance)
{
    const struct tables *now = atomic_load_explicit(&instance->shared.in_force, memory_order_acquire);
    bool permitted = pins_limits_accepted(instance, now);
    atomic_store_explicit(&instance->shared.permitted, permitted, memory_order_release);
    hal_set_bool(instance->pins->tables_ok, permitted && !atomic_load(&instance->shared.refused));
}

/* Prints why a thread with another period stopped the machine at once; the realtime functions cannot print. */
static void tell_refusal(struct instance *instance)
{
    if (instance->loader.refusal_told || !atomic_load(&instance->shared.refused))
        return;
    instance->loader.refusal_told = true;
    rtapi_print_msg(RTAPI_MSG_ERR, "trueaxis: %s: found a thread of %u ns, needed servo_period_nsec=%u, or the other one\n",
                    instance->setup.name, atomic_load(&instance->shared.thread_period_ns), instance->setup.period_ns);
}

static void *look_after(void *unused)
{
    (void)unused;
    while (!atomic_load(&ending)) {
        for (int i = 0; i < trueaxis_instance_count; i++) {
            reload(&trueaxis_instances[i]);
            watch_limits(&trueaxis_instances[i]);
            tell_refusal(&trueaxis_instances[i]);
        }
        pause_briefly();
    }
    return NULL;
}

int reload_start(void)
{
    /* An ordinary thread, whatever the loader's scheduling. The loader handles the signals. */
    pthread_attr_t attributes;
    const struct sched_param ordinary = {0};
    sigset_t all, before;
    pthread_attr_init(&attributes);
    pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
    pthread_attr_setschedpolicy(&attributes, SCHED_OTHER);
    pthread_attr_setschedparam(&attributes, &ordinary);
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    int refused = pthread_create(&thread, &attributes, look_after, NULL);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&attributes);
    return -refused;
}

void reload_stop(void)
{
    atomic_store(&ending, true);
    pthread_join(thread, NULL);
}
