"""Simulates a bed and a probe that finds it: BED_LOOK NAME=what writes the positions of the drives, the host and the probe.

The drives' positions follow from the steps since homing, and the library's command gives the tool's position from them, so
neither depends on the extra under test. SPDX-License-Identifier: GPL-3.0-or-later
"""
import json

from . import truth

START = 20.0  # mm; position of Z before it is homed


class Bed:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.command, self.machine = config.get("command"), config.get("machine")
        self.file = open(config.get("file"), "w")
        self.zero = None
        self.printer.register_event_handler("klippy:connect", self.connect)
        self.printer.lookup_object("gcode").register_command("BED_LOOK", self.cmd_BED_LOOK)

    def connect(self):
        self.toolhead = self.printer.lookup_object("toolhead")
        self.kin = self.toolhead.get_kinematics()
        self.probe = self.printer.lookup_object("probe")
        endstop = self.probe.mcu_probe
        if not hasattr(endstop, "home_start"):  # Klipper's main line
            endstop = endstop.mcu_endstop
        self.home_start, self.home_wait = endstop.home_start, endstop.home_wait
        endstop.home_start, endstop.home_wait = self.start, self.touch

    def drives(self, steps):
        at = {s.get_name(): steps(s) * s.get_step_dist() + self.zero[s.get_name()] for s in self.kin.get_steppers()}
        return list(type(self.kin).calc_position(self.kin, at))

    def start(self, print_time, *args, **kwargs):
        self.begun = print_time
        if self.zero is None:
            # X and Y are homed, so the host knows their motors' zeros. It does not know that of Z yet.
            self.zero = {s.get_name(): s.mcu_to_commanded_position(0) for s in self.kin.get_steppers()}
            for s in filter(lambda s: s.is_active_axis("z"), self.kin.get_steppers()):
                self.zero[s.get_name()] = START - s.get_mcu_position() * s.get_step_dist()
        return self.home_start(print_time, *args, **kwargs)

    def touch(self, end):
        self.home_wait(end)
        self.toolhead.flush_step_generation()
        x, y, _ = self.drives(lambda s: s.get_past_mcu_position(end))
        above, tool = self.probe.get_offsets()[2], [x, y, 0.0]
        for _ in range(truth.PASSES):
            tool[2] = truth.height(*tool[:2]) + above
            sent = truth.commands(self.command, self.machine, [tool])[0]
            tool[:2] = tool[0] + x - sent[0], tool[1] + y - sent[1]
        low, high = self.begun, end
        for _ in range(50):
            middle = (low + high) / 2
            reached = self.drives(lambda s: s.get_past_mcu_position(middle))[2] <= sent[2]
            low, high = (low, middle) if reached else (middle, high)
        self.write(touch=tool)
        return high

    def cmd_BED_LOOK(self, gcmd):
        self.toolhead.flush_step_generation()
        mesh = self.printer.lookup_object("bed_mesh").get_mesh()
        self.write(look=gcmd.get("NAME"), drives=self.drives(lambda s: s.get_mcu_position()),
                   told=self.printer.lookup_object("gcode_move").get_status()["gcode_position"][:3],
                   probed=self.probe.get_status(0)["last_z_result"], mesh=mesh and mesh.get_probed_matrix(), step=self.kin.get_steppers()[0].get_step_dist())

    def write(self, **what):
        json.dump(what, self.file)
        self.file.write("\n")
        self.file.flush()


def load_config(config):
    return Bed(config)
