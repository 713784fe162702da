/*
 * The part of grblHAL's interface that the plugin uses, for tests: types, hooks and functions with their documented
 * names and meanings, independently worded and without their other members. A real controller is built with grblHAL's
 * own headers.
 *
 * SPDX-License-Identifier: MIT OR Apache-2.0
 */
#ifndef DOUBLE_CORE_H
#define DOUBLE_CORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define Off 0
#define On 1
#ifndef N_AXIS
#define N_AXIS 3
#endif
#define X_AXIS 0
#define Y_AXIS 1
#define Z_AXIS 2
#define ASCII_EOL "\r\n"
#define bit(n) (1UL << (n))

typedef union {
    float values[N_AXIS];
    struct {
        float x, y, z;
    };
} coord_data_t;

typedef union {
    int32_t values[N_AXIS];
    struct {
        int32_t x, y, z;
    };
} mpos_t;

typedef union {
    uint8_t mask;
    uint8_t bits;
    uint8_t value;
    struct {
        uint8_t x : 1, y : 1, z : 1;
    };
} axes_signals_t;

/* States of the controller; idle: no bit set. */
typedef uint_fast16_t sys_state_t;
#define STATE_IDLE 0
#define STATE_ALARM bit(0)
#define STATE_CHECK_MODE bit(1)
#define STATE_HOMING bit(2)
#define STATE_CYCLE bit(3)
#define STATE_HOLD bit(4)
#define STATE_JOG bit(5)
#define STATE_SAFETY_DOOR bit(6)
#define STATE_SLEEP bit(7)

/* Functions that move along a line return "handled", or "aborted", whose value equals OK. */
typedef enum {
    Status_OK = 0,
    Status_Aborted = 0,
    Status_InvalidStatement = 3,
    Status_IdleError = 8,
    Status_TravelExceeded = 15,
    Status_Handled = 254
} status_code_t;
typedef enum { Message_Plain = 0, Message_Info, Message_Warning } message_type_t;
typedef enum { HomingMode_Seek = 0, HomingMode_Locate, HomingMode_Pulloff } homing_mode_t;

/* A move to be passed to the planner. */
typedef struct {
    float feed_rate; /* mm/min; with inverse_time 1/min */
    float rate_multiplier;
    union {
        uint32_t value;
        struct {
            uint16_t rapid_motion : 1, system_motion : 1, jog_motion : 1, backlash_motion : 1, no_feed_override : 1,
                inverse_time : 1, units_per_rev : 1, is_rpm_rate_adjusted : 1, is_laser_ppi_mode : 1, target_valid : 1,
                target_validated : 1, probing_toolsetter : 1, unassigned : 4;
            uint8_t coolant;
        };
    } condition;
    int32_t line_number;
} plan_line_data_t;

typedef struct {
    coord_data_t min, max;
} work_envelope_t;

typedef struct {
    struct {
        float steps_per_mm, max_travel; /* max_travel is stored negative */
    } axis[N_AXIS];
    struct {
        axes_signals_t dir_mask; /* axes whose switch is at the negative end */
        struct {
            bool force_set_origin;
        } flags;
    } homing;
    struct {
        struct {
            bool enabled;
        } flags;
        uint8_t axis;
        float target, pullout_increment; /* mm, machine coordinates; mm */
    } parking;
    struct {
        bool soft_limited;
    } probe;
    struct {
        struct {
            bool jog_soft_limited;
        } flags;
    } limits;
    float arc_tolerance;
} settings_t;
extern settings_t settings;

typedef enum {
    Parking_DoorClosed = 0,
    Parking_DoorAjar,
    Parking_Retracting,
    Parking_Cancel,
    Parking_Resuming
} parking_state_t;
typedef enum { Probing_Off = 0, Probing_Active } probing_state_t;

typedef union {
    uint8_t flags;
    struct {
        uint8_t end_motion : 1, execute_hold : 1, execute_sys_motion : 1, update_spindle_rpm : 1, unassigned : 4;
    };
} step_control_t;

typedef struct {
    bool abort, cancel, suspend;
    step_control_t step_control;
    parking_state_t parking_state;
    struct {
        uint8_t probe_succeeded : 1;
    } flags;
    volatile probing_state_t probing_state;
    axes_signals_t homed, soft_limits;
    work_envelope_t work_envelope;
    float home_position[N_AXIS];
    int32_t position[N_AXIS];       /* of the motors, steps */
    int32_t probe_position[N_AXIS]; /* of the motors when the probe triggered, steps */
} system_t;
extern system_t sys;

typedef struct {
    float position[N_AXIS]; /* the program's position, mm */
} parser_state_t;
extern parser_state_t gc_state;

typedef void (*on_state_change_ptr)(sys_state_t state);
typedef void (*on_homing_completed_ptr)(axes_signals_t cycle, bool success);
typedef struct {
    float x, y;
} point_2d_t;
typedef struct {
    uint8_t axis_0, axis_1, axis_linear;
} plane_t;

typedef bool (*travel_limits_ptr)(float *target, axes_signals_t axes, bool is_cartesian, work_envelope_t *envelope);
typedef bool (*arc_limits_ptr)(coord_data_t *target, coord_data_t *position, point_2d_t center, float radius, plane_t plane,
                               int32_t turns, work_envelope_t *envelope);
typedef void (*apply_travel_limits_ptr)(float *target, float *position, work_envelope_t *envelope);
typedef void (*on_execute_realtime_ptr)(sys_state_t state);
typedef void (*on_jog_cancel_ptr)(sys_state_t state);
typedef void (*on_report_options_ptr)(bool newopt);

typedef struct {
    on_state_change_ptr on_state_change;
    on_homing_completed_ptr on_homing_completed;
    on_jog_cancel_ptr on_jog_cancel;
    on_report_options_ptr on_report_options;
    on_execute_realtime_ptr on_execute_realtime;
    travel_limits_ptr check_travel_limits;
    arc_limits_ptr check_arc_travel_limits;
    apply_travel_limits_ptr apply_travel_limits;
} grbl_t;
extern grbl_t grbl;

typedef struct {
    struct {
        void (*write)(const char *text);
    } stream;
} grbl_hal_t;
extern grbl_hal_t hal;

typedef struct {
    const char *command;
    status_code_t (*execute)(sys_state_t state, char *args);
    union {
        uint8_t flags;
        struct {
            uint8_t noargs : 1, allow_blocking : 1, help_fn : 1;
        };
    } flags;
    union {
        const char *str;
        const char *(*fn)(const char *command);
    } help;
} sys_command_t;

typedef struct sys_commands_str {
    const uint8_t n_commands;
    const sys_command_t *commands;
    struct sys_commands_str *next;
} sys_commands_t;

typedef struct plan_block plan_block_t;
typedef void (*foreground_task_ptr)(void *data);

void system_register_commands(sys_commands_t *commands);
void system_convert_array_steps_to_mpos(float *position, int32_t *steps);
sys_state_t state_get(void);
bool task_run_on_startup(foreground_task_ptr fn, void *data);
void report_message(const char *text, message_type_t type);
void report_plugin(const char *name, const char *version);
char *ftoa(float value, uint8_t decimals);
coord_data_t *limits_homing_pulloff(coord_data_t *distance); /* with NULL it only returns the present one */
plan_block_t *plan_get_current_block(void);
float *plan_get_position(void);
void plan_sync_position(void);
void plan_data_init(plan_line_data_t *pl_data);
bool st_is_stepping(void);
/* Two bare statements, as in the core. */
#define sync_position()                                                                                                \
    plan_sync_position();                                                                                              \
    system_convert_array_steps_to_mpos(gc_state.position, sys.position)
#define gc_sync_position() system_convert_array_steps_to_mpos(gc_state.position, sys.position)

#endif
