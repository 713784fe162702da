# Probing moves in any direction, for the programs of `trueaxis calibrate plan`.
#
#   [trueaxis_probe]
#   pin: ^PC7
#
#   TRUEAXIS_PROBE ID=17 X=120.5 Y=80 Z=-5 F=60
#
# moves in a straight line until the probe triggers, and reports the machine's position at that moment:
#
#   // trueaxis touch 17 X:118.402500 Y:80.000000 Z:-5.000000 tripped:1
#
# Positions are the toolhead's, in machine coordinates; offsets set by G92 or SET_GCODE_OFFSET do not apply. A move that
# touches nothing, or that starts with the probe triggered, is an error and ends the program.
#
#   TRUEAXIS_NOTE MSG="trueaxis calibrate 1234abcd touches 96"
#
# reports a note in the same way, on the console and in klippy.log; RESPOND writes nothing to klippy.log.
#
# This file may be distributed under the terms of the GNU GPLv3 license.
import inspect

try:
    from . import homing
except ImportError:
    homing = None


class TrueaxisProbe:
    def __init__(self, config):
        self.printer = config.get_printer()
        pins = self.printer.lookup_object("pins")
        self.endstop = pins.setup_pin("endstop", config.get("pin"))
        self.printer.register_event_handler("klippy:mcu_identify", self.add_steppers)
        gcode = self.printer.lookup_object("gcode")
        gcode.register_command("TRUEAXIS_PROBE", self.cmd_probe, desc=self.cmd_probe_help)
        gcode.register_command("TRUEAXIS_NOTE", self.cmd_note, desc=self.cmd_note_help)

    def meet_host(self):
        # Refuses a host whose probing moves have another interface.
        def needs(name, found):
            if not found:
                raise self.printer.config_error(
                    "trueaxis_probe: this version of the host has no homing.%s, which the extra uses" % (name,)
                )

        move = getattr(homing, "HomingMove", None)
        needs("HomingMove", move)
        needs("HomingMove.homing_move", callable(getattr(move, "homing_move", None)))
        needs("HomingMove.homing_move(probe_pos)", "probe_pos" in inspect.signature(move.homing_move).parameters)
        needs("HomingMove.stepper_positions", hasattr(move(self.printer, [(self.endstop, "probe")]), "stepper_positions"))

    def add_steppers(self):
        self.meet_host()
        # A move in any direction may need any of the motors.
        kinematics = self.printer.lookup_object("toolhead").get_kinematics()
        for stepper in kinematics.get_steppers():
            self.endstop.add_stepper(stepper)

    cmd_probe_help = "Straight move until the probe trips; says where that was"

    def cmd_probe(self, gcmd):
        toolhead = self.printer.lookup_object("toolhead")
        number = gcmd.get_int("ID", minval=1)
        to = list(toolhead.get_position())
        for index, axis in enumerate("XYZ"):
            to[index] = gcmd.get_float(axis, to[index])
        speed = gcmd.get_float("F", above=0.0) / 60.0
        # The host's own probing_move is unusable here: it refuses every move in which one of the motors does not move.
        move = homing.HomingMove(self.printer, [(self.endstop, "probe")])
        trip = move.homing_move(to, speed, probe_pos=True)
        if all(motor.trig_pos == motor.start_pos for motor in move.stepper_positions):
            raise gcmd.error("Probe triggered prior to movement")
        gcmd.respond_info(
            "trueaxis touch %d X:%.6f Y:%.6f Z:%.6f tripped:1" % (number, trip[0], trip[1], trip[2])
        )

    cmd_note_help = "Says something on the console and in the log"

    def cmd_note(self, gcmd):
        gcmd.respond_info(gcmd.get("MSG"))


def load_config(config):
    return TrueaxisProbe(config)
