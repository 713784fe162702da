"""Sets up the machines that the tests run, each in a separate folder."""
import os
import re
import shutil
import subprocess

import rig

TRUEAXIS = os.environ["TRUEAXIS"]
REPOSITORY = os.path.realpath(os.path.join(rig.HERE, "..", "..", ".."))
SAMPLES = os.path.join(REPOSITORY, "compensation-tables")
DEFAULT_LIMITS = (0.1, 5.0, 5000.0)


def compile_tables(folder, machine, name):
    subprocess.run([TRUEAXIS, "tables", "compile", machine, "-o", os.path.join(folder, name)], check=True,
                   capture_output=True, timeout=60 * rig.PATIENCE)


def compile_thermal(folder, text, machine, name):
    """Compiles thermal growth for the component to load."""
    words = [TRUEAXIS, "thermal", "compile", os.path.join(folder, text), "--machine", machine]
    subprocess.run(words + ["-o", os.path.join(folder, name)], check=True, capture_output=True, timeout=60 * rig.PATIENCE)


def mill(folder, change=None):
    """Sets up the sample configuration as it is, or after a change of machine.toml."""
    rig.copy(folder, rig.CONFIG, *os.listdir(rig.CONFIG))
    rig.copy(folder, rig.HERE, "program.ngc")
    if change:
        edited_tables(folder, os.path.join(SAMPLES, "mill-3axis"), "mill-3axis", change, None)
    else:
        compile_tables(folder, os.path.join(SAMPLES, "mill-3axis", "machine.toml"), "mill-3axis.tcomp")


LENGTH = re.compile(r"^((?:MAX|MIN|DEFAULT)_\w+|\w*FERROR|HOME\w*) = (-?[\d.]+)$", re.M)


def in_inches(text):
    """Changes an INI file of linear joints to the same machine in inches."""
    text = LENGTH.sub(lambda m: m[0] if m[1] == "HOME_SEQUENCE" else "%s = %r" % (m[1], float(m[2]) / 25.4), text)
    return rig.with_ini(text, "TRAJ", "LINEAR_UNITS", "inch")


DYNAMIC = re.compile(r"^\[+(axis\.\w\.(drive|friction|dynamic)|contour\.feedback|crosstalk)\]+\n([^\[].*\n|\n)*", re.M)


def geometry_alone(text):
    """Changes machine.toml: no dynamic correction."""
    return DYNAMIC.sub("", text)


def edited_tables(folder, machine, name, change, axis="x", description="machine.toml"):
    """Compiles a machine's tables after `change` of the text of one axis' CSV or, without an axis, of its description."""
    source = os.path.join(folder, name + ".tables")
    shutil.copytree(machine, source)
    rig.edit(source, axis + ".csv" if axis else description, change)
    compile_tables(folder, os.path.join(source, description), name + ".tcomp")


def scaled(factor):
    """Returns a change of a CSV that multiplies every error by a factor."""

    def change(text):
        lines = []
        for line in text.splitlines():
            fields = line.split(",")
            try:
                numbers = [float(field) for field in fields]
            except ValueError:
                lines.append(line)
            else:
                lines.append(",".join("%.6f" % v for v in [numbers[0]] + [factor * n for n in numbers[1:]]))
        return "\n".join(lines) + "\n"

    return change


def hal_of(letters, more=""):
    """Returns trueaxis.hal for other joints than X, Y, Z, with drives that follow their commands exactly."""
    with open(os.path.join(rig.CONFIG, "trueaxis.hal")) as f:
        text = f.read()
    start, end = text.index("net x-pos-cmd"), text.index("setp ta.enable 1")
    nets = ""
    for j, letter in enumerate(letters.lower()):
        name = "%s%d" % (letter, j)
        nets += "net {0}-pos-cmd joint.{1}.pos-cmd => ta.joint.{1}.pos-cmd\n".format(name, j)
        nets += "net {0}-motor joint.{1}.motor-pos-cmd => ta.joint.{1}.motor-pos-cmd-in\n".format(name, j)
        nets += "net {0}-motor-fb ta.joint.{1}.motor-pos-fb-out => joint.{1}.motor-pos-fb\n".format(name, j)
        nets += "net {0}-homed joint.{1}.homed => ta.joint.{1}.homed\n".format(name, j)
        nets += "net {0}-drive ta.joint.{1}.motor-pos-cmd-out => ta.joint.{1}.motor-pos-fb-in\n".format(name, j)
    return text[:start] + nets + text[end:] + more


AXIS = """
[AXIS_%(letter)s]
MIN_LIMIT = %(low)g
MAX_LIMIT = %(high)g
MAX_VELOCITY = %(velocity)g
MAX_ACCELERATION = %(acceleration)g
"""
JOINT = """
[JOINT_%(joint)d]
TYPE = %(type)s
HOME = 0
HOME_SEQUENCE = %(sequence)s
MAX_VELOCITY = %(velocity)g
MAX_ACCELERATION = %(acceleration)g
MIN_LIMIT = %(low)g
MAX_LIMIT = %(high)g
FERROR = 1.0
MIN_FERROR = 0.05
"""


def ini_of(letters, kinematics, travel):
    """Returns the sample's INI for other joints; `travel`: letter -> low, high."""
    with open(os.path.join(rig.CONFIG, "mill-3axis.ini")) as f:
        text = f.read()
    text = text[: text.index("[AXIS_X]")]
    text = rig.with_ini(text, "KINS", "KINEMATICS", kinematics)
    text = rig.with_ini(text, "KINS", "JOINTS", len(letters))
    text = rig.with_ini(text, "TRAJ", "COORDINATES", " ".join(letters))
    text = rig.with_ini(text, "TRUEAXIS", "JOINTS", letters)
    text = text.replace("HALFILE = drives.hal\n", "")
    for letter in sorted(set(letters), key=letters.index):
        low, high = travel[letter]
        facts = {"letter": letter, "low": low, "high": high, "acceleration": 2000,
                 "type": "ANGULAR" if letter in "ABC" else "LINEAR", "velocity": 90 if letter in "ABC" else 200}
        text += AXIS % facts
        places = [j for j, other in enumerate(letters) if other == letter]
        for j in places:
            text += JOINT % dict(facts, joint=j, sequence="-1" if len(places) > 1 else "0")
    return text


def narrow(text):
    """Changes the sample's INI to the travel of the machine `stream`."""
    for section in ("AXIS_X", "JOINT_0", "AXIS_Y", "JOINT_1"):
        text = rig.with_ini(text, section, "MIN_LIMIT", -195)
        text = rig.with_ini(text, section, "MAX_LIMIT", 195)
    for section in ("AXIS_Z", "JOINT_2"):
        text = rig.with_ini(text, section, "MIN_LIMIT", -195)
    return text
