/*
 * trueaxis: geometric error compensation and true contour error inside the servo step of an open CNC controller.
 *
 * Generated from the Rust source; do not edit. C99, usable from C++.
 *
 * Rules for all functions
 *   - The answer is a trueaxis_status_t: 0 (TRUEAXIS_OK) or a TRUEAXIS_ERROR_..., never negative. When a function
 *     refuses, everything that it would have written stays as it was (but trueaxis_error_t, which then says why).
 *   - No function panics, allocates, prints, locks or calls the operating system. Of the step itself the linker proves
 *     it; the functions that set up have been tried with damaged files of every kind.
 *   - Objects (trueaxis_loop_t, trueaxis_state_t, ...) are storage of fixed size that the caller provides, best zeroed
 *     before; they hold no resources, so there is nothing to free. Memory that is lent to an object must outlive it.
 *   - Structures that begin with a member `size` want it set by the caller once: `input.size = sizeof input;`.
 *   - Pointers must be NULL or point to what their type says; NULL is refused unless the function allows it. Memory must
 *     not overlap between arguments.
 *   - Two threads may use the same loop, path and gauge at the same time (they are only read), never the same state.
 *   - "Real-time safe" functions run in bounded time and may be called in the servo interrupt; the others belong to the
 *     start of the program or to a background task. All of them are reentrant.
 *
 * Units: mm, for rotary axes degrees; time ns; signs as in ISO 841 and ISO 230-1 (error = actual - ideal).
 *
 * Precision: a library for cores without double precision is built with `--features single`; define TRUEAXIS_SINGLE
 * before including this header then, and only then.
 */

#ifndef TRUEAXIS_H
#define TRUEAXIS_H

#include <stddef.h>
#include <stdint.h>

/* Version of this header: check it against the library's with trueaxis_check_abi(TRUEAXIS_ABI_VERSION). */
#ifndef TRUEAXIS_ABI_MAJOR
#define TRUEAXIS_ABI_MAJOR 1
#endif
#ifndef TRUEAXIS_ABI_MINOR
#define TRUEAXIS_ABI_MINOR 1
#endif
#ifdef TRUEAXIS_SINGLE
#define TRUEAXIS_ABI_VERSION (UINT32_C(0x80000000) | (uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#else
#define TRUEAXIS_ABI_VERSION ((uint32_t)TRUEAXIS_ABI_MAJOR << 16 | TRUEAXIS_ABI_MINOR)
#endif

/**
 * Words of a `trueaxis_path_t`.
 */
#define TRUEAXIS_PATH_WORDS 12

#if !defined(TRUEAXIS_SINGLE)
/**
 * Bytes that a piece of a path takes in the memory lent for it. A line takes a piece every 16 mm, an arc one every 30°
 * or less, a spline some for every span of its knots.
 */
#define TRUEAXIS_SPAN_BYTES 296
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Bytes that a piece of a path takes in the memory lent for it. A line takes a piece every 16 mm, an arc one every 30°
 * or less, a spline some for every span of its knots.
 */
#define TRUEAXIS_SPAN_BYTES 168
#endif

#if !defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_loop_t`.
 */
#define TRUEAXIS_LOOP_WORDS 368
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_loop_t`.
 */
#define TRUEAXIS_LOOP_WORDS 240
#endif

#if !defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_state_t`.
 */
#define TRUEAXIS_STATE_WORDS 104
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_state_t`.
 */
#define TRUEAXIS_STATE_WORDS 64
#endif

/**
 * Most axes of a machine.
 */
#define TRUEAXIS_AXES_MAX 6

/**
 * The foot is a minimum of the distance, bracketed by − and +.
 */
#define TRUEAXIS_CONTOUR_BRACKETED 1

/**
 * The foot is an end of an open path.
 */
#define TRUEAXIS_CONTOUR_AT_END 2

/**
 * The foot is a corner between two pieces.
 */
#define TRUEAXIS_CONTOUR_AT_CORNER 4

/**
 * A second minimum may be near.
 */
#define TRUEAXIS_CONTOUR_SECOND_MINIMUM 8

/**
 * No foot was known from the last cycle; the way around the reference is being looked over.
 */
#define TRUEAXIS_CONTOUR_COLD 16

/**
 * No path, or no belief in the readings: nothing was measured, all other members are 0.
 */
#define TRUEAXIS_CONTOUR_NOT_FOUND 32

/**
 * The reference lay outside its piece and was taken at the nearer end; infinite or not a number, nothing was measured.
 */
#define TRUEAXIS_CONTOUR_REFERENCE 64

/**
 * Bit of `status`: homed, enabled and believed, corrections are followed.
 */
#define TRUEAXIS_STATUS_ACTIVE 1

/**
 * Bit of `status`: the correction is frozen because a reading is not believed.
 */
#define TRUEAXIS_STATUS_FROZEN 2

/**
 * Bit of `status`: the output is held and the host must stop the machine.
 */
#define TRUEAXIS_STATUS_STOP_REQUEST 4

/**
 * Bit of `status`: the contour error of this cycle was measured.
 */
#define TRUEAXIS_STATUS_CONTOUR 8

/**
 * Bit of `status`: there is no output, and the step answers `TRUEAXIS_ERROR_NO_OUTPUT`.
 */
#define TRUEAXIS_STATUS_NO_OUTPUT 16

/**
 * Nothing is wrong.
 */
#define TRUEAXIS_FAULT_NONE 0

/**
 * An encoder gave no finite reading. From here to 15: the correction freezes and the command passes.
 */
#define TRUEAXIS_FAULT_FEEDBACK_NOT_FINITE 1

/**
 * A reading changed more in a cycle than the axis can move.
 */
#define TRUEAXIS_FAULT_FEEDBACK_JUMP 2

/**
 * A reading stands still though the axis was commanded to move.
 */
#define TRUEAXIS_FAULT_ENCODER_STUCK 3

/**
 * The encoder interface reports an alarm (dropout).
 */
#define TRUEAXIS_FAULT_ENCODER_ALARM 4

/**
 * The cycle came late: its period is off by more than a quarter.
 */
#define TRUEAXIS_FAULT_LATE_CYCLE 5

/**
 * A command is infinite or not a number. From here to 31: the output holds and a stop is requested.
 */
#define TRUEAXIS_FAULT_COMMAND_NOT_FINITE 16

/**
 * A command lies outside the declared travel.
 */
#define TRUEAXIS_FAULT_COMMAND_OUT_OF_TRAVEL 17

/**
 * A command changed more in a cycle than the axis can move.
 */
#define TRUEAXIS_FAULT_COMMAND_JUMP 18

/**
 * Command plus correction leaves the range of the joint.
 */
#define TRUEAXIS_FAULT_JOINT_RANGE 19

/**
 * No pose of the machine brings the tool to the commanded tip and direction.
 */
#define TRUEAXIS_FAULT_TOOL_UNREACHABLE 20

/**
 * The commanded direction is too near to the singular one.
 */
#define TRUEAXIS_FAULT_SINGULAR_POSE 21

/**
 * The commanded direction asks the rotary axes to go over to their other solution faster than they can.
 */
#define TRUEAXIS_FAULT_BRANCH_CHANGE 22

/**
 * The host's servo period is not the configured one. From here on: refused at start, the command passes uncorrected
 * (`trueaxis_loop_bypass`).
 */
#define TRUEAXIS_FAULT_PERIOD_MISMATCH 32

/**
 * The table file is damaged, or of another format, version or machine.
 */
#define TRUEAXIS_FAULT_TABLES_REFUSED 33

/**
 * The tables need more memory than there is.
 */
#define TRUEAXIS_FAULT_CAPACITY_TOO_SMALL 34

/**
 * Host and library were built for different versions of the interface.
 */
#define TRUEAXIS_FAULT_ABI_MISMATCH 35

/**
 * A buffer of this size holds the frame of any record.
 */
#define TRUEAXIS_FRAME_BYTES 256

/**
 * Pieces of the window in a `trueaxis_follow_t`.
 */
#define TRUEAXIS_FOLLOW_PIECES 64

#if !defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_follow_t`.
 */
#define TRUEAXIS_FOLLOW_WORDS 4864
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_follow_t`.
 */
#define TRUEAXIS_FOLLOW_WORDS 2784
#endif

#if !defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_gauge_t`.
 */
#define TRUEAXIS_GAUGE_WORDS 6400
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_gauge_t`.
 */
#define TRUEAXIS_GAUGE_WORDS 3200
#endif

#if !defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_gauge_state_t`.
 */
#define TRUEAXIS_GAUGE_STATE_WORDS 18048
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_gauge_state_t`.
 */
#define TRUEAXIS_GAUGE_STATE_WORDS 9088
#endif

#if !defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_gauge_state_512_t`.
 */
#define TRUEAXIS_GAUGE_STATE_512_WORDS 9216
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Words of a `trueaxis_gauge_state_512_t`.
 */
#define TRUEAXIS_GAUGE_STATE_512_WORDS 4672
#endif

/**
 * No index pulse has been seen yet, or none that can be relied on.
 */
#define TRUEAXIS_GAUGE_NO_INDEX 1

/**
 * An index pulse did not come.
 */
#define TRUEAXIS_GAUGE_INDEX_MISSING (1 << 1)

/**
 * An index pulse came at another count than before.
 */
#define TRUEAXIS_GAUGE_INDEX_SHIFTED (1 << 2)

/**
 * The spindle's count changed by more than a quarter turn in a cycle.
 */
#define TRUEAXIS_GAUGE_SPINDLE_JUMP (1 << 3)

/**
 * A probe is outside its range, or gave no finite reading.
 */
#define TRUEAXIS_GAUGE_PROBE_RANGE (1 << 4)

/**
 * The arm's angle is outside ±90°, or contradicts the linkage.
 */
#define TRUEAXIS_GAUGE_ARM (1 << 5)

/**
 * The part turned backwards by more than a point.
 */
#define TRUEAXIS_GAUGE_REVERSED (1 << 6)

/**
 * More than two points passed in a cycle.
 */
#define TRUEAXIS_GAUGE_TOO_FAST (1 << 7)

/**
 * The spindle stood.
 */
#define TRUEAXIS_GAUGE_STOPPED (1 << 8)

/**
 * The speed changed by more than a quarter within the revolution. From here on, the revolution counts all the same.
 */
#define TRUEAXIS_GAUGE_SPEED (1 << 9)

/**
 * Revolutions were skipped whole, because the work on one before was not finished.
 */
#define TRUEAXIS_GAUGE_SKIPPED (1 << 10)

/**
 * The infeed correction was not updated.
 */
#define TRUEAXIS_GAUGE_INFEED_FROZEN (1 << 11)

/**
 * The infeed correction was limited over several revolutions and has been made smaller.
 */
#define TRUEAXIS_GAUGE_INFEED_REDUCED (1 << 12)

/**
 * A buffer of this size holds the frame of any revolution.
 */
#define TRUEAXIS_GAUGE_FRAME_BYTES 1280

/**
 * Answer of a function: `TRUEAXIS_OK` or one of `TRUEAXIS_ERROR_…`, never negative. `trueaxis_status_text` has words
 * for each.
 */
typedef int32_t trueaxis_status_t;

/**
 * Contents of a table file. The first `axes` places of the arrays count, in the order of the step; travel and limits of
 * a linear axis that the machine does not have are 0: it is passed as commanded.
 */
typedef struct trueaxis_tables_info_t {
    /**
     * `sizeof(trueaxis_tables_info_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * Number of axes of the step, 3 to 6.
     */
    uint32_t axes;
    /**
     * Letters of the axes, closed by a zero: X, Y, Z (always; a missing one has no table), then the rotary axes in
     * alphabetical order.
     */
    char letters[8];
    /**
     * Identity of the machine: CRC-32 of its name and chain.
     */
    uint32_t machine_id;
    /**
     * CRC-32 at the end of the file: the version of these tables.
     */
    uint32_t tables_crc;
    /**
     * Look-ups that the exact inverse takes in a cycle.
     */
    uint32_t inverse_passes;
    /**
     * Points of a revolution of the machine's gauge, 0 without a gauge.
     */
    uint32_t gauge_points;
    /**
     * Bytes of memory that `trueaxis_loop_build` needs beside `trueaxis_loop_t`.
     */
    uint64_t memory_bytes;
    /**
     * Lines of the axis' error table, 0 without one.
     */
    uint32_t rows[TRUEAXIS_AXES_MAX];
    /**
     * Declared travel, low end, mm (deg). A command outside is a fault.
     */
    double travel_low[TRUEAXIS_AXES_MAX];
    /**
     * Declared travel, high end, mm (deg).
     */
    double travel_high[TRUEAXIS_AXES_MAX];
    /**
     * Largest |correction|, mm (deg).
     */
    double correction_limit[TRUEAXIS_AXES_MAX];
    /**
     * Largest |rate of change of the correction|, mm/s (deg/s).
     */
    double slope_limit_per_s[TRUEAXIS_AXES_MAX];
    /**
     * Largest |acceleration of the correction|, mm/s² (deg/s²).
     */
    double acceleration_limit_per_s2[TRUEAXIS_AXES_MAX];
    /**
     * Name of the machine, UTF-8, closed by a zero.
     */
    char name[72];
    /**
     * Structural code of the machine (ISO 10791-6), closed by a zero.
     */
    char chain[56];
} trueaxis_tables_info_t;

/**
 * Why something was refused, ready to print.
 */
typedef struct trueaxis_error_t {
    /**
     * `sizeof(trueaxis_error_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * The status that the function returned.
     */
    trueaxis_status_t status;
    /**
     * Number of the table file's fault: 1 too short, 2 too long, 3 not a `.tcomp`, 4 other format version, 5 CRC-32
     * wrong, 6 settings and 7 table header cannot be decoded, 8 table or 9 payload too long, 10 machine id contradicts
     * the name, 11 contents make no sense (then `field`, `found` and `needed` tell which), 12 other machine. 0: not about
     * a table file.
     */
    uint32_t code;
    /**
     * Element of the setting that is wrong, from 0 (row of a table, knot of a spline); `UINT32_MAX` if it is no list.
     */
    uint32_t index;
    /**
     * What was found, in mm, degrees or seconds.
     */
    double found;
    /**
     * Letter of the axis at fault, 0 if it is none's.
     */
    char axis;
    /**
     * Name of the setting (of a segment: of the part) at fault; empty if it is none's.
     */
    char field[31];
    /**
     * What is needed instead; empty if nothing can be said.
     */
    char needed[128];
    /**
     * All of it in one line of UTF-8 without a line feed.
     */
    char text[256];
} trueaxis_error_t;

/**
 * A programmed path: lines, arcs and splines, converted into pieces in memory that the caller lends.
 */
typedef struct trueaxis_path_t {
    uint64_t words[TRUEAXIS_PATH_WORDS];
} trueaxis_path_t;

#if !defined(TRUEAXIS_SINGLE)
/**
 * Scalar of the arithmetic: `double`, with `TRUEAXIS_SINGLE` `float`.
 */
typedef double trueaxis_real_t;
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Scalar of the arithmetic: `double`, with `TRUEAXIS_SINGLE` `float`.
 */
typedef float trueaxis_real_t;
#endif

/**
 * A place on a path: a piece of it, and where in the piece. `trueaxis_path_reference` makes it from a segment and its
 * parameter.
 */
typedef struct trueaxis_reference_t {
    /**
     * Sequence number of the piece.
     */
    uint32_t span;
    /**
     * Parameter in the piece, 0 to 1.
     */
    trueaxis_real_t t;
} trueaxis_reference_t;

/**
 * The immutable half: tables, limits and settings of a machine, built once. May be copied and read from any thread.
 */
typedef struct trueaxis_loop_t {
    uint64_t words[TRUEAXIS_LOOP_WORDS];
} trueaxis_loop_t;

/**
 * The mutable half: what one cycle hands to the next. Belongs to the thread that steps it; a copy taken between two cycles
 * may be put back, as if the cycles since had not been.
 */
typedef struct trueaxis_state_t {
    uint64_t words[TRUEAXIS_STATE_WORDS];
} trueaxis_state_t;

#if !defined(TRUEAXIS_SINGLE)
/**
 * Position of an axis: mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` 32-bit integers of 1e-6 mm = 1 nm
 * (1e-6 degrees).
 */
typedef double trueaxis_position_t;
#endif

#if defined(TRUEAXIS_SINGLE)
/**
 * Position of an axis: mm (rotary: degrees) as `double`; with `TRUEAXIS_SINGLE` 32-bit integers of 1e-6 mm = 1 nm
 * (1e-6 degrees).
 */
typedef int32_t trueaxis_position_t;
#endif

/**
 * What the host hands over in a servo cycle. Axes stand in the order of `trueaxis_tables_info_t.letters`: X, Y, Z, then
 * the rotary axes of the machine in alphabetical order; places beyond the machine's axes are not looked at.
 */
typedef struct trueaxis_input_t {
    /**
     * `sizeof(trueaxis_input_t)`, set by the caller.
     */
    uint32_t size;
    /**
     * Time since the last cycle as the host measured or knows it, ns. Off by more than a quarter of the period, the
     * correction freezes for this cycle (`TRUEAXIS_FAULT_LATE_CYCLE`).
     */
    uint32_t elapsed_ns;
    /**
     * Commanded positions, uncorrected.
     */
    trueaxis_position_t command[TRUEAXIS_AXES_MAX];
    /**
     * Raw encoder positions. A reading that is not a number, beyond 1e9, or in single precision `INT32_MIN` or
     * `INT32_MAX`, is a dropout: convert counts with saturation. The same goes for commands, which are refused then.
     */
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /**
     * A bit for every axis whose encoder interface reports an alarm, bit 0 = X.
     */
    uint8_t encoder_alarm;
    /**
     * Not 0: all axes are homed, positions are machine positions.
     */
    uint8_t homed;
    /**
     * Not 0: compensation is wanted.
     */
    uint8_t enable;
    /**
     * Not 0: releases a latched stop request (on its rising edge, near the held position).
     */
    uint8_t reset;
    /**
     * Not looked at.
     */
    uint8_t reserved[4];
} trueaxis_input_t;

/**
 * Contour error in a cycle; lengths in mm.
 */
typedef struct trueaxis_contour_t {
    /**
     * Piece of the path on which the foot lies.
     */
    uint32_t span;
    /**
     * Evaluations of the path that the search took.
     */
    uint8_t evaluations;
    /**
     * `TRUEAXIS_CONTOUR_…` bits: how the foot was found.
     */
    uint8_t flags;
    /**
     * 0.
     */
    uint16_t reserved;
    /**
     * Parameter of the foot in the piece, 0 to 1.
     */
    trueaxis_real_t t;
    /**
     * Distance from the path: |actual − foot|, never negative.
     */
    trueaxis_real_t error;
    /**
     * Actual − foot along X, Y, Z.
     */
    trueaxis_real_t vector[3];
    /**
     * Component in the machining plane, positive to the left of the path.
     */
    trueaxis_real_t normal;
    /**
     * Component along the plane's normal.
     */
    trueaxis_real_t binormal;
    /**
     * Component along the path: 0 but at ends and corners.
     */
    trueaxis_real_t tangential;
    /**
     * Arc length from the foot to the reference, positive while the tool lags.
     */
    trueaxis_real_t lag;
    /**
     * What is left of the bracket around the foot, arc length.
     */
    trueaxis_real_t width;
} trueaxis_contour_t;

/**
 * The telemetry of a cycle. Positions in `trueaxis_position_t`, everything else in mm (rotary: degrees).
 */
typedef struct trueaxis_record_t {
    /**
     * Counts cycles from 0, wrapping.
     */
    uint32_t sequence;
    /**
     * Identity of the machine that the tables belong to; 0 in a bypass.
     */
    uint32_t machine_id;
    /**
     * CRC-32 of the table file in force; 0 in a bypass.
     */
    uint32_t tables_crc;
    /**
     * `TRUEAXIS_FAULT_…`: what went wrong, 0 if nothing.
     */
    uint8_t fault;
    /**
     * Place of the axis that the fault belongs to.
     */
    uint8_t fault_axis;
    /**
     * `TRUEAXIS_STATUS_…` bits.
     */
    uint8_t status;
    /**
     * A bit for every axis whose correction differs from the wanted one.
     */
    uint8_t limited;
    /**
     * A bit for every axis whose table holds its edge value.
     */
    uint8_t at_edge;
    /**
     * `TRUEAXIS_CONTOUR_…` bits of the orientation error: not found in all steps of this interface.
     */
    uint8_t orientation_flags;
    /**
     * 0.
     */
    uint8_t reserved[6];
    /**
     * Command that is in force: as it came, the held one during a stop.
     */
    trueaxis_position_t command[TRUEAXIS_AXES_MAX];
    /**
     * Raw feedback (last good one during a fault).
     */
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /**
     * Correction sent: `drive − command` before rounding to a position.
     */
    trueaxis_real_t correction[TRUEAXIS_AXES_MAX];
    /**
     * Contour error of the estimated tool tip.
     */
    struct trueaxis_contour_t tip;
    /**
     * Contour error of the plain encoder position.
     */
    struct trueaxis_contour_t encoder;
    /**
     * Orientation contour error, rad: 0 in all steps of this interface.
     */
    trueaxis_real_t orientation;
} trueaxis_record_t;

/**
 * What a servo cycle gives back.
 */
typedef struct trueaxis_output_t {
    /**
     * `sizeof(trueaxis_output_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * Number of axes that count in the arrays.
     */
    uint32_t axes;
    /**
     * Corrected positions for the drives. Not written where the step answers `TRUEAXIS_ERROR_NO_OUTPUT`.
     */
    trueaxis_position_t drive[TRUEAXIS_AXES_MAX];
    /**
     * Feedback for the host, without the correction: it sees no following error that is not there.
     */
    trueaxis_position_t feedback[TRUEAXIS_AXES_MAX];
    /**
     * The cycle's telemetry.
     */
    struct trueaxis_record_t record;
} trueaxis_output_t;

/**
 * A short window of the last commanded points: the path, for a host that knows no other. Belongs to the thread that
 * steps it.
 */
typedef struct trueaxis_follow_t {
    uint64_t words[TRUEAXIS_FOLLOW_WORDS];
} trueaxis_follow_t;

/**
 * The immutable half of a gauge: angles, multipliers, limits. May be copied and read from any thread.
 */
typedef struct trueaxis_gauge_t {
    uint64_t words[TRUEAXIS_GAUGE_WORDS];
} trueaxis_gauge_t;

/**
 * The mutable half of a gauge of 1024 points, and its results. Belongs to the thread that steps it. Large: a static.
 */
typedef struct trueaxis_gauge_state_t {
    uint64_t words[TRUEAXIS_GAUGE_STATE_WORDS];
} trueaxis_gauge_state_t;

/**
 * Error motion of the spindle in one direction, µm.
 */
typedef struct trueaxis_motion_t {
    /**
     * Synchronous, without the once-per-revolution part.
     */
    trueaxis_real_t synchronous_um;
    /**
     * Asynchronous; 0 over a single revolution.
     */
    trueaxis_real_t asynchronous_um;
    /**
     * Amplitude of cos θ: eccentricity and fundamental.
     */
    trueaxis_real_t cosine_um;
    /**
     * Amplitude of sin θ.
     */
    trueaxis_real_t sine_um;
    /**
     * Total.
     */
    trueaxis_real_t total_um;
} trueaxis_motion_t;

/**
 * What is known about the latest revolution, and how all of them fared.
 */
typedef struct trueaxis_evaluation_t {
    /**
     * `sizeof(trueaxis_evaluation_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * Counts whole revolutions that were sampled, from 1, wrapping.
     */
    uint32_t revolution;
    /**
     * Revolutions sampled whole so far.
     */
    uint32_t sampled;
    /**
     * Revolutions evaluated so far.
     */
    uint32_t evaluated;
    /**
     * Revolutions skipped whole so far.
     */
    uint32_t skipped;
    /**
     * Revolutions discarded whole so far.
     */
    uint32_t discarded;
    /**
     * `TRUEAXIS_GAUGE_…` bits: what this revolution met.
     */
    uint16_t flags;
    /**
     * Revolutions in the window of the error motions; 0 until one is full.
     */
    uint16_t revolutions;
    /**
     * 1 while no work is under way: all of this is of one revolution then.
     */
    uint8_t settled;
    /**
     * 0.
     */
    uint8_t reserved[3];
    /**
     * Peak-to-valley roundness about the least-squares circle, after the filter if there is one, µm.
     */
    trueaxis_real_t peak_to_valley_um;
    /**
     * Error motion across probe 1.
     */
    struct trueaxis_motion_t x;
    /**
     * Error motion along probe 1.
     */
    struct trueaxis_motion_t y;
} trueaxis_evaluation_t;

/**
 * Readings of the gauge in a cycle.
 */
typedef struct trueaxis_probes_t {
    /**
     * `sizeof(trueaxis_probes_t)`, set by the caller once.
     */
    uint32_t size;
    /**
     * Counts of the spindle's encoder, wrapping.
     */
    int32_t spindle;
    /**
     * Counts latched by an index pulse since the last cycle (without a latch the counts of this cycle), if `has_index`.
     */
    int32_t index;
    /**
     * Counts of the arm's encoder, 0 where the arm points along the line of centres; unused without an arm.
     */
    int32_t arm;
    /**
     * Raw values of the three probes, in the unit of their gain.
     */
    trueaxis_real_t readings[3];
    /**
     * Not 0: an index pulse came since the last cycle.
     */
    uint8_t has_index;
    /**
     * Not 0: another workpiece; correction back to zero, evaluation begun anew.
     */
    uint8_t new_part;
    /**
     * Not 0: the wheel does not grind; measured all the same, but nothing is learnt for the infeed.
     */
    uint8_t idle;
    /**
     * Not looked at.
     */
    uint8_t reserved[5];
} trueaxis_probes_t;

/**
 * What the gauge gives back in a cycle.
 */
typedef struct trueaxis_gauge_cycle_t {
    /**
     * `sizeof(trueaxis_gauge_cycle_t)`, set by the caller once; stays as it is.
     */
    uint32_t size;
    /**
     * `TRUEAXIS_GAUGE_…` bits: what this cycle met.
     */
    uint16_t flags;
    /**
     * 1: a revolution has just been evaluated.
     */
    uint8_t finished;
    /**
     * 0.
     */
    uint8_t reserved;
    /**
     * Infeed correction that was asked of its axis, mm in the axis' sense; it is part of `drive` as far as the limits
     * allow.
     */
    trueaxis_real_t infeed;
} trueaxis_gauge_cycle_t;

/**
 * Done.
 */
#define TRUEAXIS_OK 0

/**
 * A pointer that must be given is `NULL`.
 */
#define TRUEAXIS_ERROR_NULL 1

/**
 * A structure or buffer has another size than this library needs: check `size` members and size arguments, that the
 * header belongs to the library, and that `TRUEAXIS_SINGLE` is defined for a single-precision library and for no other.
 */
#define TRUEAXIS_ERROR_SIZE 2

/**
 * A pointer is not aligned as its type needs; memory for tables and paths: 8 bytes.
 */
#define TRUEAXIS_ERROR_ALIGNMENT 3

/**
 * An object was never built or started, or is of another kind.
 */
#define TRUEAXIS_ERROR_UNBUILT 4

/**
 * Header and library are of different versions or of different precision.
 */
#define TRUEAXIS_ERROR_ABI 5

/**
 * The bytes are not a whole, undamaged `.tcomp` file of this format; details in `trueaxis_error_t`.
 */
#define TRUEAXIS_ERROR_TABLES 6

/**
 * The file is made for another machine.
 */
#define TRUEAXIS_ERROR_MACHINE 7

/**
 * What the file describes cannot be run with this configuration; details in `trueaxis_error_t`.
 */
#define TRUEAXIS_ERROR_CONFIG 8

/**
 * The memory lent is smaller than needed (`trueaxis_tables_info_t.memory_bytes`).
 */
#define TRUEAXIS_ERROR_MEMORY 9

/**
 * The period is not the one that the loop was built for (within 0.1 %).
 */
#define TRUEAXIS_ERROR_PERIOD 10

/**
 * Loop and state have different numbers of axes, or the number is not 3 to 6.
 */
#define TRUEAXIS_ERROR_AXES 11

/**
 * The state was started by a loop of the other kind (bypass or not): start a new one.
 */
#define TRUEAXIS_ERROR_STATE 12

/**
 * An argument is out of its range; the function says which.
 */
#define TRUEAXIS_ERROR_ARGUMENT 13

/**
 * The buffer is smaller than what is to be written.
 */
#define TRUEAXIS_ERROR_BUFFER 14

/**
 * The segment is no path; details in `trueaxis_error_t`.
 */
#define TRUEAXIS_ERROR_PATH 15

/**
 * The machine file has no gauge (no `[roundness]` section), or one of another number of points.
 */
#define TRUEAXIS_ERROR_GAUGE 16

/**
 * There is no value yet.
 */
#define TRUEAXIS_ERROR_NOT_YET 17

/**
 * The cycle was done, but there is nothing to write to the drives: no usable command has ever come, and not every axis
 * has been read. `drive` is left as it was; the rest of the output is written. Leave the drives without power.
 */
#define TRUEAXIS_ERROR_NO_OUTPUT 18

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Version of the library: `major << 16 | minor`, the top bit set for single precision.
 *
 * Real-time safe.
 */
uint32_t trueaxis_abi_version(void);

/**
 * Whether a program compiled with the header of version `header_version` (pass `TRUEAXIS_ABI_VERSION`) can use this
 * library: the same precision, the same major number, and no newer minor one.
 *
 * `TRUEAXIS_ERROR_ABI` otherwise: call nothing else then but `trueaxis_abi_version`, `trueaxis_status_text`, and, to go
 * on uncorrected, `trueaxis_loop_bypass`, `trueaxis_start` and `trueaxis_step`, which refuse structures of another size.
 * Real-time safe.
 */
trueaxis_status_t trueaxis_check_abi(uint32_t header_version);

/**
 * Words for a status: a constant string, never `NULL`, for any number.
 *
 * Real-time safe.
 */
const char *trueaxis_status_text(trueaxis_status_t status);

/**
 * Reads and checks a whole table file and tells what is in it.
 *
 * `file`, `length`: the bytes of a `.tcomp`, anywhere, of any alignment; only read. `info`: its `size` set by the caller.
 * `error`: may be `NULL`; written only on refusal. Not real-time: time linear in the length; takes about 15 KiB of stack.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_TABLES` (with `error->code`).
 */
trueaxis_status_t trueaxis_tables_info(const uint8_t *file,
                                       size_t length,
                                       struct trueaxis_tables_info_t *info,
                                       struct trueaxis_error_t *error);

/**
 * Starts an empty path in `memory`: 8-byte aligned, `TRUEAXIS_SPAN_BYTES` for every piece, the caller's as long as the
 * path is used.
 *
 * `path`, `path_size`: the caller's, `sizeof(trueaxis_path_t)`. `first_span`: sequence number of the first piece, 0 for a
 * path by itself. A host with a long program slides a window over it: each window is a path of its own whose
 * `first_span` goes on counting, so that the search finds its last foot again.
 *
 * Segments are numbered from 0 in the order in which they are appended. All functions that change a path are not
 * real-time safe (those that append take up to 8 KiB of stack), and must not run while a step uses it: fill another one
 * and pass that.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_ARGUMENT` (memory overlaps path).
 */
trueaxis_status_t trueaxis_path_start(struct trueaxis_path_t *path,
                                      size_t path_size,
                                      void *memory,
                                      size_t memory_size,
                                      uint32_t first_span);

/**
 * Normal of the machining plane for the segments appended from now on (G17: 0, 0, 1, as at the start); signs of the
 * contour error's components refer to it.
 *
 * `normal`: three numbers, of any length above 1e-6. `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_ARGUMENT`.
 */
trueaxis_status_t trueaxis_path_plane(struct trueaxis_path_t *path, const double *normal);

/**
 * Appends a straight line, mm: u = 0..1 proportional to length.
 *
 * `start`, `end`: three numbers each, X, Y, Z; every segment begins where the one before ends. `error`: may be `NULL`.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (shorter than 1e-9 mm, not finite, or beginning
 * more than 0.02 mm from the end of the segment before: so for every segment), `_MEMORY`.
 */
trueaxis_status_t trueaxis_path_line(struct trueaxis_path_t *path,
                                     const double *start,
                                     const double *end,
                                     struct trueaxis_error_t *error);

/**
 * Appends a circular arc about `normal` (right hand), a helix where start and end differ along it, mm: u = 0..1
 * proportional to the angle. Start and end at the same angle make a full circle.
 *
 * `start`, `end`, `center`, `normal`: three numbers each; `center` any point of the axis, `normal` of any length.
 * `turns`: full turns beyond the first arc. `error`: may be `NULL`.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (radii that differ by more than 0.02 mm, …),
 * `_MEMORY`.
 */
trueaxis_status_t trueaxis_path_arc(struct trueaxis_path_t *path,
                                    const double *start,
                                    const double *end,
                                    const double *center,
                                    const double *normal,
                                    uint32_t turns,
                                    struct trueaxis_error_t *error);

/**
 * Appends a spline (NURBS), mm: u over `knots[degree]` to `knots[point_count]`.
 *
 * `degree`: 1 to 5. `knots`: `point_count + degree + 1` ascending numbers. `points`: `3 * point_count` numbers, X, Y, Z of
 * one control point after the other. `weights`: `point_count` positive numbers, or `NULL` for weights of one. `error`:
 * may be `NULL`.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (`error->index`: which element), `_MEMORY`.
 */
trueaxis_status_t trueaxis_path_nurbs(struct trueaxis_path_t *path,
                                      uint32_t degree,
                                      const double *knots,
                                      const double *points,
                                      const double *weights,
                                      size_t point_count,
                                      struct trueaxis_error_t *error);

/**
 * The path is closed: behind the last piece the first one follows. Appending a segment opens it again.
 *
 * `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_PATH` (end and start are more than 0.02 mm apart, or the path is
 * empty).
 */
trueaxis_status_t trueaxis_path_close(struct trueaxis_path_t *path);

/**
 * Takes all segments out; memory, plane and the number of the first piece stay.
 *
 * `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`.
 */
trueaxis_status_t trueaxis_path_clear(struct trueaxis_path_t *path);

/**
 * How many segments the path has, and how many pieces they were converted into. Either may be `NULL`.
 *
 * Real-time safe. `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`.
 */
trueaxis_status_t trueaxis_path_count(const struct trueaxis_path_t *path, uint32_t *segments, uint32_t *spans);

/**
 * The place on the path at which segment `segment` (from 0) has parameter `u`: what `trueaxis_step` wants as
 * `reference`. Parameters beyond the segment's are held at its ends.
 *
 * Real-time safe: a search by halving over the pieces.
 *
 * `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_ARGUMENT` (no such segment, `u` not finite).
 */
trueaxis_status_t trueaxis_path_reference(const struct trueaxis_path_t *path,
                                          uint32_t segment,
                                          double u,
                                          struct trueaxis_reference_t *reference);

/**
 * Builds a servo loop from a compiled table file: 3 to 6 axes, as the file says.
 *
 * `loop`, `loop_size`: the caller's, `sizeof(trueaxis_loop_t)`. `file`, `length`: the bytes of the `.tcomp`; may be freed
 * afterwards. `machine_id`: the machine that the file must be for (`trueaxis_tables_info_t.machine_id`); 0 takes any.
 * `period_ns`: servo period, 1,000 to 100,000,000 ns. `memory`, `memory_size`: for the tables, 8-byte aligned, at least
 * `trueaxis_tables_info_t.memory_bytes`; the caller's, must outlive every use of the loop and of its copies, and nobody
 * may write to it in that time. `error`: may be `NULL`; written only on refusal.
 *
 * To exchange tables in motion, build another loop in other memory and pass that to `trueaxis_step` from some cycle on;
 * the limiter leads the correction over, nothing jumps. The old loop's memory is free from then on.
 *
 * Not real-time: time linear in the file's length; takes about 17 KiB of stack. On refusal the loop stays as it was, but
 * `memory` may have been written to.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_TABLES`, `_MACHINE`, `_CONFIG` (also: a period out of range),
 * `_MEMORY`, `_ARGUMENT` (memory overlaps file or loop).
 */
trueaxis_status_t trueaxis_loop_build(struct trueaxis_loop_t *loop,
                                      size_t loop_size,
                                      const uint8_t *file,
                                      size_t length,
                                      uint32_t machine_id,
                                      uint32_t period_ns,
                                      void *memory,
                                      size_t memory_size,
                                      struct trueaxis_error_t *error);

/**
 * Builds a loop that passes every command uncorrected and says why in every record: for going on without tables.
 *
 * `axes`: 3 to 6. `reason`: `TRUEAXIS_FAULT_PERIOD_MISMATCH`, `_TABLES_REFUSED`, `_CAPACITY_TOO_SMALL` or
 * `_ABI_MISMATCH`. `period_ns`: servo period, 1,000 to 100,000,000 ns. It needs no memory. A command that is no usable
 * number is not passed: the last one holds, before the first one the place that is read, and a stop is requested until
 * the next usable one.
 *
 * Real-time safe. `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_AXES`, `_ARGUMENT` (reason, period).
 */
trueaxis_status_t trueaxis_loop_bypass(struct trueaxis_loop_t *loop,
                                       size_t loop_size,
                                       uint32_t axes,
                                       uint8_t reason,
                                       uint32_t period_ns);

/**
 * A fresh state for a loop, if the host runs at the loop's period (within 0.1 %).
 *
 * `state`, `state_size`: the caller's, `sizeof(trueaxis_state_t)`. Real-time safe.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_PERIOD`.
 */
trueaxis_status_t trueaxis_start(const struct trueaxis_loop_t *loop,
                                 struct trueaxis_state_t *state,
                                 size_t state_size,
                                 uint32_t period_ns);

/**
 * One servo cycle: what the drives are sent, and how far the tool is from its path.
 *
 * The first cycle returns the command; from then on `drive = command + correction`. `path`: what the interpolator
 * follows, `reference`: where on it the command of this cycle lies; either may be `NULL`, then no contour error is
 * measured. `input->size` and `output->size` must be set. Loops may be exchanged between two cycles: pass another one
 * of the same number of axes.
 *
 * Real-time safe: no allocation, no lock, no system call, bounded time. On refusal, state and output stay as they were.
 *
 * Where neither a usable command has ever come nor every axis been read, there is no place to hold: the answer is
 * `TRUEAXIS_ERROR_NO_OUTPUT` and `output->drive` is not written. Once every axis has been read (without an alarm), its
 * place is held, and a reset near it is heard.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_NO_OUTPUT`. What goes wrong on the
 * machine otherwise is not a status but `output->record.fault`.
 */
trueaxis_status_t trueaxis_step(const struct trueaxis_loop_t *loop,
                                struct trueaxis_state_t *state,
                                const struct trueaxis_input_t *input,
                                const struct trueaxis_path_t *path,
                                const struct trueaxis_reference_t *reference,
                                struct trueaxis_output_t *output);

/**
 * Tells the temperature of an axis; its growth, as the table file describes it, takes effect in the next cycle, through
 * the limiter.
 *
 * `place`: of the axis, 0 = X. `kelvin`: above the reference temperature of the file. Call it between two cycles, from
 * the thread that steps. In a bypass it does nothing. Real-time safe.
 *
 * `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_ARGUMENT` (no such place; `kelvin` not finite or
 * so large that the growth exceeds 10 mm or 1e-3 of the length).
 */
trueaxis_status_t trueaxis_set_thermal(const struct trueaxis_loop_t *loop,
                                       struct trueaxis_state_t *state,
                                       uint32_t place,
                                       double kelvin);

/**
 * Writes the telemetry frame of a record: postcard in COBS, its last byte 0, at most `TRUEAXIS_FRAME_BYTES`; the same
 * bytes in every build and precision.
 *
 * `output`: of a step. `buffer`, `size`: where to. `written`: receives the number of bytes.
 *
 * Bounded time, but not part of the cycle: on a core without double precision some hundred instructions an axis.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_BUFFER`, `_ARGUMENT` (no output of a step).
 */
trueaxis_status_t trueaxis_frame_encode(const struct trueaxis_output_t *output,
                                        uint8_t *buffer,
                                        size_t size,
                                        size_t *written);

/**
 * Starts an empty window.
 *
 * `follow`, `follow_size`: the caller's, `sizeof(trueaxis_follow_t)`. `plane`: normal of the machining plane, three
 * numbers of any length, for the signed components of the contour error; `NULL` for 0, 0, 1 (G17). `spacing_mm`: way
 * between two points at slow feeds, 0.001 to 1 mm; 0.005 is a good one. The window must hold the largest lag of the tool:
 * `TRUEAXIS_FOLLOW_PIECES` times the spacing, or the way in as many cycles, whichever is more.
 *
 * Not real-time; takes about 75 KiB of stack, 43 KiB in single precision.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_ARGUMENT` (plane or spacing).
 */
trueaxis_status_t trueaxis_follow_start(struct trueaxis_follow_t *follow,
                                        size_t follow_size,
                                        const double *plane,
                                        double spacing_mm);

/**
 * Forgets all commands, as after homing: the next one begins anew. Real-time safe.
 *
 * `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`.
 */
trueaxis_status_t trueaxis_follow_restart(struct trueaxis_follow_t *follow);

/**
 * `trueaxis_step` with the commands themselves as the path: X, Y and Z of this cycle's command, once it is believed, are
 * appended to the window, and the contour errors are measured against that.
 *
 * Arguments as there. While `record.tip.flags` lacks `TRUEAXIS_CONTOUR_BRACKETED` the tool is further behind than the
 * window reaches. In a bypass nothing is measured. Real-time safe.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_NO_OUTPUT`.
 */
trueaxis_status_t trueaxis_step_following(const struct trueaxis_loop_t *loop,
                                          struct trueaxis_state_t *state,
                                          const struct trueaxis_input_t *input,
                                          struct trueaxis_follow_t *follow,
                                          struct trueaxis_output_t *output);

/**
 * Builds the gauge that a table file describes (its machine's `[roundness]` section): 1024 or 512 points a revolution.
 *
 * `gauge`, `gauge_size`: the caller's, `sizeof(trueaxis_gauge_t)`. `file`, `length`: the bytes of the `.tcomp`; may be
 * freed afterwards. `period_ns`: servo period, 1,000 to 100,000,000 ns. `error`: may be `NULL`.
 *
 * Not real-time; takes about 117 KiB of stack, 65 KiB in single precision.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_TABLES`, `_CONFIG` (period out of range), `_GAUGE` (no gauge, or of
 * another number of points).
 */
trueaxis_status_t trueaxis_gauge_build(struct trueaxis_gauge_t *gauge,
                                       size_t gauge_size,
                                       const uint8_t *file,
                                       size_t length,
                                       uint32_t period_ns,
                                       struct trueaxis_error_t *error);

/**
 * Makes a state new: nothing is measured or fed in until another revolution is whole, and the wheel is that of the file.
 *
 * `gauge_state`, `state_size`: the caller's; `sizeof(trueaxis_gauge_state_t)` for a gauge of 1024 points,
 * `sizeof(trueaxis_gauge_state_512_t)` for one of 512.
 *
 * Not real-time: it clears all of the state; takes about 65 KiB of stack, 33 KiB in single precision.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`.
 */
trueaxis_status_t trueaxis_gauge_restart(const struct trueaxis_gauge_t *gauge,
                                         struct trueaxis_gauge_state_t *gauge_state,
                                         size_t state_size);

/**
 * Sets the radius of the wheel, mm (wear, dressing); in force from the next revolution that is worked on.
 *
 * `error`: may be `NULL`. `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_CONFIG` (no following arm, or the
 * linkage could not close).
 */
trueaxis_status_t trueaxis_gauge_set_wheel(const struct trueaxis_gauge_t *gauge,
                                           struct trueaxis_gauge_state_t *gauge_state,
                                           double wheel_mm,
                                           struct trueaxis_error_t *error);

/**
 * The latest revolution evaluated.
 *
 * Real-time safe; to be called between two cycles. `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_NOT_YET`.
 */
trueaxis_status_t trueaxis_gauge_latest(const struct trueaxis_gauge_t *gauge,
                                        struct trueaxis_gauge_state_t *gauge_state,
                                        struct trueaxis_evaluation_t *evaluation);

/**
 * Amplitudes of cos kθ and sin kθ in the latest profile, µm: two numbers to `amplitudes_um`. Zero outside the band of the
 * file and where a harmonic is suppressed.
 *
 * Real-time safe; to be called between two cycles. `TRUEAXIS_ERROR_NULL`, `_ALIGNMENT`, `_UNBUILT`, `_NOT_YET`,
 * `_ARGUMENT` (harmonics are kept up to 127).
 */
trueaxis_status_t trueaxis_gauge_harmonic(const struct trueaxis_gauge_t *gauge,
                                          struct trueaxis_gauge_state_t *gauge_state,
                                          uint32_t harmonic,
                                          trueaxis_real_t *amplitudes_um);

/**
 * Writes the telemetry frame of the latest revolution: postcard in COBS, its last byte 0, at most
 * `TRUEAXIS_GAUGE_FRAME_BYTES`.
 *
 * `machine_id`: goes into the frame. `buffer`, `size`: where to. `written`: receives the number of bytes. Bounded time,
 * but not part of the cycle; takes about 4 KiB of stack.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_NOT_YET`, `_BUFFER`.
 */
trueaxis_status_t trueaxis_gauge_frame_encode(const struct trueaxis_gauge_t *gauge,
                                              struct trueaxis_gauge_state_t *gauge_state,
                                              uint32_t machine_id,
                                              uint8_t *buffer,
                                              size_t size,
                                              size_t *written);

/**
 * `trueaxis_step` with a gauge of three probes riding along: some units of its work a cycle, its infeed correction added
 * to what the tables want of that axis, through the same limiter.
 *
 * Arguments as there; `probes->size` and `cycle->size` must be set as well. While the step is not active, and in a bypass,
 * the gauge measures on but nothing is fed in. Real-time safe.
 *
 * `TRUEAXIS_ERROR_NULL`, `_SIZE`, `_ALIGNMENT`, `_UNBUILT`, `_AXES`, `_STATE`, `_NO_OUTPUT`.
 */
trueaxis_status_t trueaxis_step_with_gauge(const struct trueaxis_loop_t *loop,
                                           struct trueaxis_state_t *state,
                                           const struct trueaxis_input_t *input,
                                           const struct trueaxis_path_t *path,
                                           const struct trueaxis_reference_t *reference,
                                           const struct trueaxis_gauge_t *gauge,
                                           struct trueaxis_gauge_state_t *gauge_state,
                                           const struct trueaxis_probes_t *probes,
                                           struct trueaxis_output_t *output,
                                           struct trueaxis_gauge_cycle_t *cycle);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRUEAXIS_H */
