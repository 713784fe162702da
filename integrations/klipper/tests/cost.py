# COST writes the time that the host spent solving for steps, ns, and restarts. SPDX-License-Identifier: GPL-3.0-or-later
import time


class Cost:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.path = config.get("file")
        self.spent = 0
        self.printer.register_event_handler("klippy:connect", self.connect)
        self.printer.lookup_object("gcode").register_command("COST", self.cmd_COST)

    def connect(self):
        for stepper in self.printer.lookup_object("toolhead").get_kinematics().get_steppers():
            stepper._itersolve_generate_steps = self.timed(stepper._itersolve_generate_steps)

    def timed(self, solve):
        def call(*given):
            begun = time.thread_time_ns()
            found = solve(*given)
            self.spent += time.thread_time_ns() - begun
            return found

        return call

    def cmd_COST(self, gcmd):
        self.printer.lookup_object("toolhead").flush_step_generation()
        with open(self.path, "w") as file:
            file.write(str(self.spent))
        self.spent = 0


def load_config(config):
    return Cost(config)
