# Corrects geometric errors at every step; see README.md.
#
# SPDX-License-Identifier: GPL-3.0-or-later
import logging
import os
import zlib

try:
    from klippy import chelper
except ImportError:  # Klipper's main line
    try:
        import chelper
    except ImportError:
        chelper = None
try:
    from . import homing
except ImportError:
    homing = None

XYZ = 7
PASSES = 8  # each brings two digits, since the slope is limited
HEADERS = ("itersolve.h", "trapq.h", "list.h")
# Calls that the extra makes. Both Klipper and Kalico have them. The extra registers no events for homing or motors,
# because those differ between the two.
HOST = {
    "chelper": ("get_ffi",),
    "homing.Homing": ("home_rails",),
    "toolhead": ("get_kinematics", "get_position", "set_position", "flush_step_generation", "drip_move"),
    "kinematics": ("get_steppers", "get_status", "calc_position", "home", "clear_homing_state"),
    "stepper": ("get_name", "get_step_dist", "get_commanded_position", "get_stepper_kinematics", "set_stepper_kinematics", "is_active_axis"),
    "rail": ("get_steppers", "get_endstops", "get_homing_info"),
}
CDEF = """
struct machine *trueaxis_shim_machine(void);
struct stepper_kinematics *trueaxis_shim_wrap(struct machine *machine, struct stepper_kinematics *inner);
void trueaxis_shim_active(struct stepper_kinematics *sk, int flags);
int trueaxis_shim_flags(struct stepper_kinematics *sk);
void trueaxis_shim_use(struct machine *m, struct tables *t);
void trueaxis_shim_correction(const struct machine *m, const double *p, double *c);
void trueaxis_shim_hold(struct machine *m, const double *p);
void trueaxis_shim_datum(struct machine *m, const struct tables *t, const double *probed);
void trueaxis_shim_inverse(const struct machine *m, const double *q, double *p);
void trueaxis_shim_free(struct tables *t);
struct tables *trueaxis_shim_load(const unsigned char *file, size_t length, unsigned machine_id, double max_correction,
    double max_slope, char *told, size_t told_size);
void trueaxis_shim_travel(const struct tables *t, double *low, double *high);
const char *trueaxis_shim_name(const struct tables *t);
unsigned trueaxis_shim_crc(const struct tables *t);
double trueaxis_shim_largest(const struct tables *t);
double trueaxis_shim_steepest(const struct tables *t);
unsigned trueaxis_shim_headers(void);
"""


class Refused(Exception):
    pass


class TrueAxis:
    def __init__(self, config):
        self.printer = config.get_printer()
        self.gcode = self.printer.lookup_object("gcode")
        self.file = config.get("tables")
        self.shim_file = os.path.expanduser(config.get("shim"))  # not in the extras folder: the host imports every file there
        self.machine_id = int(config.get("machine_id", "0"), 16)
        self.max_correction = config.getfloat("max_correction", 1.0, above=0.0)
        self.max_slope = config.getfloat("max_slope", 0.01, above=0.0, below=0.1)
        self.wanted = config.getboolean("enable", True)
        self.refused = self.note = None  # a line each: why the tables were refused; notes on those in use
        self.shim = self.machine = self.tables = None
        self.on = self.homing = self.switching = False
        self.probed = None
        self.set_to = [None] * 3, [None] * 3  # the last position set: as requested, and as passed on
        self.held = None  # during a probing move: the constant correction, and the axes that move
        self.wraps = []  # (stepper, original flags, wrap, original): cffi frees what nobody refers to
        register = self.printer.register_event_handler
        # Installed before [input_shaper] wraps the kinematics at klippy:connect: shaped positions are then corrected,
        # not corrected positions shaped.
        register("klippy:mcu_identify", self._install)
        register("klippy:ready", self._ready)
        for name in ("TRUEAXIS", "TRUEAXIS_LOAD", "TRUEAXIS_STATUS"):
            self.gcode.register_command(name, getattr(self, "cmd_" + name), desc=getattr(self, f"cmd_{name}_help"))

    def _install(self):
        try:
            self._meet_host()
            self._open_shim()
            if getattr(self.kin, "dc_module", None) is not None:
                raise Refused("one set of tables cannot serve two carriages")
        except Refused as e:
            self.refused = str(e)
            return
        except Exception as e:
            logging.exception("trueaxis")
            self.refused = f"the extra does not support this version of the host ({type(e).__name__}: {e})"
            return
        # Wrap the kinematics even without tables, which changes no step, because tables may be loaded later.
        try:
            self.tables, self.note = self._read(self.file)
        except Refused as e:
            self.refused = str(e)
        for stepper in self.kin.get_steppers():
            self._wrap(stepper)
        self.kin_calc_position, self.kin_home, self.kin_clear = self.kin.calc_position, self.kin.home, self.kin.clear_homing_state
        self.kin.calc_position, self.kin.home, self.kin.clear_homing_state = self._calc_position, self._home, self._clear
        self.host_set_position, self.host_drip_move = self.toolhead.set_position, self.toolhead.drip_move
        self.toolhead.set_position, self.toolhead.drip_move = self._set_position, self._drip_move

    def _meet_host(self):
        """Refuses a host that lacks a call of HOST."""

        def needs(kind, found):
            missing = [name for name in HOST[kind] if not callable(getattr(found, name, None))]
            if missing:
                raise Refused(f"this version of the host has no {kind}.{missing[0]}, which the extra calls")

        needs("chelper", chelper)
        needs("homing.Homing", getattr(homing, "Homing", None))
        self.toolhead = self.printer.lookup_object("toolhead", None)
        needs("toolhead", self.toolhead)
        self.kin = self.toolhead.get_kinematics()
        needs("kinematics", self.kin)
        status = self.kin.get_status(self.printer.get_reactor().monotonic())
        for name in ("homed_axes", "axis_minimum", "axis_maximum"):
            if name not in status:
                raise Refused(f"this version of the host has no {name} in its kinematics' status, which the extra reads")
        for rail in getattr(self.kin, "rails", ()):
            needs("rail", rail)
        for stepper in self.kin.get_steppers():
            needs("stepper", stepper)

    def _open_shim(self):
        self.ffi, self.host = chelper.get_ffi()
        crc = 0
        try:
            for name in HEADERS:
                with open(os.path.join(os.path.dirname(chelper.__file__), name), "rb") as header:
                    crc = zlib.crc32(header.read(), crc)
            self.ffi.cdef(CDEF, override=True)  # RESTART keeps the process and its ffi
            self.shim = self.ffi.dlopen(self.shim_file)
        except OSError as e:
            raise Refused(f"{self.shim_file}: {e}")
        if self.shim.trueaxis_shim_headers() != crc:
            raise Refused(f"{self.shim_file} was built for another version of the host, needed: build.sh run again")
        self.machine = self.ffi.gc(self.shim.trueaxis_shim_machine(), self.host.free)

    def _wrap(self, stepper):
        original = stepper.get_stepper_kinematics()
        flags = self.shim.trueaxis_shim_flags(original)
        wrap = self.ffi.gc(self.shim.trueaxis_shim_wrap(self.machine, original), self.host.free)
        stepper.set_stepper_kinematics(wrap)
        # The input shaper copies the kinematics that it finds, so set the active axes here too. The outermost wrapper
        # gets its own when the machine is ready.
        self.shim.trueaxis_shim_active(wrap, XYZ)
        # A caller that asks for a rail's axis means the mechanics, not the correction.
        stepper.is_active_axis = lambda axis: bool(flags & (1 << "xyz".index(axis)))
        self.wraps.append((stepper, flags, wrap, original))

    def _read(self, path):
        try:
            with open(os.path.expanduser(path), "rb") as file:
                data = file.read()
        except OSError as e:
            raise Refused(f"{path}: {e.strerror}")
        told = self.ffi.new("char[512]")
        found = self.shim.trueaxis_shim_load(data, len(data), self.machine_id, self.max_correction, self.max_slope, told, 512)
        if found == self.ffi.NULL:
            raise Refused(f"{path}: {self.ffi.string(told).decode()}")
        tables = self.ffi.gc(found, self.shim.trueaxis_shim_free)
        low, high = self.ffi.new("double[3]"), self.ffi.new("double[3]")
        self.shim.trueaxis_shim_travel(tables, low, high)
        status = self.kin.get_status(self.printer.get_reactor().monotonic())
        short = []
        for i, axis in enumerate("XYZ"):
            mine = status["axis_minimum"][i], status["axis_maximum"][i]
            if high[i] <= low[i]:
                continue
            if high[i] <= mine[0] or low[i] >= mine[1]:
                raise Refused(f"{path}: the tables' travel of {axis}, {low[i]:g} to {high[i]:g} mm, has nothing in common "
                              f"with the machine's, {mine[0]:g} to {mine[1]:g} mm")
            if low[i] > mine[0] or high[i] < mine[1]:
                short.append(f"{axis} {low[i]:g} to {high[i]:g} of {mine[0]:g} to {mine[1]:g} mm")
        return tables, "the tables cover " + ", ".join(short) + "; beyond, their value at the end holds" if short else None

    def _ready(self):
        for stepper, flags, _, _ in self.wraps:
            self.shim.trueaxis_shim_active(stepper.get_stepper_kinematics(), flags)
        if self.refused:
            line = f"trueaxis: {self.refused}; running uncompensated"
            warn = getattr(self.printer.lookup_object("configfile"), "runtime_warning", logging.warning)
            warn(line)
            self.gcode.respond_raw("!! " + line)
        else:
            self.gcode.respond_info(f"trueaxis: {self._name()}, uncompensated until homed")
            self._tell_note()

    def _name(self):
        return self.ffi.string(self.shim.trueaxis_shim_name(self.tables)).decode()

    def _tell_note(self):
        if self.note:
            logging.info("trueaxis: %s", self.note)
            self.gcode.respond_info(f"trueaxis: {self.note}")

    # Positions
    def _inverse(self, q):
        p = self.ffi.new("double[3]")
        self.shim.trueaxis_shim_inverse(self.machine, list(q)[:3], p)
        return list(p)

    def _calc_position(self, stepper_positions):
        q = self.kin_calc_position(stepper_positions)
        p = self._inverse(self._filled(q))
        return [None if there is None else at for at, there in zip(p, q)] + list(q[3:])

    def _filled(self, q):
        # Klipper's main line returns None for an axis without a motor.
        return [at if there is None else there for there, at in zip(q, self.toolhead.get_position()[:3])]

    def _motors(self):
        """Returns the motors' positions, transformed to axes; None for an axis without a motor."""
        return list(self.kin_calc_position({s.get_name(): s.get_commanded_position() for s in self.kin.get_steppers()}))[:3]

    def _correction(self, p):
        c = self.ffi.new("double[3]")
        self.shim.trueaxis_shim_correction(self.machine, list(p)[:3], c)
        return list(c)

    def _set_position(self, newpos, *rest, **named):
        if self.on and not self.switching:
            self.toolhead.flush_step_generation()
            newpos = self._without_others(list(newpos))
        # Every stepper gets a new position and keeps its steps, so a held correction can be released.
        self._let_go()
        self.host_set_position(newpos, *rest, **named)
        self._follow()

    def _without_others(self, newpos):
        """Returns the position that gives the axes being set their new values and keeps the motors of the others in place.

        An axis is being set if its value differs from the current one, or if a probing move has moved it. A repeated request
        for an axis that has not moved since is not a new value: Z_TILT_ADJUST reuses the position it passed before.
        """
        at = self.toolhead.get_position()
        c, moved = self.held or (self._correction(at), ())
        q, coarsest = self._motors(), max(s.get_step_dist() for s in self.kin.get_steppers())
        others, (requested, passed_on) = {}, self.set_to
        for i in range(3):
            same = newpos[i] == at[i] or (newpos[i], at[i]) == (requested[i], passed_on[i])
            if same and i not in moved and q[i] is not None:
                # The motor is at a whole step. If it is further off than that, it is not following the axis at present.
                planned = at[i] + c[i]
                others[i] = q[i] if abs(q[i] - planned) <= coarsest else planned
        p = newpos[:3]
        for _ in range(PASSES if others else 0):
            c = self._correction(p)
            p = [others[i] - c[i] if i in others else newpos[i] for i in range(3)]
        self.set_to = newpos[:3], p
        return p + newpos[3:]

    def _reread(self, change):
        """Makes a change at standstill: the motors keep their steps, and the position is read again."""
        self.switching = True
        try:
            self.toolhead.flush_step_generation()
            q = self._filled(self._motors())
            change()
            self.toolhead.set_position(self._inverse(q) + self.toolhead.get_position()[3:])
        finally:
            self.switching = False

    def _datum(self):
        probed = self.ffi.NULL if self.probed is None else self.ffi.new("double[3]", self.probed)
        self.shim.trueaxis_shim_datum(self.machine, self.tables, probed)

    def _switch(self, on, tables=None):
        if on == self.on and tables is None:
            return

        def change():
            self.tables = tables or self.tables
            self.on = on
            self._datum()
            self.shim.trueaxis_shim_use(self.machine, self.tables if on else self.ffi.NULL)
            for stepper, flags, _, _ in self.wraps:
                self.shim.trueaxis_shim_active(stepper.get_stepper_kinematics(), XYZ if on else flags)

        self._reread(change)
        self.gcode.respond_info("trueaxis: correction " + ("on" if on else "off"))

    def _homed(self):
        status = self.kin.get_status(self.printer.get_reactor().monotonic())
        return set("xyz") <= set(status["homed_axes"])

    def _follow(self):
        if self.tables and not self.homing and not self.switching:
            self._switch(self.wanted and self._homed())

    # Homing, probing, motors off. These wrap methods, since the events differ between versions.
    def _home(self, homing_state):
        home_rails = homing_state.home_rails

        def noted(rails, *rest, **named):
            found = home_rails(rails, *rest, **named)
            for rail in rails:
                if rail.get_steppers()[0].is_active_axis("z"):
                    # A probe measures the tool, an endstop the drive.
                    by_probe = any(hasattr(endstop, "get_position_endstop") for endstop, _ in rail.get_endstops())
                    # The tool may have been lifted since it touched.
                    touched = self.toolhead.get_position()[:2] + [rail.get_homing_info().position_endstop]
                    self.probed = touched if by_probe else None
            return found

        homing_state.home_rails = noted
        self.homing = True
        try:
            self._switch(False)
            self.kin_home(homing_state)
        finally:
            self.homing = False
        self._follow()

    def _clear(self, *axes, **named):
        self.kin_clear(*axes, **named)
        self._follow()

    def _drip_move(self, newpos, *rest, **named):
        if self.on:
            # No move is pending: the host flushes before it arms the endstop.
            at = self.toolhead.get_position()
            self.held = self._correction(at), [i for i in range(3) if newpos[i] != at[i]]
            self.shim.trueaxis_shim_hold(self.machine, at[:3])
        self.host_drip_move(newpos, *rest, **named)

    def _let_go(self):
        self.held = None
        self.shim.trueaxis_shim_hold(self.machine, self.ffi.NULL)

    # Commands
    def _needed(self, gcmd, found):
        if not found:
            restart = "" if self.wraps else "; needed: a restart of the host"
            raise gcmd.error(f"trueaxis: {self.refused}; running uncompensated{restart}")

    cmd_TRUEAXIS_help = "Switch the correction: ENABLE=0 or 1"

    def cmd_TRUEAXIS(self, gcmd):
        self._needed(gcmd, self.tables)
        self.wanted = bool(gcmd.get_int("ENABLE", minval=0, maxval=1))
        self._follow()

    cmd_TRUEAXIS_LOAD_help = "Load other tables: FILE=name.tcomp"

    def cmd_TRUEAXIS_LOAD(self, gcmd):
        self._needed(gcmd, self.wraps)
        path = gcmd.get("FILE")
        try:
            tables, self.note = self._read(path)
        except Refused as e:
            raise gcmd.error(f"trueaxis: {e}; " + ("the tables stay as they are" if self.tables else "running uncompensated"))
        self.file, self.refused = path, None
        self._switch(self.wanted and self._homed(), tables)
        self._tell_note()

    cmd_TRUEAXIS_STATUS_help = "Show the tables, and the correction at the tool's position"

    def cmd_TRUEAXIS_STATUS(self, gcmd):
        self._needed(gcmd, self.tables)
        status = self.get_status(None)
        gcmd.respond_info("trueaxis: %s, %s, correction %s mm" % (
            status["tables"], "on" if self.on else "off", " ".join("%.5f" % c for c in status["correction"])))

    def get_status(self, eventtime):
        if not self.tables:
            return {"on": False, "enabled": self.wanted, "refused": self.refused}
        return {"on": self.on, "enabled": self.wanted, "file": self.file, "tables": self._name(),
                "correction": self._correction(self.toolhead.get_position()),
                "crc": "%08x" % self.shim.trueaxis_shim_crc(self.tables), "refused": None}


def load_config(config):
    return TrueAxis(config)
