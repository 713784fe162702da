# Writes the planned moves and every new position of the motors to a file. SPDX-License-Identifier: GPL-3.0-or-later
import json


class Record:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.file = open(config.get("file"), "w")
        self.printer.register_event_handler("klippy:connect", self.connect)
        self.printer.register_event_handler("toolhead:set_position", self.sync)

    def connect(self):
        self.toolhead = self.printer.lookup_object("toolhead")
        append = self.toolhead.trapq_append

        def recorded(trapq, *move):
            json.dump({"move": move}, self.file)
            self.file.write("\n")
            append(trapq, *move)

        self.toolhead.trapq_append = recorded

    def sync(self):
        steppers = [(s.get_name(), s.get_oid(), s.get_mcu_position(), s.get_commanded_position(), s.get_step_dist())
                    for s in self.toolhead.get_kinematics().get_steppers()]
        json.dump({"on": self.printer.lookup_object("trueaxis").on, "kinematics": type(self.toolhead.get_kinematics()).__name__, "steppers": steppers}, self.file)
        self.file.write("\n")
        self.file.flush()


def load_config(config):
    return Record(config)
