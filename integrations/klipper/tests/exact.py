# Makes step compression exact on Klipper's main line, where its error (half a microstep) has been a constant since
# October 2025. Kalico has the option max_stepper_error. SPDX-License-Identifier: GPL-3.0-or-later
import stepper


def load_config(config):
    stepper.MAX_STEPCOMPRESS_ERROR = 0.000001
    return stepper
