"""Writes the protocol dictionary of a board with steppers and endstops: dictionary.py OUT.

With it the host checks and compresses its messages without a board. It contains only what the tests' machines need.
SPDX-License-Identifier: GPL-3.0-or-later
"""
import json
import sys

COMMANDS = """
get_config
config_reset
finalize_config crc=%u
allocate_oids count=%c
get_clock
get_uptime
emergency_stop
clear_shutdown
reset
debug_nop
config_stepper oid=%c step_pin=%c dir_pin=%c invert_step=%c step_pulse_ticks=%u
queue_step oid=%c interval=%u count=%hu add=%hi
set_next_step_dir oid=%c dir=%c
reset_step_clock oid=%c clock=%u
stepper_get_position oid=%c
stepper_stop_on_trigger oid=%c trsync_oid=%c
config_endstop oid=%c pin=%c pull_up=%c
endstop_home oid=%c clock=%u sample_ticks=%u sample_count=%c rest_ticks=%u pin_value=%c trsync_oid=%c trigger_reason=%c
endstop_query_state oid=%c
config_trsync oid=%c
trsync_start oid=%c report_clock=%u report_ticks=%u expire_reason=%c
trsync_set_timeout oid=%c clock=%u
trsync_trigger oid=%c reason=%c
config_digital_out oid=%c pin=%u value=%c default_value=%c max_duration=%u
update_digital_out oid=%c value=%c
queue_digital_out oid=%c clock=%u on_ticks=%u
set_digital_out_pwm_cycle oid=%c cycle_ticks=%u
set_digital_out pin=%u value=%c
"""
RESPONSES = """
config is_config=%c crc=%u is_shutdown=%c move_count=%hu
clock clock=%u
uptime high=%u clock=%u
stepper_position oid=%c pos=%i
endstop_state oid=%c homing=%c next_clock=%u pin_value=%c
trsync_state oid=%c can_trigger=%c trigger_reason=%c clock=%u
shutdown clock=%u static_string_id=%hu
is_shutdown static_string_id=%hu
stats count=%u sum=%u sumsq=%u
starting
"""
names = lambda text, first: {line: first + i for i, line in enumerate(text.strip().splitlines())}
commands = names(COMMANDS, 2)
with open(sys.argv[1], "w") as out:
    json.dump({
        "commands": {"identify offset=%u count=%c": 1, **commands},
        "responses": {"identify_response offset=%u data=%.*s": 0, **names(RESPONSES, 2 + len(commands))},
        "enumerations": {"pin": {"PA0": [0, 32]}, "static_string_id": {"none": 2}},
        "config": {"CLOCK_FREQ": 20000000, "STATS_SUMSQ_BASE": 256, "MCU": "linux"},
        "app": "Kalico", "version": "v0", "build_versions": "none",
    }, out)
