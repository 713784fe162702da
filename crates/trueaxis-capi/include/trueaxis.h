/*
 * trueaxis: geometric error compensation and true contour error inside the servo step of an open CNC controller.
 *
 * Generated from the Rust source; do not edit. C99, usable from C++.
 *
 * Rules for all functions
 *   - Functions return TRUEAXIS_OK or a TRUEAXIS_ERROR_... code. Comments list the codes of a function by their
 *     endings, after "Errors:". In addition every function may return _NULL, _SIZE, _ALIGNMENT and _UNBUILT, and a
 *     function of a part that the build leaves out returns _LEFT_OUT. A function that refuses writes nothing (except a
 *     trueaxis_error_t).
 *   - No function panics, allocates, prints, locks or calls the operating system.
 *   - Objects (trueaxis_loop_t, ...) are storage of fixed size that the caller provides and should zero first. They
 *     hold no resources. Memory lent to an object must outlive it. An argument `..._size` is `sizeof` of the object.
 *   - The caller sets the member `size` of a structure that begins with it, once: `input.size = sizeof input;`.
 *   - Pointers are NULL or point to an object of their type. NULL is refused, except for `error` and where a function
 *     allows it. Arguments must not overlap in memory.
 *   - Two threads may use the same loop, path, kinematics and gauge at the same time, never the same state.
 *   - "Real-time safe" functions run in bounded time and may be called in the servo interrupt; call the others at the
 *     start of the program or in a background task. All are reentrant.
 *
 * Units: mm, degrees for rotary axes; time in ns; signs as in ISO 841 and ISO 230-1 (error = actual - ideal).
 *
 * Precision: define TRUEAXIS_SINGLE before including this header if, and only if, the library was built with
 * `--features single`.
 */

#ifndef TRUEAXIS_H
#define TRUEAXIS_H

#include <stddef.h>
#include <stdint.h>

/* Version of this header. Compare it with the library's by calling trueaxis_check_abi(TRUEAXIS_ABI_VERSION). */
#ifndef TRUEAXIS_ABI_MAJOR
#define TRUEAXIS_ABI_MAJOR 3
#endif
#ifndef TRUEAXIS_ABI_MINOR
#define TRUEAXIS_ABI_MINOR 4
#endif
#ifdef TRUEAXIS_SINGLE
#define TRUEAXIS_ABI_VERSION (UINT32_C(0x80000000) | (uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#else
#define TRUEAXIS_ABI_VERSION ((uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Bytes of lent memory per span of a path. A line takes one span per 16 mm, an arc one per 30°, a spline one or more
/// per knot interval.
#define TRUEAXIS_SPAN_BYTES 296
#endif

#if defined(TRUEAXIS_SINGLE)
/// Bytes of lent memory per span of a path. A line takes one span per 16 mm, an arc one per 30°, a spline one or more
/// per knot interval.
#define TRUEAXIS_SPAN_BYTES 168
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Bytes of lent memory per span of a tool path.
#define TRUEAXIS_TOOL_SPAN_BYTES 376
#endif

#if defined(TRUEAXIS_SINGLE)
/// Bytes of lent memory per span of a tool path.
#define TRUEAXIS_TOOL_SPAN_BYTES 208
#endif

/// Words of a `trueaxis_path_t`.
#define TRUEAXIS_PATH_WORDS 28

/// Number of spans in a `trueaxis_command_window_t`.
#define TRUEAXIS_COMMAND_WINDOW_SPANS 64

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_command_window_t`.
#define TRUEAXIS_COMMAND_WINDOW_WORDS 4864
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_command_window_t`.
#define TRUEAXIS_COMMAND_WINDOW_WORDS 2784
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_kinematics_t`.
#define TRUEAXIS_KINEMATICS_WORDS 48
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_kinematics_t`.
#define TRUEAXIS_KINEMATICS_WORDS 32
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_branch_tracker_t`.
#define TRUEAXIS_BRANCH_TRACKER_WORDS 20
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_branch_tracker_t`.
#define TRUEAXIS_BRANCH_TRACKER_WORDS 10
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_gauge_t`.
#define TRUEAXIS_GAUGE_WORDS 6400
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_gauge_t`.
#define TRUEAXIS_GAUGE_WORDS 3200
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_gauge_state_t`.
#define TRUEAXIS_GAUGE_STATE_WORDS 18048
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_gauge_state_t`.
#define TRUEAXIS_GAUGE_STATE_WORDS 9088
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_gauge_state_512_t`.
#define TRUEAXIS_GAUGE_STATE_512_WORDS 9216
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_gauge_state_512_t`.
#define TRUEAXIS_GAUGE_STATE_512_WORDS 4672
#endif

/// Measure nothing.
#define TRUEAXIS_MEASURE_NOTHING 0

/// Measure against `path` at `reference`.
#define TRUEAXIS_MEASURE_PATH 1

/// Measure against the last commands: X, Y, Z of each valid command are appended to `window`.
#define TRUEAXIS_MEASURE_COMMANDS 2

/// Measure tip and direction of the tool against `path` at `reference`, in workpiece coordinates, using `kinematics`.
#define TRUEAXIS_MEASURE_TOOL 3

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_loop_t`.
#define TRUEAXIS_LOOP_WORDS 1264
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_loop_t`.
#define TRUEAXIS_LOOP_WORDS 736
#endif

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_state_t`.
#define TRUEAXIS_STATE_WORDS 952
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_state_t`.
#define TRUEAXIS_STATE_WORDS 504
#endif

/// The foot is a minimum of the distance, bracketed by − and +.
#define TRUEAXIS_CONTOUR_BRACKETED 1

/// The foot is an end of an open path.
#define TRUEAXIS_CONTOUR_AT_END 2

/// The foot is a corner between two spans.
#define TRUEAXIS_CONTOUR_AT_CORNER 4

/// A second minimum may be nearby.
#define TRUEAXIS_CONTOUR_SECOND_MINIMUM 8

/// No foot was known from the last cycle: the search is sampling the path around the reference.
#define TRUEAXIS_CONTOUR_COLD 16

/// Not measured (no path, or a faulty reading); all other members are 0.
#define TRUEAXIS_CONTOUR_NOT_FOUND 32

/// The reference was outside its span and was clamped to the nearer end. If it was not finite, no error was measured.
#define TRUEAXIS_CONTOUR_REFERENCE 64

/// The search continues in the next cycle. With `TRUEAXIS_CONTOUR_NOT_FOUND` it has no foot yet; otherwise the error is
/// measured from the best point of the path so far, not from the foot.
#define TRUEAXIS_CONTOUR_SEARCHING 128

/// Largest number of axes of a machine.
#define TRUEAXIS_AXES_MAX 6

/// Bit of `dynamics_off`: friction at reversals.
#define TRUEAXIS_DYNAMICS_FRICTION 1

/// Bit of `dynamics_off`: velocity that the drive does not feed forward itself.
#define TRUEAXIS_DYNAMICS_LAG 2

/// Bit of `dynamics_off`: velocity error that an acceleration requires of the velocity loop.
#define TRUEAXIS_DYNAMICS_ACCELERATION 4

/// Bit of `dynamics_off`: contour feedback. It acts only in a step with a measure.
#define TRUEAXIS_DYNAMICS_FEEDBACK 8

/// Bit of `dynamics_off`: acceleration cross-talk.
#define TRUEAXIS_DYNAMICS_CROSSTALK 16

/// Bit of `dynamics_off`: learned correction.
#define TRUEAXIS_DYNAMICS_LEARNED 32

/// Bit of `dynamics_off`: lost motion taken up from the reversal of the command.
#define TRUEAXIS_DYNAMICS_TAKE_UP 64

/// All parts of the dynamic correction: bits of `dynamics_off`.
#define TRUEAXIS_DYNAMICS_ALL 127

/// Bit of `dynamics_off`: no part but a rule. Friction, lag and acceleration are off until the contour error shows that
/// they help, then act as far as it shows that, and are led out where they harm; the contour feedback acts on no error
/// at rest. Without a measure nothing is shown, and the three stay off. For drives whose figures are uncertain: 8 %
/// instead of 22 % of simulated plants get more than 5 % worse than without dynamic correction, at the price of little
/// gain on tracks of one or two seconds.
#define TRUEAXIS_DYNAMICS_ON_TRIAL 128

/// Bit of `record.status`: the machine is homed and enabled, the readings are valid, and the correction follows the
/// tables.
#define TRUEAXIS_STATUS_ACTIVE 1

/// Bit of `record.status`: the correction is frozen after a faulty reading.
#define TRUEAXIS_STATUS_FROZEN 2

/// Bit of `record.status`: the output holds, and the host must stop the machine.
#define TRUEAXIS_STATUS_STOP_REQUEST 4

/// Bit of `record.status`: the contour error was measured.
#define TRUEAXIS_STATUS_CONTOUR 8

/// Bit of `record.status`: `drive` was not written (`TRUEAXIS_ERROR_NO_OUTPUT`).
#define TRUEAXIS_STATUS_NO_OUTPUT 16

/// Bit of `record.status`: the contour feedback oscillated and is ramped out, until `enable` falls, a reset comes, or
/// the feedback is switched off.
#define TRUEAXIS_STATUS_FEEDBACK_OUT 32

/// Bit of `record.status`: on trial (`TRUEAXIS_DYNAMICS_ON_TRIAL`) the friction part made the contour error larger and
/// acts with a smaller share, until the error shows that it helps, a reset comes, or friction, lag and acceleration are
/// switched off.
#define TRUEAXIS_STATUS_FRICTION_OUT 64

/// Bit of `record.status`: the same of the lag or the acceleration part.
#define TRUEAXIS_STATUS_LAG_OUT 128

/// Words of a `trueaxis_encoder_t`.
#define TRUEAXIS_ENCODER_WORDS 8

/// Words of a `trueaxis_program_t`.
#define TRUEAXIS_PROGRAM_WORDS 4

#if !defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_learned_t`.
#define TRUEAXIS_LEARNED_WORDS 12
#endif

#if defined(TRUEAXIS_SINGLE)
/// Words of a `trueaxis_learned_t`.
#define TRUEAXIS_LEARNED_WORDS 11
#endif

/// Largest number of sensors of a `.ttherm` file.
#define TRUEAXIS_THERMAL_SENSORS_MAX 16

/// Words of a `trueaxis_thermal_t`.
#define TRUEAXIS_THERMAL_WORDS 10

/// Words of a `trueaxis_thermal_state_t`.
#define TRUEAXIS_THERMAL_STATE_WORDS 176

/// The sensor is good.
#define TRUEAXIS_SENSOR_GOOD 0

/// The sensor has no reading, or one that is not a number.
#define TRUEAXIS_SENSOR_MISSING 1

/// The reading is outside the plausible range, or jumped to exactly 85 or 0 degrees Celsius, which mean no reading.
#define TRUEAXIS_SENSOR_OUT_OF_RANGE 2

/// The reading changed by more than is plausible, and has neither returned since nor remained at its new value for an
/// hour.
#define TRUEAXIS_SENSOR_JUMPED 3

/// The sensor repeats one reading to the bit although the others change.
#define TRUEAXIS_SENSOR_STUCK 4

/// The sensor has not yet given three plausible readings that agree, spread over at least two seconds.
#define TRUEAXIS_SENSOR_STARTING 5

/// No fault.
#define TRUEAXIS_FAULT_NONE 0

/// A reading is not finite. With faults 1 to 11 the correction freezes and the command passes.
#define TRUEAXIS_FAULT_FEEDBACK_NOT_FINITE 1

/// A reading changed in one cycle by more than the axis can move, or is more than 1 mm (1 degree) outside the joint's
/// range.
#define TRUEAXIS_FAULT_FEEDBACK_JUMP 2

/// A reading does not change although the axis is commanded to move.
#define TRUEAXIS_FAULT_ENCODER_STUCK 3

/// The encoder interface reports an alarm (dropout).
#define TRUEAXIS_FAULT_ENCODER_ALARM 4

/// `elapsed_ns` differs from the period by more than a quarter, or too many cycles came early.
#define TRUEAXIS_FAULT_LATE_CYCLE 5

/// A reading moves against the command, or by about half or twice as much: sign or scale of the encoder are wrong.
#define TRUEAXIS_FAULT_FEEDBACK_RATIO 6

/// An axis whose friction adapts sticks and slips. Faults 12 to 15 are reported until a reset, while the correction
/// continues with the identified friction.
#define TRUEAXIS_FAULT_STICK_SLIP 12

/// The friction of an axis that adapts has the wrong sign at its reversals.
#define TRUEAXIS_FAULT_FRICTION_REVERSED 13

/// A command is not finite. With faults 16 to 31 the output holds and the step requests a stop.
#define TRUEAXIS_FAULT_COMMAND_NOT_FINITE 16

/// A command is outside the declared travel.
#define TRUEAXIS_FAULT_COMMAND_OUT_OF_TRAVEL 17

/// A command changed in one cycle by more than the axis can move.
#define TRUEAXIS_FAULT_COMMAND_JUMP 18

/// Command plus correction leaves the range of the joint.
#define TRUEAXIS_FAULT_JOINT_RANGE 19

/// The machine has no pose with the commanded tip and direction.
#define TRUEAXIS_FAULT_TOOL_UNREACHABLE 20

/// The pose is in the singular cone, and the end of a rotary travel keeps the tool further off than the cone.
#define TRUEAXIS_FAULT_SINGULAR_POSE 21

/// The commanded direction needs the other branch of the rotary axes.
#define TRUEAXIS_FAULT_BRANCH_CHANGE 22

/// The host's period is not the configured one. Faults from 32 on are reasons of a `trueaxis_loop_bypass`.
#define TRUEAXIS_FAULT_PERIOD_MISMATCH 32

/// The table file was refused.
#define TRUEAXIS_FAULT_TABLES_REFUSED 33

/// The tables need more memory than was lent.
#define TRUEAXIS_FAULT_CAPACITY_TOO_SMALL 34

/// Header and library differ in version.
#define TRUEAXIS_FAULT_ABI_MISMATCH 35

/// Largest telemetry frame of a record, bytes.
#define TRUEAXIS_FRAME_BYTES 384

/// No index pulse has been seen yet, or none is reliable.
#define TRUEAXIS_GAUGE_NO_INDEX 1

/// An expected index pulse was missing.
#define TRUEAXIS_GAUGE_INDEX_MISSING (1 << 1)

/// An index pulse came at a different count than before.
#define TRUEAXIS_GAUGE_INDEX_SHIFTED (1 << 2)

/// The spindle's count changed by more than a quarter turn in one cycle.
#define TRUEAXIS_GAUGE_SPINDLE_JUMP (1 << 3)

/// A probe is outside its range or not finite.
#define TRUEAXIS_GAUGE_PROBE_RANGE (1 << 4)

/// The arm's angle is outside ±90°, or contradicts the linkage.
#define TRUEAXIS_GAUGE_ARM (1 << 5)

/// The part turned backwards by more than one point.
#define TRUEAXIS_GAUGE_REVERSED (1 << 6)

/// The part turned by more than two points in one cycle.
#define TRUEAXIS_GAUGE_TOO_FAST (1 << 7)

/// The spindle has stopped.
#define TRUEAXIS_GAUGE_STOPPED (1 << 8)

/// The speed changed by more than a quarter within the revolution. A revolution with this or one of the following flags
/// is still evaluated.
#define TRUEAXIS_GAUGE_SPEED (1 << 9)

/// Revolutions were skipped because the work on an earlier one was not finished.
#define TRUEAXIS_GAUGE_SKIPPED (1 << 10)

/// The infeed was not updated.
#define TRUEAXIS_GAUGE_INFEED_FROZEN (1 << 11)

/// The infeed was limited over several revolutions and has been reduced.
#define TRUEAXIS_GAUGE_INFEED_REDUCED (1 << 12)

/// Largest telemetry frame of a revolution, bytes.
#define TRUEAXIS_GAUGE_FRAME_BYTES 1280

/// Result code of a function: `TRUEAXIS_OK` or one of `TRUEAXIS_ERROR_…`, never negative.
typedef int32_t trueaxis_result_t;

/// Contents of a table file. Arrays have `axes` elements in the step's order. For a linear axis that the machine lacks,
/// travel and limits are 0, and its command passes.
typedef struct trueaxis_tables_info_t {
    /// `sizeof(trueaxis_tables_info_t)`.
    uint32_t size;
    /// Number of axes of the step, 3 to 6.
    uint32_t axes;
    /// Letters of the axes, terminated by 0: X, Y, Z, then the machine's rotary axes in alphabetical order.
    char letters[8];
    /// Identity of the machine: CRC-32 of its name and chain.
    uint32_t machine_id;
    /// CRC-32 of the file, which identifies the version of the tables.
    uint32_t tables_crc;
    /// Number of passes of the exact inverse per cycle.
    uint32_t inverse_passes;
    /// Points per revolution of the gauge; 0 without a gauge.
    uint32_t gauge_points;
    /// Bytes of memory that `trueaxis_loop_build` needs.
    uint64_t memory_bytes;
    /// Number of rows in the axis' table; 0 without a table.
    uint32_t rows[TRUEAXIS_AXES_MAX];
    /// Low end of the travel, mm (deg). A command outside the travel is a fault.
    double travel_low[TRUEAXIS_AXES_MAX];
    /// High end of the travel, mm (deg).
    double travel_high[TRUEAXIS_AXES_MAX];
    /// Limit of the correction, mm (deg).
    double correction_limit[TRUEAXIS_AXES_MAX];
    /// Limit of the correction's rate, mm/s (deg/s).
    double slope_limit_per_s[TRUEAXIS_AXES_MAX];
    /// Limit of the correction's acceleration, mm/s² (deg/s²).
    double acceleration_limit_per_s2[TRUEAXIS_AXES_MAX];
    /// Name of the machine, UTF-8, terminated by 0.
    char name[72];
    /// Structural code of the machine (ISO 10791-6), terminated by 0.
    char chain[56];
} trueaxis_tables_info_t;

/// Details of a refusal, ready to print.
typedef struct trueaxis_error_t {
    /// `sizeof(trueaxis_error_t)`.
    uint32_t size;
    /// Result that the function returned.
    trueaxis_result_t result;
    /// Detail of `result`, 0 if it has none:
    /// - Table file: 1 too short, 2 too long, 3 not a `.tcomp`, 4 other format version, 5 wrong CRC-32, 6 settings not
    ///   readable, 7 table header not readable, 8 table too long, 9 payload too long, 10 machine id does not match the
    ///   name, 11 contents out of range (see `field`), 12 other machine, 13 grid header not readable, 14 grid too long.
    /// - Learned correction: 1 too short, 2 too long, 3 not a learned correction, 4 other format version, 5 wrong
    ///   CRC-32, 6 spacing, 7 resolution, 8 parts, 9 number of nodes, 10 not 0 at its ends, 11 other program, 12 other
    ///   path length, 13 other machine.
    /// - Thermal growth: 1 to 5 as for a learned correction, 6 sensors, 7 axes, 8 number of knots, 9 order of knots, 10
    ///   a time, 11 plausible readings, 12 an axis, 13 not 0, 14 a slope, 15 other machine.
    /// - Part left out: 1 grids, 2 volumetric, 3 rotary, 4 dynamic, 5 gauge, 6 curves, 7 toolpath, 8 growth.
    uint32_t code;
    /// Index of the element, from 0 (row of a table, knot of a spline); `UINT32_MAX` if the value is not in a list.
    uint32_t index;
    /// Value found, in mm, degrees or seconds; for lent memory in bytes.
    double found;
    /// Letter of the axis, or 0.
    char axis;
    /// Name of the setting, or of the part of a segment; may be empty. In a library without texts `#` and the number of
    /// the setting: `trueaxis explain setting NUMBER`.
    char field[31];
    /// Requirement that the value does not meet; may be empty.
    char needed[128];
    /// The whole refusal in one line of UTF-8.
    char text[256];
} trueaxis_error_t;

/// A programmed path: lines, arcs and splines, stored as spans in lent memory.
typedef struct trueaxis_path_t {
    uint64_t words[TRUEAXIS_PATH_WORDS];
} trueaxis_path_t;

#if !defined(TRUEAXIS_SINGLE)
/// Scalar type: `double`, or `float` with `TRUEAXIS_SINGLE`.
typedef double trueaxis_real_t;
#endif

#if defined(TRUEAXIS_SINGLE)
/// Scalar type: `double`, or `float` with `TRUEAXIS_SINGLE`.
typedef float trueaxis_real_t;
#endif

/// A point on a path: a span and a parameter within it. `trueaxis_path_reference` computes it from a segment and its
/// parameter.
typedef struct trueaxis_reference_t {
    /// Number of the span.
    uint32_t span;
    /// Parameter in the span, 0 to 1.
    trueaxis_real_t t;
} trueaxis_reference_t;

/// The last commanded points, used as the path by a host that does not know the programmed one. Belongs to the thread
/// that steps it.
typedef struct trueaxis_command_window_t {
    uint64_t words[TRUEAXIS_COMMAND_WINDOW_WORDS];
} trueaxis_command_window_t;

/// A machine's kinematic chain and its tool. Immutable except for the tool; may be copied and may be read from any
/// thread.
typedef struct trueaxis_kinematics_t {
    uint64_t words[TRUEAXIS_KINEMATICS_WORDS];
} trueaxis_kinematics_t;

/// A tool in workpiece coordinates.
typedef struct trueaxis_tool_t {
    /// Position of the tip, mm.
    trueaxis_real_t tip[3];
    /// Unit vector from the tip towards the spindle.
    trueaxis_real_t axis[3];
} trueaxis_tool_t;

/// Tracks the branch of the rotary axes. Belongs to the thread that steps it.
typedef struct trueaxis_branch_tracker_t {
    uint64_t words[TRUEAXIS_BRANCH_TRACKER_WORDS];
} trueaxis_branch_tracker_t;

/// Tables, limits and settings of a machine. Immutable; may be copied and may be read from any thread.
typedef struct trueaxis_loop_t {
    uint64_t words[TRUEAXIS_LOOP_WORDS];
} trueaxis_loop_t;

/// State that one cycle passes to the next. Belongs to the thread that steps it; a copy may be restored between two
/// cycles.
typedef struct trueaxis_state_t {
    uint64_t words[TRUEAXIS_STATE_WORDS];
} trueaxis_state_t;

#if !defined(TRUEAXIS_SINGLE)
/// Position of an axis: `double` in mm (rotary: degrees), or with `TRUEAXIS_SINGLE` `int32_t` in 1e-6 mm (1e-6
/// degrees).
typedef double trueaxis_position_t;
#endif

#if defined(TRUEAXIS_SINGLE)
/// Position of an axis: `double` in mm (rotary: degrees), or with `TRUEAXIS_SINGLE` `int32_t` in 1e-6 mm (1e-6
/// degrees).
typedef int32_t trueaxis_position_t;
#endif

/// Command and readings of a servo cycle. Axes are in the order of `trueaxis_tables_info_t.letters`; elements beyond
/// the machine's axes are ignored.
typedef struct trueaxis_input_t {
    /// `sizeof(trueaxis_input_t)`.
    uint32_t size;
    /// Time since the last cycle, ns: as measured, or the period. The correction freezes for this cycle, with
    /// `TRUEAXIS_FAULT_LATE_CYCLE`, if the time differs from the period by more than a quarter, or if less than 0.999
    /// of a period has passed for each cycle's worth of motion of the correction (one cycle's worth may be saved up).
    /// The limits of the correction therefore apply per second, however the cycles arrive. 0: no time has passed and
    /// nothing moves. The value in the first cycle is ignored. `trueaxis_elapsed_ns` converts a 64-bit time.
    uint32_t elapsed_ns;
    /// Commanded positions, uncorrected.
    trueaxis_position_t command[TRUEAXIS_AXES_MAX];
    /// Raw encoder positions. A value that is not finite, is beyond 1e9, or in single precision equals `INT32_MIN` or
    /// `INT32_MAX` is a dropout, so convert counts with saturation. In `command` such a value is a fault.
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /// Bit 0 = X, …: the encoder interface of the axis reports an alarm.
    uint8_t encoder_alarm;
    /// Not 0: all axes are homed.
    uint8_t homed;
    /// Not 0: compensate.
    uint8_t enable;
    /// A rising edge releases a latched stop request if the machine is near the held position.
    uint8_t reset;
    /// Fault with which `trueaxis_rtcp` rejected the tool (`TRUEAXIS_FAULT_COMMAND_NOT_FINITE` …); otherwise 0.
    uint8_t refusal;
    /// Axis of that fault.
    uint8_t refusal_axis;
    /// `TRUEAXIS_DYNAMICS_…` bits of the parts of the dynamic correction that are off in this cycle; 0: all parts that
    /// the tables configure are on. The limiter ramps each part in and out. `TRUEAXIS_DYNAMICS_ON_TRIAL` puts those
    /// that are on to the trial.
    uint8_t dynamics_off;
    /// Ignored.
    uint8_t reserved;
    /// Learned correction of X, Y, Z at this point of the program (`trueaxis_learned_at`), as positions counted from 0;
    /// 0 without one. An unusable position counts as 0. No effect in a bypass.
    trueaxis_position_t learned[3];
} trueaxis_input_t;

/// Angles, multipliers and limits of a gauge. Immutable; may be copied and may be read from any thread.
typedef struct trueaxis_gauge_t {
    uint64_t words[TRUEAXIS_GAUGE_WORDS];
} trueaxis_gauge_t;

/// State and results of a gauge of 1024 points. Belongs to the thread that steps it. Large: make it static.
typedef struct trueaxis_gauge_state_t {
    uint64_t words[TRUEAXIS_GAUGE_STATE_WORDS];
} trueaxis_gauge_state_t;

/// The path to measure against. Only the members that `kind` needs are read.
typedef struct trueaxis_measure_t {
    /// `sizeof(trueaxis_measure_t)`.
    uint32_t size;
    /// `TRUEAXIS_MEASURE_…`.
    uint32_t kind;
    /// The path; for a tool a path started by `trueaxis_path_start_tool`.
    const struct trueaxis_path_t *path;
    /// Position of this cycle's command on the path.
    struct trueaxis_reference_t reference;
    /// The last commands.
    struct trueaxis_command_window_t *window;
    /// The machine's kinematics.
    const struct trueaxis_kinematics_t *kinematics;
    /// Written by a step with `TRUEAXIS_MEASURE_TOOL`: ideal × actual direction, a small rotation in rad, workpiece
    /// coordinates.
    trueaxis_real_t direction_error[3];
} trueaxis_measure_t;

/// A gauge of three probes in a cycle: its readings, and its results in the members marked "Written".
typedef struct trueaxis_gauge_ride_t {
    /// `sizeof(trueaxis_gauge_ride_t)`.
    uint32_t size;
    /// Counts of the spindle's encoder, wrapping.
    int32_t spindle;
    /// With `has_index`: counts latched by the index pulse, or those of this cycle.
    int32_t index;
    /// Counts of the arm's encoder, 0 where the arm points along the line of centres; ignored without an arm.
    int32_t arm;
    /// The gauge.
    const struct trueaxis_gauge_t *gauge;
    /// Its state; one for 512 points cast from `trueaxis_gauge_state_512_t *`.
    struct trueaxis_gauge_state_t *state;
    /// Raw values of the three probes, in the unit of their gain.
    trueaxis_real_t readings[3];
    /// Not 0: an index pulse has come since the last cycle.
    uint8_t has_index;
    /// Not 0: another workpiece; the infeed returns to zero and the evaluation restarts.
    uint8_t new_part;
    /// Not 0: the wheel does not grind; the gauge measures but does not update the infeed.
    uint8_t idle;
    /// Written: 1 if a revolution has just been evaluated.
    uint8_t finished;
    /// Written: `TRUEAXIS_GAUGE_…` bits of this cycle.
    uint16_t flags;
    /// Ignored.
    uint8_t reserved[2];
    /// Written: infeed requested of its axis, mm in the axis' sense; `drive` includes as much of it as the limits
    /// allow.
    trueaxis_real_t infeed;
} trueaxis_gauge_ride_t;

/// The dynamic correction of a cycle by axis, mm (rotary axes: degrees). `sent` is the limited sum of the other
/// members.
typedef struct trueaxis_dynamic_t {
    /// Sent: `drive = command + correction + sent`.
    trueaxis_real_t sent[TRUEAXIS_AXES_MAX];
    /// Requested for friction, lag and acceleration.
    trueaxis_real_t feed_forward[TRUEAXIS_AXES_MAX];
    /// Requested by the contour feedback.
    trueaxis_real_t feedback[TRUEAXIS_AXES_MAX];
    /// Requested against cross-talk.
    trueaxis_real_t crosstalk[TRUEAXIS_AXES_MAX];
    /// Requested by the learned correction.
    trueaxis_real_t learned[TRUEAXIS_AXES_MAX];
} trueaxis_dynamic_t;

/// Contour error. Lengths in mm.
typedef struct trueaxis_contour_t {
    /// Span that contains the foot.
    uint32_t span;
    /// Number of evaluations of the path in this cycle.
    uint8_t evaluations;
    /// `TRUEAXIS_CONTOUR_…` bits.
    uint8_t flags;
    /// 0.
    uint16_t reserved;
    /// Parameter of the foot in the span, 0 to 1.
    trueaxis_real_t t;
    /// Distance from the path, |actual − foot|.
    trueaxis_real_t error;
    /// Actual − foot along X, Y, Z.
    trueaxis_real_t vector[3];
    /// Component in the machining plane, positive to the left of the path.
    trueaxis_real_t normal;
    /// Component along the plane's normal.
    trueaxis_real_t binormal;
    /// Component along the path; 0 except at ends and corners.
    trueaxis_real_t tangential;
    /// Arc length from the foot to the reference; positive while the tool lags.
    trueaxis_real_t lag;
    /// Remaining width of the bracket around the foot, as an arc length.
    trueaxis_real_t width;
} trueaxis_contour_t;

/// Telemetry of a cycle. Positions are of type `trueaxis_position_t`, all other lengths in mm (rotary axes: degrees).
typedef struct trueaxis_record_t {
    /// Number of the cycle, counted from 0, wrapping.
    uint32_t sequence;
    /// Machine identity from the tables; 0 in a bypass.
    uint32_t machine_id;
    /// CRC-32 of the table file; 0 in a bypass.
    uint32_t tables_crc;
    /// `TRUEAXIS_FAULT_…`.
    uint8_t fault;
    /// Axis of the fault.
    uint8_t fault_axis;
    /// `TRUEAXIS_STATUS_…` bits.
    uint8_t status;
    /// One bit per axis: the correction differs from the wanted one because of a limit.
    uint8_t limited;
    /// One bit per axis: the position is outside the axis' table, and the value at the edge applies.
    uint8_t at_edge;
    /// `TRUEAXIS_CONTOUR_…` bits of the orientation error.
    uint8_t orientation_flags;
    /// 1: the tables configure a dynamic correction, and `dynamic` is that of this cycle. 0: `dynamic` is all 0.
    uint8_t has_dynamic;
    /// 0.
    uint8_t reserved[5];
    /// Command in force: that of this cycle, or the held one.
    trueaxis_position_t command[TRUEAXIS_AXES_MAX];
    /// Raw feedback; after a fault the last good one.
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /// Geometric correction sent: `drive − command` before rounding to a position, minus `dynamic.sent`.
    trueaxis_real_t correction[TRUEAXIS_AXES_MAX];
    /// The dynamic correction sent in addition, and the parts that make it up.
    struct trueaxis_dynamic_t dynamic;
    /// Contour error of the estimated tip.
    struct trueaxis_contour_t tip;
    /// Contour error of the encoder position.
    struct trueaxis_contour_t encoder;
    /// Orientation contour error, rad; 0 except with `TRUEAXIS_MEASURE_TOOL`.
    trueaxis_real_t orientation;
} trueaxis_record_t;

/// Output of a servo cycle.
typedef struct trueaxis_output_t {
    /// `sizeof(trueaxis_output_t)`.
    uint32_t size;
    /// Number of axes.
    uint32_t axes;
    /// Corrected positions for the drives; not written with `TRUEAXIS_ERROR_NO_OUTPUT`.
    trueaxis_position_t drive[TRUEAXIS_AXES_MAX];
    /// Feedback for the host, minus the correction sent, so that the correction does not appear as a following error.
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /// Telemetry of the cycle.
    struct trueaxis_record_t record;
} trueaxis_output_t;

/// An incremental encoder and its count so far. Belongs to the thread that reads it.
typedef struct trueaxis_encoder_t {
    uint64_t words[TRUEAXIS_ENCODER_WORDS];
} trueaxis_encoder_t;

/// The path of a program while its id is being computed.
typedef struct trueaxis_program_t {
    uint64_t words[TRUEAXIS_PROGRAM_WORDS];
} trueaxis_program_t;

/// A learned correction, read in place from the bytes of its file (`trueaxis learn`). Immutable; may be copied.
typedef struct trueaxis_learned_t {
    uint64_t words[TRUEAXIS_LEARNED_WORDS];
} trueaxis_learned_t;

/// Thermal growth, read in place from the bytes of its file (`trueaxis thermal compile`). Immutable; may be copied.
typedef struct trueaxis_thermal_t {
    uint64_t words[TRUEAXIS_THERMAL_WORDS];
} trueaxis_thermal_t;

/// State that one update of the task passes to the next. Belongs to the thread that updates it.
typedef struct trueaxis_thermal_state_t {
    uint64_t words[TRUEAXIS_THERMAL_STATE_WORDS];
} trueaxis_thermal_state_t;

/// Readings for one update.
typedef struct trueaxis_thermal_readings_t {
    /// `sizeof(trueaxis_thermal_readings_t)`.
    uint32_t size;
    /// Number of temperatures, at most 16; further sensors of the file count as missing.
    uint32_t count;
    /// Time since the previous update, s; 0 in the first.
    double dt_s;
    /// Temperatures in the order of the file, degrees Celsius; NaN for a missing reading.
    double temperatures_c[TRUEAXIS_THERMAL_SENSORS_MAX];
    /// Speed of the spindle, rpm; NaN if unknown.
    double spindle_rpm;
    /// Length of the tool from the spindle's nose, mm.
    double tool_mm;
} trueaxis_thermal_readings_t;

/// Growth after an update. Arrays over axes are in the order X, Y, Z, A, B, C.
typedef struct trueaxis_growth_t {
    /// `sizeof(trueaxis_growth_t)`.
    uint32_t size;
    /// Axes that the file names, as bits (bit 0: X).
    uint32_t axes;
    /// Offset of the line, mm (deg). It is an error that is added, actual − ideal.
    double offset[6];
    /// Slope of the line, from the datum of the machine's table file.
    double slope[6];
    /// `TRUEAXIS_SENSOR_…` of every sensor. The contribution of a sensor does not change while it is not good.
    uint8_t sensors[TRUEAXIS_THERMAL_SENSORS_MAX];
    /// Sensors beyond the ends of their curves, where the edge value applies, as bits (bit 0: the first sensor).
    uint32_t at_edge;
    /// Axes whose growth exceeds the range of the step, as bits (bit 0: X); the previous line remains in force.
    uint32_t beyond;
    /// 1: every sensor has started. Until then the growth is zero.
    uint8_t complete;
    /// 1: the spindle's speed is unknown; its contribution does not change.
    uint8_t spindle_missing;
    /// 1: every sensor and the spindle's speed are good, and the step accepts every growth.
    uint8_t good;
    /// 0.
    uint8_t reserved[5];
} trueaxis_growth_t;

/// Error motion of the spindle in one direction, µm.
typedef struct trueaxis_motion_t {
    /// Synchronous, without the once-per-revolution part.
    trueaxis_real_t synchronous_um;
    /// Asynchronous; 0 for a single revolution.
    trueaxis_real_t asynchronous_um;
    /// Amplitude of cos θ: eccentricity and fundamental error motion.
    trueaxis_real_t cosine_um;
    /// Amplitude of sin θ.
    trueaxis_real_t sine_um;
    /// Total.
    trueaxis_real_t total_um;
} trueaxis_motion_t;

/// The latest revolution, and counters of all revolutions.
typedef struct trueaxis_evaluation_t {
    /// `sizeof(trueaxis_evaluation_t)`.
    uint32_t size;
    /// Number of the revolution, from 1, wrapping.
    uint32_t revolution;
    /// Number of revolutions sampled completely so far.
    uint32_t sampled;
    /// Number of revolutions evaluated so far.
    uint32_t evaluated;
    /// Number of revolutions skipped completely so far.
    uint32_t skipped;
    /// Number of revolutions discarded completely so far.
    uint32_t discarded;
    /// `TRUEAXIS_GAUGE_…` bits of this revolution.
    uint16_t flags;
    /// Number of revolutions in the window of the error motions; 0 until the window is full.
    uint16_t revolutions;
    /// 1: no work is pending, and all members describe the same revolution.
    uint8_t settled;
    /// 0.
    uint8_t reserved[3];
    /// Peak-to-valley roundness about the least-squares circle, filtered, µm.
    trueaxis_real_t peak_to_valley_um;
    /// Error motion across probe 1.
    struct trueaxis_motion_t x;
    /// Error motion along probe 1.
    struct trueaxis_motion_t y;
} trueaxis_evaluation_t;

/// State and results of a gauge of 512 points, half as large: pass `(trueaxis_gauge_state_t *)&it` and its own size.
typedef struct trueaxis_gauge_state_512_t {
    uint64_t words[TRUEAXIS_GAUGE_STATE_512_WORDS];
} trueaxis_gauge_state_512_t;

/// The function succeeded.
#define TRUEAXIS_OK 0

/// A required pointer is `NULL`.
#define TRUEAXIS_ERROR_NULL 1

/// Wrong `size` member or size argument: not set, from another header, or `TRUEAXIS_SINGLE` is not as the library was
/// built.
#define TRUEAXIS_ERROR_SIZE 2

/// A pointer is not aligned. Memory for tables and paths needs 8 bytes.
#define TRUEAXIS_ERROR_ALIGNMENT 3

/// An object was never built or started, or is of another kind.
#define TRUEAXIS_ERROR_UNBUILT 4

/// Header and library differ in version or precision.
#define TRUEAXIS_ERROR_ABI 5

/// Not a whole, undamaged `.tcomp` file of this format; see `trueaxis_error_t`.
#define TRUEAXIS_ERROR_TABLES 6

/// The file, the kinematics, the learned correction or the thermal growth belong to another machine.
#define TRUEAXIS_ERROR_MACHINE 7

/// The settings are not valid; see `trueaxis_error_t`.
#define TRUEAXIS_ERROR_CONFIG 8

/// The lent memory is too small.
#define TRUEAXIS_ERROR_MEMORY 9

/// The period differs from that of the loop by more than 0.1 %.
#define TRUEAXIS_ERROR_PERIOD 10

/// Loop and state differ in the number of axes, or the number is not 3 to 6.
#define TRUEAXIS_ERROR_AXES 11

/// The state was started by a loop of the other kind (bypass or not): start a new one.
#define TRUEAXIS_ERROR_STATE 12

/// An argument is out of range; the description of the function lists the conditions.
#define TRUEAXIS_ERROR_ARGUMENT 13

/// The buffer is too small.
#define TRUEAXIS_ERROR_BUFFER 14

/// The segment is not valid; see `trueaxis_error_t`.
#define TRUEAXIS_ERROR_PATH 15

/// The machine has no gauge, or one with another number of points.
#define TRUEAXIS_ERROR_GAUGE 16

/// No value is available yet.
#define TRUEAXIS_ERROR_NOT_YET 17

/// The cycle was executed, but has no drive positions: no valid command has come, and not every axis has been read. The
/// whole output except `drive` is written. Leave the drives without power.
#define TRUEAXIS_ERROR_NO_OUTPUT 18

/// The kinematics cannot reach the pose; see `trueaxis_error_t`.
#define TRUEAXIS_ERROR_POSE 19

/// Not a whole, undamaged learned correction of this format, or one of another program; see `trueaxis_error_t`.
#define TRUEAXIS_ERROR_LEARNED 20

/// Not a whole, undamaged `.ttherm` file of this format; see `trueaxis_error_t`.
#define TRUEAXIS_ERROR_THERMAL 21

/// The function, or a setting of the table file, needs a part that this build of the library leaves out; see
/// `trueaxis_error_t`.
#define TRUEAXIS_ERROR_LEFT_OUT 22

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Returns the version of the library: `major << 16 | minor`, the top bit set for single precision. Real-time safe.
uint32_t trueaxis_abi_version(void);

/// Checks whether a program compiled with a header of version `TRUEAXIS_ABI_VERSION` can use this library: same
/// precision and major number, and a minor number not above the library's. Errors: `_ABI`.
///
/// After `TRUEAXIS_ERROR_ABI` call only `trueaxis_abi_version`, `trueaxis_result_text`, and, to continue uncorrected,
/// `trueaxis_loop_bypass`, `trueaxis_start` and `trueaxis_step`, which refuse structures of another size. Real-time
/// safe.
trueaxis_result_t trueaxis_check_abi(uint32_t header_version);

/// Returns the text of a result: a constant string for any number, empty in a build without the part `text`. Real-time
/// safe.
const char *trueaxis_result_text(trueaxis_result_t result);

/// Checks a whole table file and describes its contents.
///
/// `file`: of any alignment. Not real-time; about 12 KiB of stack. Errors: `_TABLES` (see `error->code`).
trueaxis_result_t trueaxis_tables_info(const uint8_t *file,
                                       size_t length,
                                       struct trueaxis_tables_info_t *info,
                                       struct trueaxis_error_t *error);

/// Starts an empty path.
///
/// `memory`: 8-byte aligned, `TRUEAXIS_SPAN_BYTES` per span; the path uses it as long as it exists. `first_span`:
/// number of the first span, 0 for a path that is complete. A host with a long program slides a window over it: each
/// window is another path that continues the numbering, so that the search finds its last foot again.
///
/// Segments are numbered from 0. Functions that change a path are not real-time (up to 8 KiB of stack) and must not run
/// while a step uses it: fill another path and pass that. Errors: `_ARGUMENT` (memory overlaps path).
trueaxis_result_t trueaxis_path_start(struct trueaxis_path_t *path,
                                      size_t path_size,
                                      void *memory,
                                      size_t memory_size,
                                      uint32_t first_span);

/// Starts an empty path of a tool in workpiece coordinates. Like `trueaxis_path_start`, but each span also stores
/// directions and takes `TRUEAXIS_TOOL_SPAN_BYTES`.
trueaxis_result_t trueaxis_path_start_tool(struct trueaxis_path_t *path,
                                           size_t path_size,
                                           void *memory,
                                           size_t memory_size,
                                           uint32_t first_span);

/// Sets the normal of the machining plane for the segments that follow, three numbers; initially 0, 0, 1 (G17). The
/// signs of the contour error's components depend on it. Errors: `_ARGUMENT` (not finite, shorter than 1e-6).
trueaxis_result_t trueaxis_path_plane(struct trueaxis_path_t *path, const double *normal);

/// Sets the positions of A, B, C (three numbers each, degrees) at start and end of the next segment of a tool path,
/// linear in its parameter; the segments after it keep the end position. Initially all are zero. Errors: `_ARGUMENT`
/// (not finite; not the path of a tool).
trueaxis_result_t trueaxis_path_axes(struct trueaxis_path_t *path, const double *start, const double *end);

/// Sets the directions of the tool at start and end of the next segment, in workpiece coordinates (vectors of any
/// length). The tool turns along the great circle from `start` to `end`; the segments after it keep the end direction.
/// Errors: `_ARGUMENT` (not finite, zero or opposite directions; not the path of a tool).
trueaxis_result_t trueaxis_path_directions(struct trueaxis_path_t *path, const double *start, const double *end);

/// Closes the path, so that its first span follows the last one until another segment is appended. Errors: `_PATH`
/// (ends more than 0.02 mm apart, or no segment).
trueaxis_result_t trueaxis_path_close(struct trueaxis_path_t *path);

/// Removes all segments. Memory, plane, directions and the number of the first span are unchanged.
trueaxis_result_t trueaxis_path_clear(struct trueaxis_path_t *path);

/// Reads the number of segments and of spans; either pointer may be `NULL`. Real-time safe.
trueaxis_result_t trueaxis_path_count(const struct trueaxis_path_t *path, uint32_t *segments, uint32_t *spans);

/// Computes the reference for parameter `u` of a segment (numbered from 0); if `u` is beyond the segment, its end.
/// Real-time safe. Errors: `_ARGUMENT` (no such segment, `u` not finite).
trueaxis_result_t trueaxis_path_reference(const struct trueaxis_path_t *path,
                                          uint32_t segment,
                                          double u,
                                          struct trueaxis_reference_t *reference);

/// Appends a straight line, mm: u = 0 to 1, proportional to length.
///
/// `start`, `end`: X, Y, Z. Errors: `_MEMORY`, `_PATH` (shorter than 1e-9 mm, not finite; as for every segment: start
/// more than 0.02 mm from the end of the previous segment).
trueaxis_result_t trueaxis_path_line(struct trueaxis_path_t *path,
                                     const double *start,
                                     const double *end,
                                     struct trueaxis_error_t *error);

/// Appends a circular arc about `normal` (right-hand rule), or a helix if start and end differ along it, mm: u = 0 to
/// 1, proportional to the angle. A start and end at the same angle define a full circle.
///
/// `center`: any point on the axis. `normal`: of any length. `turns`: full turns in addition to the first arc. Errors:
/// `_MEMORY`, `_PATH` (also: radii that differ by more than 0.02 mm).
trueaxis_result_t trueaxis_path_arc(struct trueaxis_path_t *path,
                                    const double *start,
                                    const double *end,
                                    const double *center,
                                    const double *normal,
                                    uint32_t turns,
                                    struct trueaxis_error_t *error);

/// Appends a spline (NURBS), mm: u from `knots[degree]` to `knots[point_count]`.
///
/// `degree`: 1 to 5. `knots`: `point_count + degree + 1` ascending numbers. `points`: X, Y, Z of each control point.
/// `weights`: `point_count` positive numbers, or `NULL` if all are 1. Errors: `_MEMORY`, `_PATH` (`error->index`: the
/// element).
trueaxis_result_t trueaxis_path_nurbs(struct trueaxis_path_t *path,
                                      uint32_t degree,
                                      const double *knots,
                                      const double *points,
                                      const double *weights,
                                      size_t point_count,
                                      struct trueaxis_error_t *error);

/// Appends a rotation of the tool about its stationary tip; u = 0 to 1. Only in a tool path; set the directions first
/// with `trueaxis_path_axes` or `trueaxis_path_directions`. Errors: `_MEMORY`, `_PATH`, `_ARGUMENT` (not the path of a
/// tool).
trueaxis_result_t trueaxis_path_turning(struct trueaxis_path_t *path,
                                        const double *point,
                                        struct trueaxis_error_t *error);

/// Starts an empty window.
///
/// `plane`: normal of the machining plane, three numbers; `NULL`: 0, 0, 1 (G17). `spacing_mm`: distance between two
/// points at slow feeds, 0.001 to 1 mm, usually 0.005 mm. The window must be longer than the tool's lag. Its length is
/// the larger of `TRUEAXIS_COMMAND_WINDOW_SPANS` spacings and the distance travelled in that many cycles. If the lag
/// exceeds it, `record.tip.flags` lacks `TRUEAXIS_CONTOUR_BRACKETED`.
///
/// Not real-time; about 75 KiB of stack, 43 KiB in single precision. Errors: `_ARGUMENT`.
trueaxis_result_t trueaxis_command_window_start(struct trueaxis_command_window_t *window,
                                                size_t window_size,
                                                const double *plane,
                                                double spacing_mm);

/// Discards all commands, for example after homing. Real-time safe.
trueaxis_result_t trueaxis_command_window_restart(struct trueaxis_command_window_t *window);

/// Builds the kinematics of the machine in a table file: X, Y, Z and up to two rotary axes.
///
/// Arguments as for `trueaxis_loop_build`. Not real-time. Errors: `_TABLES`, `_CONFIG` (the chain is not supported).
trueaxis_result_t trueaxis_kinematics_build(struct trueaxis_kinematics_t *kinematics,
                                            size_t kinematics_size,
                                            const uint8_t *file,
                                            size_t length,
                                            struct trueaxis_error_t *error);

/// Sets the tool: position of its tip relative to the last tool-side frame with all axes at zero, three numbers, mm.
/// Call it between two cycles; real-time safe. Errors: `_ARGUMENT` (not finite).
trueaxis_result_t trueaxis_kinematics_set_tool(struct trueaxis_kinematics_t *kinematics, const double *tool_mm);

/// Computes the tool from the positions of the axes.
///
/// `axes`: as many numbers as the machine has axes, in the step's order, mm and degrees. Real-time safe. Errors:
/// `_ARGUMENT` (not finite).
trueaxis_result_t trueaxis_kinematics_forward(const struct trueaxis_kinematics_t *kinematics,
                                              const double *axes,
                                              struct trueaxis_tool_t *tool);

/// Starts tracking at the machine's present pose.
///
/// `axes`: as for `trueaxis_kinematics_forward`. `max_step_deg`: largest step of a rotary axis in one cycle, degrees,
/// above 0 and at most 360. Not real-time. Errors: `_POSE`, `_ARGUMENT` (not finite, step out of range).
trueaxis_result_t trueaxis_branch_tracker_start(struct trueaxis_branch_tracker_t *tracker,
                                                size_t tracker_size,
                                                const struct trueaxis_kinematics_t *kinematics,
                                                const double *axes,
                                                double max_step_deg,
                                                struct trueaxis_error_t *error);

/// Reads the angle between the requested tool direction and that of the last positions computed, degrees: at most the
/// machine's `singular_cone_deg`, and 0 outside that cone except on the way out. Real-time safe.
trueaxis_result_t trueaxis_branch_tracker_direction_error(const struct trueaxis_branch_tracker_t *tracker,
                                                          trueaxis_real_t *error_deg);

/// Computes the axis positions for a tool and writes them to `input->command` for the next `trueaxis_step`, on the
/// branch that `tracker` follows.
///
/// `input->elapsed_ns` must be set. For a tool that has no such positions the fault is written to `input->refusal`: the
/// step then holds the output and reports the fault, and a reset near the held pose releases it. Within the machine's
/// `singular_cone_deg` of the singular pose the axis next to the workpiece stays still or turns by at most the
/// tracker's `max_step_deg` per cycle; the tip remains exact, and `trueaxis_branch_tracker_direction_error` returns the
/// remaining error of the direction. Call it once per cycle, for homed axes.
///
/// Real-time safe. Errors: `_AXES`, `_STATE` (also: a bypass, which has no kinematics), `_MACHINE`.
trueaxis_result_t trueaxis_rtcp(const struct trueaxis_loop_t *loop,
                                const struct trueaxis_state_t *state,
                                const struct trueaxis_tool_t *tool,
                                struct trueaxis_branch_tracker_t *tracker,
                                const struct trueaxis_kinematics_t *kinematics,
                                struct trueaxis_input_t *input);

/// Builds the gauge of a table file (`[roundness]` of its machine), with 1024 or 512 points per revolution.
///
/// Arguments as for `trueaxis_loop_build`. Not real-time; about 117 KiB of stack, 65 KiB in single precision. Errors:
/// `_TABLES`, `_CONFIG` (also the period), `_GAUGE`.
trueaxis_result_t trueaxis_gauge_build(struct trueaxis_gauge_t *gauge,
                                       size_t gauge_size,
                                       const uint8_t *file,
                                       size_t length,
                                       uint32_t period_ns,
                                       struct trueaxis_error_t *error);

/// Starts a new state: nothing is fed in before a whole revolution has been sampled, and the wheel is that of the file.
///
/// `state_size`: size of `trueaxis_gauge_state_t`, or for 512 points of `trueaxis_gauge_state_512_t`. Not real-time;
/// about 65 KiB of stack, 33 KiB in single precision.
trueaxis_result_t trueaxis_gauge_restart(const struct trueaxis_gauge_t *gauge,
                                         struct trueaxis_gauge_state_t *gauge_state,
                                         size_t state_size);

/// Sets the radius of the wheel, mm (wear, dressing), from the next evaluated revolution on.
///
/// Call it between two cycles. Errors: `_CONFIG` (the gauge has no following arm, or the linkage cannot close).
trueaxis_result_t trueaxis_gauge_set_wheel(const struct trueaxis_gauge_t *gauge,
                                           struct trueaxis_gauge_state_t *gauge_state,
                                           double wheel_mm,
                                           struct trueaxis_error_t *error);

/// Builds a loop from a compiled table file of 3 to 6 axes.
///
/// `file`, `length`: bytes of the `.tcomp`; the loop does not use them afterwards, since the nodes of grids are copied
/// into `memory`. `machine_id`: the machine that the file must be for, 0: any. `period_ns`: 1,000 to 100,000,000.
/// `memory`: at least `trueaxis_tables_info_t.memory_bytes`, 8-byte aligned; it must outlive the loop and its copies,
/// unchanged.
///
/// To exchange tables in motion, build a second loop in other memory and pass it to `trueaxis_step`; the limiter makes
/// the change smooth. Not real-time; 26 to 38 KiB of stack. After a refusal the loop is unchanged, but `memory` may
/// have been written: do not step a loop that was built in the same memory.
///
/// Errors: `_TABLES`, `_MACHINE`, `_CONFIG` (also the period), `_MEMORY`, `_ARGUMENT` (memory overlaps file or loop).
trueaxis_result_t trueaxis_loop_build(struct trueaxis_loop_t *loop,
                                      size_t loop_size,
                                      const uint8_t *file,
                                      size_t length,
                                      uint32_t machine_id,
                                      uint32_t period_ns,
                                      void *memory,
                                      size_t memory_size,
                                      struct trueaxis_error_t *error);

/// Builds a loop that passes every command uncorrected and reports the reason in every record, for operation without
/// tables.
///
/// `axes`: 3 to 6; 3 in a library for three axes only. `reason`: `TRUEAXIS_FAULT_PERIOD_MISMATCH`, `_TABLES_REFUSED`,
/// `_CAPACITY_TOO_SMALL` or `_ABI_MISMATCH`. `period_ns`: 1,000 to 100,000,000. After an invalid command the loop holds
/// the last valid one (before the first: the position read), and requests a stop until the next valid one.
///
/// Real-time safe. Errors: `_AXES`, `_ARGUMENT` (reason, period).
trueaxis_result_t trueaxis_loop_bypass(struct trueaxis_loop_t *loop,
                                       size_t loop_size,
                                       uint32_t axes,
                                       uint8_t reason,
                                       uint32_t period_ns);

/// Starts a new state for a loop, if the host's period is that of the loop within 0.1 %.
///
/// Real-time safe. Errors: `_PERIOD`.
trueaxis_result_t trueaxis_start(const struct trueaxis_loop_t *loop,
                                 struct trueaxis_state_t *state,
                                 size_t state_size,
                                 uint32_t period_ns);

/// Converts a 64-bit time since the last cycle to `elapsed_ns`.
///
/// A time that does not fit, or that is negative because a clock was set back, becomes `UINT32_MAX`. That is late at
/// any period: the correction freezes for that cycle. Real-time safe.
uint32_t trueaxis_elapsed_ns(int64_t host_ns);

/// Executes one servo cycle: computes drive positions, feedback for the host, and contour error.
///
/// `measure`: the path to measure against; `NULL`: none. `gauge`: a gauge of three probes to run in this cycle; `NULL`:
/// none. Every combination of both is allowed. The first cycle returns the command; from then on
/// `drive = command + correction`. The infeed of a gauge is added to the correction of its axis, before the limiter. A
/// bypass measures against no path, and its gauge measures but feeds nothing in. Between two cycles another loop with
/// the same number of axes may be passed.
///
/// Until either a valid command has come or every axis has been read (without an alarm), the step has no position to
/// hold: the function returns `TRUEAXIS_ERROR_NO_OUTPUT` and does not write `output->drive`. Once every axis has been
/// read, the step holds that position and accepts a reset near it.
///
/// Real-time safe. Errors: `_AXES`, `_STATE`, `_MACHINE` (kinematics), `_ARGUMENT` (kind, refusal), `_NO_OUTPUT`.
/// Faults of the machine are in `output->record.fault`.
trueaxis_result_t trueaxis_step(const struct trueaxis_loop_t *loop,
                                struct trueaxis_state_t *state,
                                const struct trueaxis_input_t *input,
                                struct trueaxis_measure_t *measure,
                                struct trueaxis_gauge_ride_t *gauge,
                                struct trueaxis_output_t *output);

/// Sets the temperature of an axis. The growth that the table file gives for it acts from the next cycle on, through
/// the limiter.
///
/// `axis`: index in the step's order (0 = X). `kelvin`: temperature above the file's reference. Call it between two
/// cycles. No effect in a bypass. Real-time safe. Errors: `_AXES`, `_STATE`, `_ARGUMENT` (no such axis; growth of more
/// than 10 mm or 1e-3 of the length).
trueaxis_result_t trueaxis_set_thermal(const struct trueaxis_loop_t *loop,
                                       struct trueaxis_state_t *state,
                                       uint32_t axis,
                                       double kelvin);

/// Freezes the friction of all axes where it is (`frozen` not 0), or lets it adapt again. Call it between two cycles. No
/// effect in a bypass and on axes without `adapt`. Real-time safe. Errors: `_AXES`, `_STATE`.
trueaxis_result_t trueaxis_friction_freeze(const struct trueaxis_loop_t *loop,
                                           struct trueaxis_state_t *state,
                                           uint8_t frozen);

/// Returns the friction of all axes to the identified figures, through the limiter, and forgets faults 12 and 13. Call it
/// between two cycles. No effect in a bypass. Real-time safe. Errors: `_AXES`, `_STATE`.
trueaxis_result_t trueaxis_friction_reset(const struct trueaxis_loop_t *loop,
                                          struct trueaxis_state_t *state);

/// Reads the factors in use on the identified friction of an axis: of Coulomb friction, and of pre-sliding.
///
/// `axis`: index in the step's order (0 = X). `coulomb`, `presliding`: one number each; 1 in a bypass. Real-time safe.
/// Errors: `_AXES`, `_STATE`, `_ARGUMENT` (no such axis, or one without `adapt`).
trueaxis_result_t trueaxis_friction_factors(const struct trueaxis_loop_t *loop,
                                            struct trueaxis_state_t *state,
                                            uint32_t axis,
                                            trueaxis_real_t *coulomb,
                                            trueaxis_real_t *presliding);

/// Starts an encoder: position = `offset` + counts · `resolution`, mm (rotary: degrees). The position continues where
/// the counter wraps.
///
/// `resolution`: size of one count, at most 1; negative if the counts fall while the position rises. `span`: number of
/// counts after which the counter restarts at 0, 4 to 4294967296: 65536 for 16 bits, 4294967296 for 32 bits, or the
/// counts per turn. `nearest`: the first reading is interpreted as the count nearest to this one; with 0, counters of
/// 16 and 32 bits start as signed numbers. Start the encoder again after counts were lost. Real-time safe. Errors:
/// `_ARGUMENT` (resolution or span out of range, or an offset that is not a usable position).
trueaxis_result_t trueaxis_encoder_start(struct trueaxis_encoder_t *encoder,
                                         size_t encoder_size,
                                         double offset,
                                         double resolution,
                                         uint64_t span,
                                         int64_t nearest);

/// Position of the encoder at a reading of its counter, for `trueaxis_input_t.feedback`.
///
/// `counts`: the reading; if the span is a power of two, higher bits are ignored. A change of more than a quarter of
/// the span since the last reading is ambiguous: `position` is then NaN (in single precision `INT32_MIN`), which the
/// step treats as a dropout, and the counter waits for a reading within a quarter of the span of the last one. Do not
/// call this function for a missing reading; until the next reading the axis may move by a quarter of the span.
/// Real-time safe.
trueaxis_result_t trueaxis_encoder_position(struct trueaxis_encoder_t *encoder,
                                            uint32_t counts,
                                            trueaxis_position_t *position);

/// Starts computing the id of a program.
///
/// `length_mm`: length of its path. Not real-time. Errors: `_ARGUMENT` (not finite, negative).
trueaxis_result_t trueaxis_program_start(struct trueaxis_program_t *program, size_t program_size, double length_mm);

/// Adds the next point of the path. Points are those at every whole mm of path length from 0, then the end.
///
/// `coordinates`: X, Y, Z in mm, A, B, C in degrees as the program commands them, 0 for an axis that the program does
/// not have. Not real-time. Errors: `_ARGUMENT` (not finite).
trueaxis_result_t trueaxis_program_point(struct trueaxis_program_t *program, const double *coordinates);

/// Writes the id of the program whose points were added. Another program can be started afterwards. Not real-time.
trueaxis_result_t trueaxis_program_id(struct trueaxis_program_t *program, uint32_t *id);

/// Builds a learned correction from its file after checking the whole file, its machine and its program.
///
/// `file`, `length`: bytes of the file, read in place: they must outlive the correction and its copies, unchanged.
/// `machine_id`: the machine that the file must be for (`trueaxis_tables_info_t.machine_id`), 0: any. `program_id`,
/// `length_mm`: the program that is about to run; path lengths that differ by up to 1 µm count as equal. Not real-time.
///
/// Errors: `_LEARNED` (see `error->code`), `_MACHINE`, `_ARGUMENT` (length not finite).
trueaxis_result_t trueaxis_learned_build(struct trueaxis_learned_t *learned,
                                         size_t learned_size,
                                         const uint8_t *file,
                                         size_t length,
                                         uint32_t machine_id,
                                         uint32_t program_id,
                                         double length_mm,
                                         struct trueaxis_error_t *error);

/// Computes the correction at a path length, for `trueaxis_input_t.learned`: linear between nodes; 0 beyond the ends,
/// and for a length that is NaN.
///
/// `correction`: three positions. Real-time safe: bounded time.
trueaxis_result_t trueaxis_learned_at(const struct trueaxis_learned_t *learned,
                                      double length_mm,
                                      trueaxis_position_t *correction);

/// Builds thermal growth from a `.ttherm` file after checking the whole file and its machine.
///
/// `file`, `length`: bytes of the file, read in place: they must outlive the growth and its copies, unchanged.
/// `machine_id`: the machine that the file must be for (`trueaxis_tables_info_t.machine_id`), 0: any. `sensors`:
/// receives the number of sensors; may be `NULL`. Not real-time.
///
/// Errors: `_THERMAL` (see `error->code`), `_MACHINE`.
trueaxis_result_t trueaxis_thermal_build(struct trueaxis_thermal_t *thermal,
                                         size_t thermal_size,
                                         const uint8_t *file,
                                         size_t length,
                                         uint32_t machine_id,
                                         uint32_t *sensors,
                                         struct trueaxis_error_t *error);

/// Starts the task: in equilibrium with the first readings, as after a long standstill of the spindle. Not real-time.
trueaxis_result_t trueaxis_thermal_start(struct trueaxis_thermal_state_t *task, size_t task_size);

/// Computes the growth from readings. Call it about once a second.
///
/// Readings are assumed to be linear in time since the previous update. Bounded time, about 16 exponentials: real-time
/// safe, but preferably called from a slower task. Errors: `_ARGUMENT` (count).
trueaxis_result_t trueaxis_thermal_update(const struct trueaxis_thermal_t *thermal,
                                          struct trueaxis_thermal_state_t *task,
                                          const struct trueaxis_thermal_readings_t *readings,
                                          struct trueaxis_growth_t *growth);

/// Accepts the next reading of a sensor (numbered from 0) that has jumped, for example after it was replaced. Real-time
/// safe. Errors: `_ARGUMENT` (no such sensor).
trueaxis_result_t trueaxis_thermal_believe(struct trueaxis_thermal_state_t *task, uint32_t sensor);

/// Sets the growth of all axes that it names. The growth acts from the next cycle on, through the limiter, and replaces
/// the one set by `trueaxis_set_thermal`: use only one of the two functions. Call it between two cycles. No effect in a
/// bypass. Axes that the step does not have are ignored. Real-time safe. Errors: `_AXES`, `_STATE`, `_ARGUMENT` (growth
/// of more than 10 mm or 1e-3 of the length).
trueaxis_result_t trueaxis_set_growth(const struct trueaxis_loop_t *loop,
                                      struct trueaxis_state_t *state,
                                      const struct trueaxis_growth_t *growth);

/// Writes the telemetry frame of a record: postcard in COBS, terminated by 0; the same bytes in every build and
/// precision.
///
/// `output`: output of a step. `written`: number of bytes written. Not real-time. Errors: `_BUFFER`, `_ARGUMENT`
/// (`output` does not come from a step).
trueaxis_result_t trueaxis_frame_encode(const struct trueaxis_output_t *output,
                                        uint8_t *buffer,
                                        size_t size,
                                        size_t *written);

/// Reads the results of the latest revolution evaluated.
///
/// Call it between two cycles; real-time safe. Errors: `_NOT_YET`.
trueaxis_result_t trueaxis_gauge_latest(const struct trueaxis_gauge_t *gauge,
                                        struct trueaxis_gauge_state_t *gauge_state,
                                        struct trueaxis_evaluation_t *evaluation);

/// Reads the amplitudes of cos kθ and sin kθ in the latest profile, two numbers, µm; 0 outside the file's band and for
/// a suppressed harmonic.
///
/// `harmonic`: k. Call it between two cycles; real-time safe. Errors: `_NOT_YET`, `_ARGUMENT` (k above 127).
trueaxis_result_t trueaxis_gauge_harmonic(const struct trueaxis_gauge_t *gauge,
                                          struct trueaxis_gauge_state_t *gauge_state,
                                          uint32_t harmonic,
                                          trueaxis_real_t *amplitudes_um);

/// Writes the telemetry frame of the latest revolution: postcard in COBS, terminated by 0.
///
/// `machine_id` is copied into the frame. `written`: number of bytes written. Not real-time; about 4 KiB of stack.
/// Errors: `_NOT_YET`, `_BUFFER`.
trueaxis_result_t trueaxis_gauge_frame_encode(const struct trueaxis_gauge_t *gauge,
                                              struct trueaxis_gauge_state_t *gauge_state,
                                              uint32_t machine_id,
                                              uint8_t *buffer,
                                              size_t size,
                                              size_t *written);

/// Computes the modelled error at a position, actual − ideal: first X, Y, Z of the tip in machine axes (mm), then the
/// errors of the rotary axes themselves (degrees; 0 in a volumetric model).
///
/// `position`, `error`: as many numbers as the loop has axes. `negative`: bit 0 = X, …: the axis travels in its
/// negative direction. `kelvin`: temperatures of the axes above the file's reference, or `NULL`. Outside a table the
/// value at its edge applies. Bounded time. Errors: `_STATE` (a bypass), `_ARGUMENT` (not finite; growth as for
/// `trueaxis_set_thermal`).
trueaxis_result_t trueaxis_error_at(const struct trueaxis_loop_t *loop,
                                    const trueaxis_position_t *position,
                                    uint8_t negative,
                                    const double *kelvin,
                                    trueaxis_real_t *error);

/// Computes the correction of a command, mm (degrees): the value to which the step settles at standstill if no limit
/// acts. The inverse is exact; the result is not limited.
///
/// Arguments as for `trueaxis_error_at`. Errors: `_STATE`, `_ARGUMENT` (as for `trueaxis_error_at`; also: outside the
/// travel).
trueaxis_result_t trueaxis_correction_at(const struct trueaxis_loop_t *loop,
                                         const trueaxis_position_t *command,
                                         uint8_t negative,
                                         const double *kelvin,
                                         trueaxis_real_t *correction);

/// Finds the foot nearest to a point (three numbers) on the whole path. `lag` is 0. Not real-time: the time grows with
/// the path. Errors: `_ARGUMENT` (not finite, or no segment).
trueaxis_result_t trueaxis_nearest_foot(const struct trueaxis_path_t *path,
                                        const trueaxis_position_t *point,
                                        struct trueaxis_contour_t *contour);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRUEAXIS_H */
