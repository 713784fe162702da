/* Messages and behaviour of a controller with refused tables. SPDX-License-Identifier: MIT OR Apache-2.0 */
#include <stdio.h>

#include "machine.h"

int main(void) {
    machine(400.0f);
    core_start(NULL);
    core_home((axes_signals_t){ .mask = 7 }, true);
    bool done = line_to(-120, -80, -60, (plan_line_data_t){ 0 });
    core_command("TRUEAXIS=1");
    printf("%s%s, %u block to %ld %ld %ld\n", told, done ? "moved" : "refused", block_count, (long)sys.position[0],
           (long)sys.position[1], (long)sys.position[2]);
    return 0;
}
