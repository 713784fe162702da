/* The HAL interface of LinuxCNC 2.10, also on 2.9: handles (`hal_real_t` ...), read with `hal_get_...`, written with
 * `hal_set_...`, created with `hal_pin_new_...` and `hal_param_new_...`. The component uses no other part of HAL's
 * pins and parameters.
 *
 * 2.10 has all of these in its hal.h; the Makefile then defines TRUEAXIS_HAL_HANDLES, because LinuxCNC provides no
 * version. Pins and parameters have the same names, types (bit, float, u32, s32) and values on both.
 *
 * License: MIT OR Apache-2.0
 */
#ifndef TRUEAXIS_HAL_COMPAT_H
#define TRUEAXIS_HAL_COMPAT_H

#include <stdbool.h>
#include <stdint.h>

#include "rtapi.h"
#include "hal.h"

#ifndef TRUEAXIS_HAL_HANDLES
#include <errno.h>
#include <stdarg.h>

typedef hal_bit_t *hal_bool_t;
typedef hal_float_t *hal_real_t;
typedef hal_s32_t *hal_sint_t;
typedef hal_u32_t *hal_uint_t;

/* kind: name in 2.10; handle and value: types in 2.10; old: name in 2.9. HAL itself refuses a name that is too long. */
#define TRUEAXIS_HAL_KIND(kind, handle, value, old)                                                                          \
    static inline value hal_get_##kind(const handle ref)                                                                     \
    {                                                                                                                        \
        return *ref;                                                                                                         \
    }                                                                                                                        \
    static inline void hal_set_##kind(handle ref, value to)                                                                  \
    {                                                                                                                        \
        *ref = to;                                                                                                           \
    }                                                                                                                        \
    __attribute__((format(printf, 5, 6), unused)) static int hal_pin_new_##kind(                                             \
        int component, hal_pin_dir_t way, handle *ref, value first, const char *format, ...)                                 \
    {                                                                                                                        \
        char name[HAL_NAME_LEN + 2];                                                                                         \
        va_list words;                                                                                                       \
        va_start(words, format);                                                                                             \
        rtapi_vsnprintf(name, sizeof name, format, words);                                                                   \
        va_end(words);                                                                                                       \
        int refused = hal_pin_##old##_new(name, way, ref, component);                                                        \
        if (!refused)                                                                                                        \
            **ref = first;                                                                                                   \
        return refused;                                                                                                      \
    }                                                                                                                        \
    /* HAL allocates the value, so that this handle is like a pin's. */                                                      \
    __attribute__((format(printf, 5, 6), unused)) static int hal_param_new_##kind(                                           \
        int component, hal_param_dir_t way, handle *ref, value first, const char *format, ...)                               \
    {                                                                                                                        \
        char name[HAL_NAME_LEN + 2];                                                                                         \
        va_list words;                                                                                                       \
        *ref = hal_malloc(sizeof **ref);                                                                                     \
        if (!*ref)                                                                                                           \
            return -ENOMEM;                                                                                                  \
        **ref = first;                                                                                                       \
        va_start(words, format);                                                                                             \
        rtapi_vsnprintf(name, sizeof name, format, words);                                                                   \
        va_end(words);                                                                                                       \
        return hal_param_##old##_new(name, way, *ref, component);                                                            \
    }

TRUEAXIS_HAL_KIND(bool, hal_bool_t, bool, bit)
TRUEAXIS_HAL_KIND(real, hal_real_t, double, float)
TRUEAXIS_HAL_KIND(si32, hal_sint_t, int32_t, s32)
TRUEAXIS_HAL_KIND(ui32, hal_uint_t, uint32_t, u32)
#undef TRUEAXIS_HAL_KIND
#endif

#endif
