/* Module parameters: the instances, their joints and files. */
#include "component.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define MAX_JOINT_TABLE_PARAMETERS (MAX_INSTANCES * MAX_JOINT_TABLES)
#define NOT_STATED (-1)
/* Tolerance of a unit given as a number: INI files have 0.03937 and 0.0394 for an inch. */
#define UNIT_ROUNDING 1e-3

static int count;
RTAPI_MP_INT(count, "number of instances, named trueaxis.0, trueaxis.1, ... (1 unless names are given)");
static char *names[MAX_INSTANCES];
RTAPI_MP_ARRAY_STRING(names, MAX_INSTANCES, "names of the instances, instead of count");
static char *tables[MAX_INSTANCES];
RTAPI_MP_ARRAY_STRING(tables, MAX_INSTANCES, "compiled table file (.tcomp) of every instance");
static char *joints[MAX_INSTANCES];
RTAPI_MP_ARRAY_STRING(joints, MAX_INSTANCES, "axis letter of joint 0, 1, ... of every instance, e.g. XYYZ");
static char *joint_tables[MAX_JOINT_TABLE_PARAMETERS];
RTAPI_MP_ARRAY_STRING(joint_tables, MAX_JOINT_TABLE_PARAMETERS,
                      "tables of single joints: [INSTANCE:]JOINT=FILE, e.g. 1=left.tcomp,2=right.tcomp");
static char *thermal[MAX_INSTANCES];
RTAPI_MP_ARRAY_STRING(thermal, MAX_INSTANCES, "thermal growth (.ttherm) of every instance that has it; - for none");
static char *units;
RTAPI_MP_STRING(units, "[TRAJ]LINEAR_UNITS: mm or inch");
static char *angular_units;
RTAPI_MP_STRING(angular_units, "[TRAJ]ANGULAR_UNITS: degree; needed with rotary joints");
static int inch[MAX_INSTANCES] = {[0 ... MAX_INSTANCES - 1] = NOT_STATED};
RTAPI_MP_ARRAY_INT(inch, MAX_INSTANCES, "1: linear joints of the instance are in inches, 0: mm; as units= says it");
static long servo_period_nsec = 1000000;
RTAPI_MP_LONG(servo_period_nsec, "period of the thread that the functions are added to");

#define COMPLAIN(...) rtapi_print_msg(RTAPI_MSG_ERR, "trueaxis: " __VA_ARGS__)

static bool copied(char *to, size_t bytes, const char *from)
{
    size_t length = strlen(from);
    if (length >= bytes)
        return false;
    memcpy(to, from, length + 1);
    return true;
}

static bool given(char *const *list, int index)
{
    return list[index] != NULL && list[index][0] != '\0';
}

static int instances_named(void)
{
    int named = 0;
    while (named < MAX_INSTANCES && given(names, named))
        named++;
    if (named > 0 && count > 0) {
        COMPLAIN("names= and count= were both given; needed: one of them\n");
        return -EINVAL;
    }
    if (named > 0)
        return named;
    if (count < 0 || count > MAX_INSTANCES) {
        COMPLAIN("count=%d; needed: 1 to %d\n", count, MAX_INSTANCES);
        return -EINVAL;
    }
    return count > 0 ? count : 1;
}

static int joint_letters(struct instance *instance, const char *letters)
{
    size_t joint_count = strlen(letters);
    if (joint_count > MAX_JOINTS || strspn(letters, "XYZABCxyzabc") != joint_count) {
        COMPLAIN("%s: joints=%s; needed: at most %d letters out of XYZABC, that of joint 0 first\n", instance->setup.name,
                 letters, MAX_JOINTS);
        return -EINVAL;
    }
    for (size_t i = 0; i < joint_count; i++)
        instance->setup.letters[i] = (char)(letters[i] & ~0x20);
    instance->setup.joints = (int)joint_count;
    return 0;
}

static struct instance *instance_of(const char *name, size_t length)
{
    for (int i = 0; i < trueaxis_instance_count; i++) {
        struct instance *instance = &trueaxis_instances[i];
        if (strlen(instance->setup.name) == length && memcmp(instance->setup.name, name, length) == 0)
            return instance;
    }
    return NULL;
}

static int joint_table(const char *text)
{
    struct instance *instance = trueaxis_instance_count == 1 ? &trueaxis_instances[0] : NULL;
    const char *rest = text;
    const char *equals = strchr(text, '=');
    const char *colon = strchr(text, ':');
    if (equals && colon && colon < equals) {
        instance = instance_of(text, (size_t)(colon - text));
        rest = colon + 1;
    }
    char *end = NULL;
    long joint = strtol(rest, &end, 10);
    if (!instance || !equals || end != equals || end == rest || joint < 0 || equals[1] == '\0') {
        COMPLAIN("joint_tables=%s; needed: JOINT=FILE, with several instances NAME:JOINT=FILE\n", text);
        return -EINVAL;
    }
    if (joint >= instance->setup.joints) {
        COMPLAIN("%s: a table for joint %ld; needed: a joint named in joints= (%d of them)\n", instance->setup.name, joint,
                 instance->setup.joints);
        return -EINVAL;
    }
    int table = instance->setup.joint_tables;
    if (table == MAX_JOINT_TABLES || instance->setup.table_of_joint[joint] >= 0) {
        COMPLAIN("%s: joint_tables=%s; needed: one table a joint, at most %d\n", instance->setup.name, text,
                 MAX_JOINT_TABLES);
        return -EINVAL;
    }
    if (!copied(instance->setup.joint_path[table], PATH_BYTES, equals + 1)) {
        COMPLAIN("%s: the path of joint %ld's table; needed: below %d bytes\n", instance->setup.name, joint, PATH_BYTES);
        return -ENAMETOOLONG;
    }
    instance->setup.joint_of_table[table] = (int)joint;
    instance->setup.table_of_joint[joint] = table;
    instance->setup.joint_tables = table + 1;
    return 0;
}

/* Whether a unit is one of the names (in upper or lower case) or the number, as in LinuxCNC's own INI files. */
static bool is_unit(const char *text, const char *const *unit_names, double per_unit)
{
    for (; *unit_names; unit_names++)
        if (strcasecmp(text, *unit_names) == 0)
            return true;
    char *end = NULL;
    double number = strtod(text, &end);
    return end != text && *end == '\0' && fabs(number / per_unit - 1.0) < UNIT_ROUNDING;
}

/* Returns 1 for inches, 0 for millimetres, NOT_STATED, or a negative errno after printing a line. The names are
 * LinuxCNC's; a number is in machine units per millimetre. */
static int inches_stated(void)
{
    static const char *const millimetres[] = {"mm", "metric", NULL}, *const inches[] = {"inch", "in", "imperial", NULL};
    if (!given(&units, 0))
        return NOT_STATED;
    if (is_unit(units, millimetres, 1.0))
        return 0;
    if (is_unit(units, inches, 1.0 / 25.4))
        return 1;
    COMPLAIN("units=%s; needed: mm or inch, as [TRAJ]LINEAR_UNITS of the machine\n", units);
    return -EINVAL;
}

static int angles_stated(bool *stated)
{
    static const char *const degrees[] = {"degree", "deg", NULL};
    *stated = given(&angular_units, 0);
    if (!*stated || is_unit(angular_units, degrees, 1.0))
        return 0;
    COMPLAIN("angular_units=%s; needed: degree, and [TRAJ]ANGULAR_UNITS of the machine in degrees\n", angular_units);
    return -EINVAL;
}

/* Determines the unit of the instance's linear joints; there is no default. */
static int instance_units(struct instance *instance, int index)
{
    int all = inches_stated(), own = inch[index];
    if (all < NOT_STATED)
        return all;
    if (own != NOT_STATED && own != 0 && own != 1) {
        COMPLAIN("%s: inch=%d; needed: 1 (inches) or 0 (mm)\n", instance->setup.name, own);
        return -EINVAL;
    }
    if (all == NOT_STATED && own == NOT_STATED) {
        COMPLAIN("%s: found no unit of length; needed: units=[TRAJ]LINEAR_UNITS where trueaxis is loaded, mm or inch\n",
                 instance->setup.name);
        return -EINVAL;
    }
    if (all != NOT_STATED && own != NOT_STATED && all != own) {
        COMPLAIN("%s: found units=%s and inch=%d; needed: one unit of length\n", instance->setup.name, units, own);
        return -EINVAL;
    }
    instance->setup.inch = (all == NOT_STATED ? own : all) == 1;
    return angles_stated(&instance->setup.degrees);
}

static int instance_read(struct instance *instance, int index)
{
    if (given(names, index)) {
        if (!copied(instance->setup.name, NAME_BYTES, names[index])) {
            COMPLAIN("names=%s; needed: below %d bytes\n", names[index], NAME_BYTES);
            return -EINVAL;
        }
    } else {
        rtapi_snprintf(instance->setup.name, NAME_BYTES, "trueaxis.%d", index);
    }
    if (!given(tables, index)) {
        COMPLAIN("%s: no table file; needed: tables=FILE.tcomp, one for every instance\n", instance->setup.name);
        return -EINVAL;
    }
    if (!copied(instance->setup.path, PATH_BYTES, tables[index])) {
        COMPLAIN("%s: the path of the table file; needed: below %d bytes\n", instance->setup.name, PATH_BYTES);
        return -ENAMETOOLONG;
    }
    if (given(thermal, index) && strcmp(thermal[index], "-") != 0 &&
        !copied(instance->setup.thermal_path, PATH_BYTES, thermal[index])) {
        COMPLAIN("%s: the path of the thermal growth; needed: below %d bytes\n", instance->setup.name, PATH_BYTES);
        return -ENAMETOOLONG;
    }
    instance->setup.period_ns = (uint32_t)servo_period_nsec;
    int refused = instance_units(instance, index);
    if (refused)
        return refused;
    for (int j = 0; j < MAX_JOINTS; j++)
        instance->setup.table_of_joint[j] = -1;
    instance->setup.letters_from_file = !given(joints, index);
    return instance->setup.letters_from_file ? 0 : joint_letters(instance, joints[index]);
}

int parameters_read(void)
{
    int instances = instances_named();
    if (instances < 0)
        return instances;
    if (servo_period_nsec < 1000 || servo_period_nsec > 100000000) {
        COMPLAIN("servo_period_nsec=%ld; needed: 1000 to 100000000\n", servo_period_nsec);
        return -EINVAL;
    }
    trueaxis_instance_count = instances;
    for (int i = 0; i < instances; i++) {
        int refused = instance_read(&trueaxis_instances[i], i);
        if (refused)
            return refused;
    }
    for (int i = 0; i < MAX_JOINT_TABLE_PARAMETERS && given(joint_tables, i); i++) {
        int refused = joint_table(joint_tables[i]);
        if (refused)
            return refused;
    }
    return 0;
}
