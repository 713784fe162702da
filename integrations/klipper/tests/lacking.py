# Removes one of the host's calls while the extra is set up, as a future version might. SPDX-License-Identifier:
# GPL-3.0-or-later
from . import homing

try:
    from klippy import chelper
except ImportError:
    import chelper


class Lacking:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.kind, self.name = config.get("call").rsplit(".", 1)
        self.printer.register_event_handler("klippy:mcu_identify", self.take)

    def take(self):
        toolhead = self.printer.lookup_object("toolhead")
        kin = toolhead.get_kinematics()
        self.holder = {"chelper": chelper, "homing.Homing": homing.Homing, "homing.HomingMove": homing.HomingMove, "toolhead": toolhead, "kinematics": kin,
                       "stepper": kin.get_steppers()[0], "rail": kin.rails[0]}[self.kind]
        if self.name == "stepper_positions":  # made by its constructor
            self.name, self.call = "__init__", homing.HomingMove.__init__
            setattr(self.holder, self.name, lambda *_: None)
        else:
            self.call = getattr(self.holder, self.name)
            setattr(self.holder, self.name, None)
        self.printer.register_event_handler("klippy:mcu_identify", self.give)  # called after the extra's

    def give(self):
        setattr(self.holder, self.name, self.call)


def load_config(config):
    return Lacking(config)
