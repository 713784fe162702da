/* The thread that reads files while the machine moves, and watches what the integrator accepts. */
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
    instance->offer = NULL;
    *pins->reload_code = code;
    *pins->reload_failed = code != 0;
    *pins->reload_busy = 0;
    *pins->reloads += 1;
}

/* Reads into the place that is not in force and offers it; the servo thread takes it between two cycles. */
static void begin(struct instance *instance)
{
    const struct tables *now = atomic_load_explicit(&instance->in_force, memory_order_acquire);
    struct tables *free_place = now == &instance->place[0] ? &instance->place[1] : &instance->place[0];
    char line[LINE_BYTES] = "";
    *instance->pins->reload_busy = 1;
    uint32_t refused = tables_read(instance, now, free_place, line);
    if (!refused && !pins_limits_accepted(instance, free_place)) {
        rtapi_snprintf(line, sizeof line, "%s: found limits of an axis above its max-magnitude, max-slope or "
                       "max-acceleration", instance->path);
        refused = REFUSED_LIMITS;
    }
    if (refused) {
        rtapi_print_msg(RTAPI_MSG_ERR, "trueaxis: %s: reload: %s; the tables in force stay\n", instance->name, line);
        finish(instance, refused);
        return;
    }
    instance->offer = free_place;
    atomic_store_explicit(&instance->offered, free_place, memory_order_release);
}

static void reload(struct instance *instance)
{
    unsigned wanted = atomic_load_explicit(&instance->reload_wanted, memory_order_acquire);
    if (instance->offer && atomic_load_explicit(&instance->in_force, memory_order_acquire) == instance->offer) {
        pins_limits(instance, instance->offer);
        finish(instance, 0);
    }
    if (!instance->offer && wanted != instance->reload_done) {
        instance->reload_done = wanted;
        begin(instance);
    }
}

/* Limits above what the integrator accepts by now switch the correction off, as `enable` does: bumpless. */
static void watch_limits(struct instance *instance)
{
    const struct tables *now = atomic_load_explicit(&instance->in_force, memory_order_acquire);
    bool permitted = pins_limits_accepted(instance, now);
    atomic_store_explicit(&instance->permitted, permitted, memory_order_release);
    *instance->pins->tables_ok = permitted && !atomic_load(&instance->refused);
}

/* A thread of another period stops the machine at once: why, the realtime functions cannot say. */
static void tell_refusal(struct instance *instance)
{
    if (instance->refusal_told || !atomic_load(&instance->refused))
        return;
    instance->refusal_told = true;
    rtapi_print_msg(RTAPI_MSG_ERR, "trueaxis: %s: found a thread of %u ns, needed servo_period_nsec=%u, or the other one\n",
                    instance->name, atomic_load(&instance->thread_period_ns), instance->period_ns);
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
    /* An ordinary thread, whatever the loader is; signals are the loader's business. */
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
