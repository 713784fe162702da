/* The parts of HAL and RTAPI that the component uses: see double.h. */
#include "double.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COMPONENT 7
#define MAX_BLOCKS 512

struct pin double_pins[MAX_PINS];
int double_pin_count;
struct function double_functions[MAX_FUNCTIONS];
int double_function_count, double_fails, double_calls;
void (*double_hears)(const char *line);

static void *blocks[MAX_BLOCKS];
static int block_count;

static bool fails(void)
{
    return ++double_calls == double_fails;
}

static void must(bool holds, const char *what, const char *name)
{
    if (holds)
        return;
    fprintf(stderr, "double: %s: %s\n", name, what);
    exit(1);
}

int hal_init(const char *name)
{
    must(strlen(name) <= HAL_NAME_LEN, "a name that is too long", name);
    return fails() ? -ENOMEM : COMPONENT;
}

/* Frees the component's memory, so that the sanitizer detects a later access. Real HAL keeps it. */
int hal_exit(int component)
{
    must(component == COMPONENT, "hal_exit of another component", "");
    for (int i = 0; i < double_pin_count; i++)
        if (!double_pins[i].given)
            free(double_pins[i].value);
    for (int i = 0; i < block_count; i++)
        free(blocks[i]);
    double_pin_count = double_function_count = block_count = 0;
    return 0;
}

int hal_ready(int component)
{
    must(component == COMPONENT, "hal_ready of another component", "");
    return 0;
}

void *hal_malloc(long int size)
{
    if (fails() || block_count == MAX_BLOCKS)
        return NULL;
    void *block = malloc((size_t)size);
    must(block != NULL, "no memory", "hal_malloc");
    /* Fill with another value than zero, because HAL does not guarantee zeroed memory. */
    memset(block, 0xa5, (size_t)size);
    blocks[block_count++] = block;
    return block;
}

/* Adds a pin or parameter of that name and allocates its value. Values of 2.9 are exactly as large as the type. */
static int add(hal_type_t type, bool input, bool parameter, void **place, int component, const char *name)
{
#ifdef TRUEAXIS_HAL_HANDLES
    static const size_t bytes[] = {[HAL_BIT] = 8, [HAL_FLOAT] = 8, [HAL_S32] = 8, [HAL_U32] = 8};
#else
    static const size_t bytes[] = {[HAL_BIT] = sizeof(hal_bit_t), [HAL_FLOAT] = sizeof(real_t),
                                   [HAL_S32] = sizeof(hal_s32_t), [HAL_U32] = sizeof(hal_u32_t)};
#endif
    if (fails())
        return -ENOMEM;
    must(double_pin_count < MAX_PINS, "too many pins", name);
    must(component == COMPONENT, "a pin of another component", name);
    must(name[0] && strlen(name) <= HAL_NAME_LEN, "a name that is too long", name);
    for (int i = 0; i < double_pin_count; i++)
        must(strcmp(double_pins[i].name, name) != 0, "a name twice", name);
    struct pin *pin = &double_pins[double_pin_count];
    strcpy(pin->name, name);
    pin->type = type;
    pin->input = input;
    pin->parameter = parameter;
    pin->given = *place != NULL;
    if (!pin->given) {
        *place = malloc(bytes[type]);
        must(*place != NULL, "no memory", name);
        /* HAL zeroes a pin, but not the memory that it is given for a parameter. */
        memset(*place, 0, bytes[type]);
    }
    pin->value = *place;
    double_pin_count++;
    return 0;
}

#ifdef TRUEAXIS_HAL_HANDLES
#define NEW(call, inputs, is_parameter, kind, type, handle, c)                                                  \
    int hal_##call##_new_##kind(int component, hal_pdir_t way, handle *ref, c first, const char *format, ...)   \
    {                                                                                                           \
        char name[2 * HAL_NAME_LEN];                                                                            \
        void *place = NULL;                                                                                     \
        va_list words;                                                                                          \
        va_start(words, format);                                                                                \
        vsnprintf(name, sizeof name, format, words);                                                            \
        va_end(words);                                                                                          \
        int refused = add(type, way == inputs, is_parameter, &place, component, name);                          \
        if (!refused) {                                                                                         \
            *ref = place;                                                                                       \
            hal_set_##kind(*ref, first);                                                                        \
        }                                                                                                       \
        return refused;                                                                                         \
    }
NEW(pin, HAL_IN, false, bool, HAL_BIT, hal_bool_t, bool)
NEW(pin, HAL_IN, false, real, HAL_FLOAT, hal_real_t, double)
NEW(pin, HAL_IN, false, ui32, HAL_U32, hal_uint_t, uint32_t)
NEW(pin, HAL_IN, false, si32, HAL_S32, hal_sint_t, int32_t)
NEW(param, HAL_RW, true, real, HAL_FLOAT, hal_real_t, double)
#else
#define NEW(kind, type, c)                                                                 \
    int hal_pin_##kind##_new(const char *name, hal_pin_dir_t way, c **place, int component) \
    {                                                                                      \
        void *memory = NULL;                                                               \
        int refused = add(type, way == HAL_IN, false, &memory, component, name);           \
        if (!refused)                                                                      \
            *place = memory;                                                               \
        return refused;                                                                    \
    }
NEW(bit, HAL_BIT, hal_bit_t)
NEW(float, HAL_FLOAT, hal_float_t)
NEW(u32, HAL_U32, hal_u32_t)
NEW(s32, HAL_S32, hal_s32_t)

int hal_param_float_new(const char *name, hal_param_dir_t way, hal_float_t *memory, int component)
{
    void *place = (void *)memory;
    return add(HAL_FLOAT, way == HAL_RW, true, &place, component, name);
}
#endif

int hal_export_funct(const char *name, void (*call)(void *, long), void *argument, int floats, int reentrant, int component)
{
    if (fails())
        return -ENOMEM;
    must(component == COMPONENT && floats && !reentrant, "found other flags, needed a function with floats", name);
    must(double_function_count < MAX_FUNCTIONS && strlen(name) <= HAL_NAME_LEN, "too many, or too long a name", name);
    struct function *function = &double_functions[double_function_count++];
    strcpy(function->name, name);
    function->call = call;
    function->argument = argument;
    return 0;
}

struct pin *double_pin(const char *instance, const char *name)
{
    char whole[2 * HAL_NAME_LEN];
    snprintf(whole, sizeof whole, "%s.%s", instance, name);
    for (int i = 0; i < double_pin_count; i++)
        if (strcmp(double_pins[i].name, whole) == 0)
            return &double_pins[i];
    must(false, "found no such pin", whole);
    return NULL;
}

void rtapi_print_msg(msg_level_t level, const char *format, ...)
{
    char line[2048];
    va_list words;
    (void)level;
    va_start(words, format);
    int length = vsnprintf(line, sizeof line, format, words);
    va_end(words);
    must(length > 0 && (size_t)length < sizeof line && strchr(line, '\n') == line + length - 1, "found no line", line);
    if (double_hears)
        double_hears(line);
}

int rtapi_snprintf(char *to, unsigned long size, const char *format, ...)
{
    va_list words;
    va_start(words, format);
    int length = vsnprintf(to, size, format, words);
    va_end(words);
    return length;
}

int rtapi_vsnprintf(char *to, unsigned long size, const char *format, va_list words)
{
    return vsnprintf(to, size, format, words);
}
