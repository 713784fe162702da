#!/usr/bin/python3
"""Reads rows of three numbers from HAL's first sampler, bit for bit: collect.py ROWS NAME."""
import os
import sys
import time

import hal

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from recording import Recording

count, name = int(sys.argv[1]), sys.argv[2]
component = hal.component("collect")
component.ready()
stream = hal.stream(component, hal.sampler_base, "fff")
rows, end = [], time.time() + 50
while len(rows) < count and time.time() < end:
    if stream.readable:
        rows.append(stream.read())
    else:
        time.sleep(0.005)
Recording(["x", "y", "z"], rows).save(name)
