/* Builds a servo loop from a table file. Called while loading and by the loader thread, never in realtime. */
#include "component.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Memory for one file at a time. Loading is complete before the loader thread starts. */
static uint8_t file[FILE_BYTES];
static int open_errno;

static uint32_t read_whole(const char *path, uint8_t *to, size_t bytes, size_t *length, char line[LINE_BYTES])
{
    /* Nonblocking, because nobody may ever write to a pipe. */
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0) {
        open_errno = errno;
        rtapi_snprintf(line, LINE_BYTES, "cannot be opened: %s", strerror(open_errno));
        return REFUSED_OPEN;
    }
    struct stat status;
    if (fstat(descriptor, &status) == 0 && !S_ISREG(status.st_mode)) {
        close(descriptor);
        open_errno = EINVAL;
        rtapi_snprintf(line, LINE_BYTES, "cannot be read: found no ordinary file");
        return REFUSED_OPEN;
    }
    size_t done = 0;
    ssize_t part = 1;
    while (part != 0 && done < bytes) {
        part = read(descriptor, to + done, bytes - done);
        if (part < 0 && errno != EINTR)
            break;
        if (part > 0)
            done += (size_t)part;
    }
    open_errno = errno;
    close(descriptor);
    if (part < 0) {
        rtapi_snprintf(line, LINE_BYTES, "cannot be read: %s", strerror(open_errno));
        return REFUSED_OPEN;
    }
    if (done == bytes) {
        rtapi_snprintf(line, LINE_BYTES, "too long: found more than %zu bytes, needed less; fewer points", bytes - 1);
        return REFUSED_LONG;
    }
    *length = done;
    return 0;
}

static uint32_t file_read(const char *path, size_t *length, char line[LINE_BYTES])
{
    return read_whole(path, file, sizeof file, length, line);
}

/* Reads one file, checks all of it and builds its loop in the given memory. */
static uint32_t loop_read(const char *path, uint32_t machine_id, uint32_t period_ns, trueaxis_loop_t *loop,
                          trueaxis_tables_info_t *info, void *memory, size_t bytes, char line[LINE_BYTES])
{
    size_t length = 0;
    char found[LINE_BYTES] = "";
    trueaxis_error_t error = {.size = sizeof error};
    info->size = sizeof *info;
    uint32_t refused = file_read(path, &length, found);
    if (!refused) {
        int status = trueaxis_tables_info(file, length, info, &error);
        if (status == TRUEAXIS_OK && info->memory_bytes > bytes) {
            rtapi_snprintf(found, sizeof found, "too many points: found %llu bytes of tables, needed at most %zu",
                           (unsigned long long)info->memory_bytes, bytes);
            refused = REFUSED_LONG;
        } else {
            if (status == TRUEAXIS_OK)
                status = trueaxis_loop_build(loop, sizeof *loop, file, length, machine_id, period_ns, memory, bytes, &error);
            if (status != TRUEAXIS_OK)
                rtapi_snprintf(found, sizeof found, "%s", error.text[0] ? error.text : trueaxis_result_text(status));
            refused = (uint32_t)status;
        }
    }
    if (refused)
        rtapi_snprintf(line, LINE_BYTES, "%s: %s", path, found);
    return refused;
}

static bool names(const trueaxis_tables_info_t *info, char letter)
{
    return strchr(info->chain, letter) != NULL;
}

static int slot_of(const trueaxis_tables_info_t *info, char letter)
{
    for (uint32_t a = 0; a < info->axes; a++)
        if (info->letters[a] == letter)
            return (int)a;
    return -1;
}

/* A joint's own file must have a table for the joint's axis and for no other. */
static uint32_t joint_match(const struct instance *instance, int t, struct tables *tables,
                            const trueaxis_tables_info_t *info, char line[LINE_BYTES])
{
    char letter = instance->setup.letters[instance->setup.joint_of_table[t]];
    int slot = slot_of(info, letter);
    bool alone = slot >= 0 && info->rows[slot] > 0;
    for (uint32_t a = 0; a < info->axes; a++)
        if ((int)a != slot && info->rows[a] > 0)
            alone = false;
    if (!alone) {
        rtapi_snprintf(line, LINE_BYTES,
                       "%s: for joint %d: found tables of other axes or without %c, needed one of %c alone",
                       instance->setup.joint_path[t], instance->setup.joint_of_table[t], letter, letter);
        return REFUSED_JOINTS;
    }
    tables->joint_slot[t] = slot;
    return 0;
}

uint32_t tables_read(const struct instance *instance, const struct tables *before, struct tables *tables,
                     char line[LINE_BYTES])
{
    uint32_t period_ns = instance->setup.period_ns;
    uint32_t refused = loop_read(instance->setup.path, before ? before->info.machine_id : 0, period_ns, &tables->axes,
                                 &tables->info, tables->axes_memory, sizeof tables->axes_memory, line);
    for (int t = 0; t < instance->setup.joint_tables && !refused; t++) {
        trueaxis_tables_info_t info;
        refused = loop_read(instance->setup.joint_path[t], before ? before->joint_machine[t] : 0, period_ns,
                            &tables->joint[t], &info, tables->joint_memory[t], sizeof tables->joint_memory[t], line);
        if (!refused)
            refused = joint_match(instance, t, tables, &info, line);
        if (!refused)
            tables->joint_machine[t] = info.machine_id;
    }
    return refused;
}

uint32_t tables_match(struct instance *instance, const struct tables *tables, char line[LINE_BYTES])
{
    const trueaxis_tables_info_t *info = &tables->info;
    instance->setup.axes = (int)info->axes;
    for (int a = 0; a < instance->setup.axes; a++) {
        instance->setup.axis_letters[a] = info->letters[a];
        instance->setup.letter_of_axis[a] = (int)(strchr("XYZABC", info->letters[a]) - "XYZABC");
        instance->setup.mm_per_unit[a] = instance->setup.inch && strchr("XYZ", info->letters[a]) ? 25.4 : 1.0;
        if (instance->setup.joints < MAX_JOINTS && instance->setup.letters_from_file && names(info, info->letters[a]))
            instance->setup.letters[instance->setup.joints++] = info->letters[a];
    }
    for (int j = 0; j < instance->setup.joints; j++) {
        int slot = slot_of(info, instance->setup.letters[j]);
        if (slot < 0 || !names(info, instance->setup.letters[j])) {
            rtapi_snprintf(line, LINE_BYTES, "%s: found no axis %c (chain \"%s\"), needed for joints=%s", instance->setup.path,
                           instance->setup.letters[j], info->chain, instance->setup.letters);
            return REFUSED_JOINTS;
        }
        if (!strchr("XYZ", instance->setup.letters[j]) && !instance->setup.degrees) {
            rtapi_snprintf(line, LINE_BYTES, "found no unit of angle for axis %c, needed angular_units=[TRAJ]ANGULAR_UNITS",
                           instance->setup.letters[j]);
            return REFUSED_JOINTS;
        }
        instance->setup.axis_of_joint[j] = slot;
        instance->setup.joints_of_axis[slot]++;
    }
    for (int a = 0; a < instance->setup.axes; a++) {
        if (instance->setup.joints_of_axis[a] == 0 && names(info, info->letters[a])) {
            rtapi_snprintf(line, LINE_BYTES, "%s: found axis %c (chain \"%s\"), needed: a joint for it in joints=%s",
                           instance->setup.path, info->letters[a], info->chain, instance->setup.letters);
            return REFUSED_JOINTS;
        }
    }
    return 0;
}

uint32_t tables_gauge(struct instance *instance, uint32_t points, char line[LINE_BYTES])
{
    size_t length = 0;
    char found[LINE_BYTES] = "";
    trueaxis_error_t error = {.size = sizeof error};
    uint32_t refused = file_read(instance->setup.path, &length, found);
    if (!refused) {
        int status = trueaxis_gauge_build(&instance->servo.gauge, sizeof instance->servo.gauge, file, length, instance->setup.period_ns,
                                          &error);
        if (status == TRUEAXIS_OK) {
            size_t size = points == 512 ? sizeof(trueaxis_gauge_state_512_t) : sizeof instance->servo.gauge_state;
            status = trueaxis_gauge_restart(&instance->servo.gauge, &instance->servo.gauge_state, size);
        }
        if (status != TRUEAXIS_OK)
            rtapi_snprintf(found, sizeof found, "gauge: %s", error.text[0] ? error.text : trueaxis_result_text(status));
        refused = (uint32_t)status;
    }
    if (refused)
        rtapi_snprintf(line, LINE_BYTES, "%s: %s", instance->setup.path, found);
    instance->setup.has_gauge = !refused;
    return refused;
}

uint32_t tables_thermal(struct instance *instance, uint32_t machine_id, char line[LINE_BYTES])
{
    struct thermal *thermal = &instance->servo.thermal;
    const char *path = instance->setup.thermal_path;
    if (path[0] == '\0')
        return 0;
    char found[LINE_BYTES] = "";
    trueaxis_error_t error = {.size = sizeof error};
    size_t length = 0;
    uint32_t refused = read_whole(path, thermal->file, sizeof thermal->file, &length, found);
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

int tables_errno(uint32_t refused)
{
    switch (refused) {
    case 0: return 0;
    case REFUSED_OPEN: return open_errno > 0 ? -open_errno : -EIO;
    case REFUSED_LONG:
    case TRUEAXIS_ERROR_MEMORY: return -E2BIG;
    default: return -EINVAL;
    }
}
