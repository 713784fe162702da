# ZERO NAME=name writes the position, in mm, of every motor at step 0. SPDX-License-Identifier: GPL-3.0-or-later
import json

from . import homing


class Zero:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.file = open(config.get("file"), "w")
        self.sought = None
        gcode = self.printer.lookup_object("gcode")
        gcode.register_command("ZERO", self.cmd_ZERO)
        gcode.register_command("ZERO_SEEK", self.cmd_ZERO_SEEK)
        gcode.register_command("ZERO_TWICE", self.cmd_ZERO_TWICE)

    def cmd_ZERO(self, gcmd):
        toolhead = self.printer.lookup_object("toolhead")
        toolhead.flush_step_generation()
        kin = toolhead.get_kinematics()
        zero = type(kin).calc_position(kin, {s.get_name(): s.mcu_to_commanded_position(0) for s in kin.get_steppers()})
        json.dump({"name": gcmd.get("NAME"), "zero": list(zero)[:3], "sought": self.sought}, self.file)
        self.file.write("\n")
        self.file.flush()

    def cmd_ZERO_TWICE(self, gcmd):
        """Sets Z twice and passes the same X and Y both times, as Z_TILT_ADJUST does."""
        toolhead = self.printer.lookup_object("toolhead")
        to = toolhead.get_position()
        for z in (gcmd.get_float("Z"), gcmd.get_float("Z") + 30.0):
            to[2] = z
            toolhead.set_position(to)

    def cmd_ZERO_SEEK(self, gcmd):
        """Moves down to a switch outside G28. As in homing, the switch defines the end of the move."""
        toolhead = self.printer.lookup_object("toolhead")
        endstop = self.printer.lookup_object("probe").mcu_probe
        if not hasattr(endstop, "home_start"):  # Klipper's main line
            endstop = endstop.mcu_endstop
        to = toolhead.get_position()
        to[2] = gcmd.get_float("Z")
        move = homing.HomingMove(self.printer, [(endstop, "probe")])
        move.homing_move(to, 20.0)
        kin = toolhead.get_kinematics()
        touched = {s.get_name(): s.get_commanded_position() for s in kin.get_steppers()}
        for motor in move.stepper_positions:
            touched[motor.stepper_name] = motor.stepper.mcu_to_commanded_position(motor.trig_pos)
        self.sought = kin.calc_position(touched)[2] - to[2]


def load_config(config):
    return Zero(config)
