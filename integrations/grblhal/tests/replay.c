/* Replays rapids to the points of the recording common to all hosts. Each line of POINTS has a point and the motors'
 * target. Prints the largest difference.
 * SPDX-License-Identifier: MIT OR Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "machine.h"

#define STEPS_PER_MM 20000.0f

int main(void) {
    static const plan_line_data_t rapid = { .condition.rapid_motion = 1 };
    double to[N_AXIS], needed[N_AXIS], largest = 0.0;
    long samples = 0;
    char line[256];
    FILE *points = fopen(POINTS, "r");
    core_state(STATE_IDLE);
    machine(STEPS_PER_MM);
    core_start(NULL);
    core_home((axes_signals_t){ .mask = 7 }, true);
    core_state(STATE_IDLE);
    while (points != NULL && fgets(line, sizeof line, points) != NULL) {
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf", &to[0], &to[1], &to[2], &needed[0], &needed[1], &needed[2]) != 6 ||
            !line_to((float)to[0], (float)to[1], (float)to[2], rapid)) {
            printf("line %ld of " POINTS " cannot be read, or not be gone to\n", samples / N_AXIS + 1);
            return 1;
        }
        for (int idx = 0; idx < N_AXIS; idx++, samples++) {
            largest = fmax(largest, fabs((double)sys.position[idx] / (double)STEPS_PER_MM - needed[idx]));
        }
    }
    printf("%ld %.3g\n", samples, largest);
    return samples == 0;
}
