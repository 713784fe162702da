# DRAIN waits until all planned moves are written, because the host drops the rest when it exits.
# SPDX-License-Identifier: GPL-3.0-or-later
import re


class Drain:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.printer.lookup_object("gcode").register_command("DRAIN", self.cmd_DRAIN)

    def cmd_DRAIN(self, gcmd):
        self.printer.lookup_object("toolhead").flush_step_generation()
        mcu, reactor = self.printer.lookup_object("mcu"), self.printer.get_reactor()
        while True:
            _, stats = mcu.stats(reactor.monotonic())
            waiting = [int(n) for n in re.findall(r"(?:ready|upcoming)_bytes=(\d+)", stats)]
            assert len(waiting) == 2, stats
            if not any(waiting):
                return
            reactor.pause(reactor.monotonic() + 0.05)


def load_config(config):
    return Drain(config)
