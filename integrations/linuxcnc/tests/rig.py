"""Runs LinuxCNC or halrun in a separate directory, with a time limit."""
import os
import re
import shutil
import signal
import subprocess

HERE = os.path.dirname(os.path.realpath(__file__))
CONFIG = os.path.join(HERE, "..", "config")
MACHINES = os.path.join(HERE, "..", "machines")


class Broken(AssertionError):
    pass


def expect(condition, what, *details):
    if not condition:
        raise Broken(what + "".join("\n    %s" % (d,) for d in details))


def environment(home, **more):
    env = {"HOME": home, "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"}
    env.update(more)
    return env


# Time limits only end programs that hang. They fit an idle computer; this factor allows for a busy one.
PATIENCE = 5


def run(words, folder, seconds, **more):
    """Runs a program in a separate session and ends the whole session at the time limit."""
    seconds *= PATIENCE
    process = subprocess.Popen(words, cwd=folder, env=environment(folder, **more), stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                               start_new_session=True)
    try:
        text, _ = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGTERM)
        try:
            text, _ = process.communicate(timeout=10)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            text, _ = process.communicate()
        raise Broken("%s took more than %g s" % (words[0], seconds), text)
    return process.returncode, text


def halrun(folder, text, seconds=30):
    """Runs a HAL file; returns its exit code and output."""
    with open(os.path.join(folder, "run.hal"), "w") as f:
        f.write(text)
    return run(["halrun", "-f", "run.hal"], folder, seconds)


def with_ini(text, section, key, value):
    """Returns an INI file with one key changed or added; the value None removes the key."""
    head = re.search(r"^\[%s\]\s*$" % re.escape(section), text, re.M)
    line = "" if value is None else "%s = %s\n" % (key, value)
    if head is None:
        return text + "\n[%s]\n%s" % (section, line)
    end = re.compile(r"^\[", re.M).search(text, head.end())
    end = end.start() if end else len(text)
    body = text[head.end() : end]
    changed, times = re.subn(r"^%s\s*=.*\n" % re.escape(key), lambda _: line, body, count=1, flags=re.M)
    if not times:
        changed = body.rstrip("\n") + "\n" + line + "\n"
    return text[: head.end()] + changed + text[end:]


def linuxcnc(folder, ini, scenario, seconds=75):
    """Runs a configuration with the pilot in place of a user interface, until the scenario ends."""
    path = os.path.join(folder, ini)
    with open(path) as f:
        text = f.read()
    text = with_ini(text, "DISPLAY", "DISPLAY", os.path.join(HERE, "pilot.py"))
    with open(path, "w") as f:
        f.write(text)
    code, printed = run(["linuxcnc", "-r", ini], folder, seconds, TRUEAXIS_SCENARIO=scenario,
                        TRUEAXIS=os.environ.get("TRUEAXIS", "trueaxis"))
    if not os.path.exists(os.path.join(folder, "done")):
        raise Broken("the scenario %s did not end (exit code %d)" % (scenario, code), printed[-6000:])
    return printed


def copy(folder, source, *names):
    for name in names:
        shutil.copy(os.path.join(source, name), folder)


def edit(folder, name, change):
    path = os.path.join(folder, name)
    with open(path) as f:
        text = f.read()
    with open(path, "w") as f:
        f.write(change(text))
