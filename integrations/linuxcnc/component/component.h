/* trueaxis for LinuxCNC: declarations shared by the parts of the component.
 *
 *   main.c        loading and unloading
 *   parameters.c  module parameters: instances, joints, files
 *   tables.c      builds a servo loop from a table file (never in realtime)
 *   reload.c      the thread that reads files while the machine moves
 *   hal_compat.h  the HAL interface of LinuxCNC 2.10, also on 2.9
 *   pins.c        HAL pins and parameters
 *   cycle.c       the two realtime functions
 *   steps.c       the library's steps in a cycle
 *   gauge.c       the roundness gauge in a cycle
 *   thermal.c     growth from temperatures, one update per second
 *   show.c        outputs of a cycle on pins
 *
 * License: MIT OR Apache-2.0
 */
#ifndef TRUEAXIS_COMPONENT_H
#define TRUEAXIS_COMPONENT_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hal_compat.h"
#include "trueaxis.h"

#define MAX_INSTANCES 4
#define MAX_JOINTS 9
#define MAX_JOINT_TABLES 4
#define MAX_AXES TRUEAXIS_AXES_MAX
/* HAL names have at most 47 characters, and ".joint.0.motor-pos-cmd-out" has 26. */
#define NAME_BYTES (HAL_NAME_LEN - 26 + 1)
#define PATH_BYTES 1024

/* Memory for the tables of one file, in one of the two buffers that an exchange needs. The file itself is larger. */
#define AXIS_TABLE_BYTES (768 * 1024)
#define JOINT_TABLE_BYTES (128 * 1024)
#define FILE_BYTES (1024 * 1024)
#define LINE_BYTES 320
/* More than any file of thermal growth needs: 16 sensors with 8 knots on 6 axes. */
#define THERMAL_BYTES (16 * 1024)
/* Distance between two points of the commanded path at slow feeds. */
#define WINDOW_SPACING_MM 0.005
/* A joint counts as at its commanded position if the reading is within this distance of it: mm, degrees. */
#define STANDING 0.05

/* Codes for refusals by the component itself; the library's results are smaller numbers. */
enum refusal {
    REFUSED_OPEN = 1000,
    REFUSED_LONG = 1001,
    REFUSED_JOINTS = 1002,
    REFUSED_GAUGE = 1003,
    REFUSED_LIMITS = 1004,
};

/* All data that a reload exchanges. The component owns the memory, because HAL has only 1 MiB for all components. */
struct tables {
    trueaxis_loop_t axes;
    trueaxis_loop_t joint[MAX_JOINT_TABLES];
    trueaxis_tables_info_t info;
    int joint_slot[MAX_JOINT_TABLES];         /* slot of the joint's axis in the joint's file */
    uint32_t joint_machine[MAX_JOINT_TABLES]; /* machine identity from that file */
    uint64_t axes_memory[AXIS_TABLE_BYTES / 8];
    uint64_t joint_memory[MAX_JOINT_TABLES][JOINT_TABLE_BYTES / 8];
};

struct joint {
    double offset;  /* motor-pos-cmd - pos-cmd: homing, backlash, COMP_FILE */
    double reading; /* raw, this cycle */
    double passed;  /* last finite reading, without correction */
    double own;     /* correction sent from the joint's own table */
    double sent;    /* whole correction sent */
    double drive;   /* motor position sent, once `known` */
    bool known;     /* a motor position may be sent */
};

struct joint_pins {
    hal_real_t pos_cmd, motor_cmd_in, motor_cmd_out, motor_fb_in, motor_fb_out, correction;
    /* The dynamic part of the correction, and its components. */
    hal_real_t dynamic, feed_forward, contour_feedback, crosstalk, learned;
    /* Factors in use on the identified friction; 1 where it does not adapt. */
    hal_real_t friction_factor, presliding_factor;
    hal_bool_t homed, alarm;
};

struct axis_pins {
    hal_real_t command, corrected, correction, temperature_rise;
    hal_real_t learned; /* for X, Y, Z */
    hal_real_t growth_offset, growth_slope;
    hal_bool_t limited, at_edge;
    /* Limits of the tables in force, read only, and the largest values that the integrator accepts; 0: any. */
    hal_real_t magnitude, slope, acceleration, travel_min, travel_max;
    hal_real_t max_magnitude, max_slope, max_acceleration;
};

struct contour_pins {
    hal_real_t error, normal, binormal, lag;
    hal_bool_t found, searching;
};

struct gauge_pins {
    hal_sint_t spindle_counts, index_counts, arm_counts;
    hal_bool_t index, new_part, idle;
    hal_real_t probe[3];
    hal_real_t roundness, infeed;
    hal_uint_t evaluated, skipped, discarded, flags, revolution_flags;
};

struct thermal_pins {
    hal_real_t temperature[TRUEAXIS_THERMAL_SENSORS_MAX];
    hal_uint_t status[TRUEAXIS_THERMAL_SENSORS_MAX];
    hal_real_t spindle_speed, tool_length;
    hal_bool_t believe, good, at_edge, spindle_missing;
};

/* Parts of the dynamic correction that can be switched off. */
#define DYNAMIC_PARTS 7

/* HAL shared memory: pins only. */
struct pins {
    hal_bool_t enable, motion_enabled, reset, reload;
    hal_bool_t enable_part[DYNAMIC_PARTS];
    hal_bool_t on_trial, adapt_freeze, adapt_reset;
    hal_bool_t active, frozen, limited, at_edge, fault, stop_request, no_output;
    hal_bool_t feedback_out, friction_out, lag_out;
    hal_bool_t tables_ok, reload_busy, reload_failed;
    hal_uint_t fault_code, reload_code, reloads, sequence, machine_id, tables_crc;
    hal_sint_t fault_axis;
    struct contour_pins tip, encoder;
    struct joint_pins joint[MAX_JOINTS];
    struct axis_pins axis[MAX_AXES];
    struct gauge_pins gauge;
    struct thermal_pins thermal;
};

/* Set while the component is loaded; only read afterwards. */
struct setup {
    char name[NAME_BYTES];
    char path[PATH_BYTES];
    char joint_path[MAX_JOINT_TABLES][PATH_BYTES];
    int joint_of_table[MAX_JOINT_TABLES];
    int joint_tables;
    char letters[MAX_JOINTS + 1];
    bool letters_from_file;
    int joints;
    int axis_of_joint[MAX_JOINTS];  /* slot of the joint's axis in the step */
    int table_of_joint[MAX_JOINTS]; /* the joint's own table, or -1 */
    char axis_letters[MAX_AXES];
    int letter_of_axis[MAX_AXES]; /* index in X Y Z A B C */
    int axes;
    int joints_of_axis[MAX_AXES];
    bool inch;    /* unit of linear joints; else mm */
    bool degrees; /* stated as the unit of rotary joints */
    double mm_per_unit[MAX_AXES]; /* 1 for rotary axes */
    uint32_t period_ns;
    bool has_gauge;
    char thermal_path[PATH_BYTES];
    bool has_thermal;
    uint32_t sensors;
};

/* Growth from temperatures: file and task. */
struct thermal {
    uint8_t file[THERMAL_BYTES]; /* the growth reads it in place */
    trueaxis_thermal_t growth;
    trueaxis_thermal_state_t task;
    trueaxis_growth_t last; /* size 0: not loaded */
    uint64_t since_ns;
    bool believed;
};

/* State of an instance in the servo thread, from the first cycle on. */
enum phase {
    PHASE_NEW,     /* not started yet */
    PHASE_REFUSED, /* the thread has another period: commands pass, a stop is requested */
    PHASE_BLIND,   /* nothing to hold yet: outputs follow the readings, a stop is requested */
    PHASE_HOLDING, /* the outputs are held, a stop is requested */
    PHASE_RUNNING, /* commands pass with their correction */
};

/* Written only by the servo thread. */
struct servo {
    enum phase phase;
    struct joint joint[MAX_JOINTS];
    const struct tables *tables;
    trueaxis_state_t axes_state;
    trueaxis_state_t joint_state[MAX_JOINT_TABLES];
    /* The states before this cycle, needed if more than one step decides on the output. */
    trueaxis_state_t axes_before, joint_before[MAX_JOINT_TABLES];
    /* Step that requests the stop. */
    struct {
        bool axes, joint[MAX_JOINT_TABLES];
    } stopped;
    trueaxis_command_window_t window;
    trueaxis_gauge_t gauge;
    trueaxis_gauge_state_t gauge_state;
    double temperature_rise[MAX_AXES];
    struct thermal thermal;
    bool growth_told; /* growth has been passed to the tables in force */
    /* Inputs of the last cycle, for edge detection. */
    struct {
        bool homed, reload, reset, index, new_part, adapt_freeze, adapt_reset;
    } last;
};

/* Shared between the servo thread and the loader thread. */
struct shared {
    _Atomic(const struct tables *) offered; /* written by the loader, accepted by the servo thread */
    _Atomic(const struct tables *) in_force;
    atomic_uint reload_wanted; /* incremented by the servo thread */
    atomic_bool permitted;     /* written by the loader: the limits are accepted */
    atomic_uint refused;       /* written by the servo thread: the library's result for its period, or 0 */
    atomic_uint thread_period_ns;
};

/* Written only by the loader thread. */
struct loader {
    struct tables slot[2];
    const struct tables *offer; /* read and offered, not accepted yet */
    unsigned reload_done;
    bool refusal_told;
};

struct instance {
    struct setup setup;
    struct servo servo;
    struct shared shared;
    struct loader loader;
    struct pins *pins; /* in HAL: the user writes the inputs, the servo thread the outputs, the loader reload_... */
};

extern struct instance trueaxis_instances[MAX_INSTANCES];
extern int trueaxis_instance_count;

/* parameters.c: fills the instances from the module parameters. Returns 0, or a negative errno after printing a
 * line. */
int parameters_read(void);

/* tables.c: reads the instance's files into `tables`. Returns 0, or the library's result or a `refusal` with one line of
 * text. If `before` is not NULL, it refuses files of another machine than that of `before`. */
uint32_t tables_read(const struct instance *instance, const struct tables *before, struct tables *tables,
                     char line[LINE_BYTES]);
/* Finds the file's axes among the joints. Returns 0, or a refusal and one line. */
uint32_t tables_match(struct instance *instance, const struct tables *tables, char line[LINE_BYTES]);
/* Builds the gauge of a machine that has one, with `points` points per revolution. */
uint32_t tables_gauge(struct instance *instance, uint32_t points, char line[LINE_BYTES]);
/* Reads the instance's thermal growth for this machine, if it has one. Returns 0, or a refusal and one line. */
uint32_t tables_thermal(struct instance *instance, uint32_t machine_id, char line[LINE_BYTES]);
/* The negative errno that corresponds to a result. */
int tables_errno(uint32_t refused);

/* pins.c */
int pins_export(struct instance *instance, int component);
/* Shows the limits of the tables in force. */
void pins_limits(struct instance *instance, const struct tables *tables);
/* TRUEAXIS_DYNAMICS_... bits of the parts that are switched off, and of the trial if that is on. */
uint8_t pins_parts_off(const struct pins *pins);
/* Whether the limits of the tables are within the largest values that the integrator accepts. */
bool pins_limits_accepted(const struct instance *instance, const struct tables *tables);

/* reload.c */
int reload_start(void);
void reload_stop(void);

/* steps.c: the library's steps of a cycle. */
void steps_start(struct instance *instance, uint32_t period_ns);
void steps_take_tables(struct instance *instance);
void steps_temperature(struct instance *instance);
/* Freezes the friction that adapts, frees it, or returns it to the identified figures. */
void steps_adaptation(struct instance *instance);
/* Collects command and readings of the axes. */
void steps_gather(const struct instance *instance, trueaxis_input_t *input);
/* Runs all steps and updates `phase`. Returns false if the library refused. */
bool steps_run(struct instance *instance, const trueaxis_input_t *input, trueaxis_output_t *axes,
               trueaxis_output_t joints[MAX_JOINT_TABLES]);

/* gauge.c: reads the gauge's readings of a cycle from pins, and writes its results to pins. */
void gauge_read(struct instance *instance, trueaxis_gauge_ride_t *ride);
void gauge_show(struct instance *instance, const trueaxis_gauge_ride_t *ride);

/* thermal.c: called in every cycle. Updates the growth once per second and passes it to new tables. */
void thermal_update(struct instance *instance, uint32_t period_ns);

/* show.c: writes the output of a cycle to pins. */
void show_cycle(const struct instance *instance, const trueaxis_input_t *input, const trueaxis_output_t *axes,
                const trueaxis_output_t joints[MAX_JOINT_TABLES]);
/* Writes the factors on the friction of the joints to pins. */
void show_friction(struct instance *instance);

/* cycle.c: the functions of the servo thread; `arg` is an instance. */
void cycle_update_feedback(void *arg, long period);
void cycle_update_output(void *arg, long period);

#endif
