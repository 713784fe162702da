#!/usr/bin/python3
"""Runs all tests of the component as an ordinary user, with time limits: run.py WORK [NAME...]."""
import os
import shutil
import sys
import time
import traceback

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
import checks
from rig import Broken


def main(work, names):
    failed = []
    for name in names or checks.ALL:
        folder = os.path.join(work, name)
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        start = time.time()
        try:
            said = checks.ALL[name](folder)
            print("ok     %-22s %5.1f s  %s" % (name, time.time() - start, said or ""), flush=True)
        except Exception as broken:
            failed.append(name)
            said = broken if isinstance(broken, Broken) else traceback.format_exc()
            print("FAILED %-22s %5.1f s  %s" % (name, time.time() - start, said), flush=True)
    print("%d tests, %d failed%s" % (len(names or checks.ALL), len(failed), "".join(" " + f for f in failed)))
    return 1 if failed else 0


sys.exit(main(sys.argv[1], sys.argv[2:]))
