/*
 * A library that leaves parts out links, and refuses by name every function and setting that needs them.
 *
 *   left_out grids.tcomp volumetric.tcomp ...      with a library without any part except `text`
 *
 * Prints the refusals; exits with 1 if anything else happens.
 */
#include <stdio.h>
#include <string.h>

#include "trueaxis.h"

static int wrong;
static uint8_t file[1 << 20];
static uint64_t memory[1 << 16];
static trueaxis_loop_t loop;
static trueaxis_error_t error = { .size = sizeof error };

static void needed(const char *call, trueaxis_result_t found, trueaxis_result_t result) {
    if (found != result) {
        printf("%s: found result %d, needed %d\n", call, (int)found, (int)result);
        wrong = 1;
    }
}

/* A function that is left out refuses before it checks its pointers; one that is built in refuses the null ones. */
#define REFUSED(call) needed(#call, call, TRUEAXIS_ERROR_LEFT_OUT)

static void functions(void) {
    REFUSED(trueaxis_gauge_build(NULL, 0, NULL, 0, 0, NULL));
    REFUSED(trueaxis_gauge_restart(NULL, NULL, 0));
    REFUSED(trueaxis_gauge_set_wheel(NULL, NULL, 0, NULL));
    REFUSED(trueaxis_gauge_latest(NULL, NULL, NULL));
    REFUSED(trueaxis_gauge_harmonic(NULL, NULL, 0, NULL));
    REFUSED(trueaxis_gauge_frame_encode(NULL, NULL, 0, NULL, 0, NULL));
    REFUSED(trueaxis_kinematics_build(NULL, 0, NULL, 0, NULL));
    REFUSED(trueaxis_kinematics_set_tool(NULL, NULL));
    REFUSED(trueaxis_kinematics_forward(NULL, NULL, NULL));
    REFUSED(trueaxis_branch_tracker_start(NULL, 0, NULL, NULL, 0, NULL));
    REFUSED(trueaxis_branch_tracker_direction_error(NULL, NULL));
    REFUSED(trueaxis_rtcp(NULL, NULL, NULL, NULL, NULL, NULL));
    REFUSED(trueaxis_path_start_tool(NULL, 0, NULL, 0, 0));
    REFUSED(trueaxis_path_axes(NULL, NULL, NULL));
    REFUSED(trueaxis_path_directions(NULL, NULL, NULL));
    REFUSED(trueaxis_path_turning(NULL, NULL, NULL));
    REFUSED(trueaxis_path_arc(NULL, NULL, NULL, NULL, NULL, 0, NULL));
    REFUSED(trueaxis_path_nurbs(NULL, 0, NULL, NULL, NULL, 0, NULL));
    REFUSED(trueaxis_program_start(NULL, 0, 0));
    REFUSED(trueaxis_program_point(NULL, NULL));
    REFUSED(trueaxis_program_id(NULL, NULL));
    REFUSED(trueaxis_learned_build(NULL, 0, NULL, 0, 0, 0, 0, NULL));
    REFUSED(trueaxis_learned_at(NULL, 0, NULL));
    REFUSED(trueaxis_thermal_build(NULL, 0, NULL, 0, 0, NULL, NULL));
    REFUSED(trueaxis_thermal_start(NULL, 0));
    REFUSED(trueaxis_thermal_update(NULL, NULL, NULL, NULL));
    REFUSED(trueaxis_thermal_believe(NULL, 0));
    REFUSED(trueaxis_set_growth(NULL, NULL, NULL));
    needed("a path that is there", trueaxis_path_line(NULL, NULL, NULL, NULL), TRUEAXIS_ERROR_NULL);
}

int main(int count, char **names) {
    functions();
    for (int i = 1; i < count; ++i) {
        FILE *stream = fopen(names[i], "rb");
        if (stream == NULL) {
            printf("%s cannot be opened\n", names[i]);
            return 1;
        }
        const size_t length = fread(file, 1, sizeof file, stream);
        fclose(stream);
        needed(names[i],
               trueaxis_loop_build(&loop, sizeof loop, file, length, 0, 1000000, memory, sizeof memory, &error),
               TRUEAXIS_ERROR_LEFT_OUT);
        const char *slash = strrchr(names[i], '/');
        printf("%s: code %u, field %s, %s\n", slash ? slash + 1 : names[i], (unsigned)error.code, error.field, error.text);
    }
    return wrong;
}
