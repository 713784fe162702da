/* HAL and RTAPI as the component knows them: see double.h. */
#include "double.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COMPONENT 7
#define MAX_BLOCKS 16

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

/* HAL keeps its memory; here it is gone, and whoever still reaches for it is seen. */
int hal_exit(int component)
{
    must(component == COMPONENT, "hal_exit of another component", "");
    for (int i = 0; i < double_pin_count; i++)
        if (!double_pins[i].parameter)
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
    /* Not zero, as HAL's memory need not be. */
    memset(block, 0xa5, (size_t)size);
    blocks[block_count++] = block;
    return block;
}

static int add(hal_type_t type, bool input, void *parameter, void **place, int component, const char *format, va_list words)
{
    if (fails())
        return -ENOMEM;
    must(double_pin_count < MAX_PINS, "too many pins", format);
    struct pin *pin = &double_pins[double_pin_count];
    int length = vsnprintf(pin->name, sizeof pin->name, format, words);
    must(component == COMPONENT, "a pin of another component", pin->name);
    must(length > 0 && length <= HAL_NAME_LEN, "a name that is too long", pin->name);
    for (int i = 0; i < double_pin_count; i++)
        must(strcmp(double_pins[i].name, pin->name) != 0, "a name twice", pin->name);
    static const size_t bytes[] = {[HAL_BIT] = sizeof(hal_bit_t), [HAL_FLOAT] = sizeof(real_t),
                                   [HAL_S32] = sizeof(hal_s32_t), [HAL_U32] = sizeof(hal_u32_t)};
    pin->type = type;
    pin->input = input;
    pin->parameter = parameter != NULL;
    /* No byte more than the type has. HAL zeroes a pin, and a parameter too. */
    pin->value = parameter ? parameter : malloc(bytes[type]);
    must(pin->value != NULL, "no memory", pin->name);
    memset((void *)pin->value, 0, bytes[type]);
    if (place)
        *place = pin->value;
    double_pin_count++;
    return 0;
}

#define PIN(kind, type, c)                                                                            \
    int hal_pin_##kind##_newf(hal_pin_dir_t way, c **place, int component, const char *format, ...)   \
    {                                                                                                 \
        va_list words;                                                                                \
        void *memory = NULL;                                                                          \
        va_start(words, format);                                                                      \
        int refused = add(type, way == HAL_IN, NULL, &memory, component, format, words);              \
        va_end(words);                                                                                \
        if (!refused)                                                                                 \
            *place = memory;                                                                          \
        return refused;                                                                               \
    }
PIN(bit, HAL_BIT, hal_bit_t)
PIN(float, HAL_FLOAT, hal_float_t)
PIN(u32, HAL_U32, hal_u32_t)
PIN(s32, HAL_S32, hal_s32_t)

int hal_param_float_newf(hal_param_dir_t way, hal_float_t *memory, int component, const char *format, ...)
{
    va_list words;
    va_start(words, format);
    int refused = add(HAL_FLOAT, way == HAL_RW, (void *)memory, NULL, component, format, words);
    va_end(words);
    return refused;
}

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
