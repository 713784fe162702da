# Geometric errors corrected at every step; see README.md.
#
# SPDX-License-Identifier: GPL-3.0-or-later
import logging
import os
import zlib

try:
    from klippy import chelper
except ImportError:  # mainline Klipper
    import chelper

XYZ = 7
HEADERS = ("itersolve.h", "trapq.h", "list.h")
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
        self.shim_file = os.path.expanduser(config.get("shim"))  # not in the extras folder: the host imports what lies there
        self.machine_id = int(config.get("machine_id", "0"), 16)
        self.max_correction = config.getfloat("max_correction", 1.0, above=0.0)
        self.max_slope = config.getfloat("max_slope", 0.01, above=0.0, below=0.1)
        self.wanted = config.getboolean("enable", True)
        self.refused = self.note = None  # a line each: why there are no tables; what to know of those there are
        self.shim = self.machine = self.tables = None
        self.on = self.homing = self.switching = False
        self.probed = None
        self.wraps = []  # (stepper, original flags, wrap, original): cffi frees what nobody refers to
        register = self.printer.register_event_handler
        # Before [input_shaper] wraps at klippy:connect: shaped positions are corrected, not corrected ones shaped.
        register("klippy:mcu_identify", self._install)
        register("klippy:ready", self._ready)
        register("homing:home_rails_begin", self._home_begin)
        register("homing:home_rails_end", self._home_end)
        register("homing:homing_move_begin", self._hold)
        register("homing:homing_move_end", self._let_go)
        register("stepper_enable:motor_off", self._motor_off)
        register("toolhead:set_position", self._follow)
        for name in ("TRUEAXIS", "TRUEAXIS_LOAD", "TRUEAXIS_STATUS"):
            self.gcode.register_command(name, getattr(self, "cmd_" + name), desc=getattr(self, f"cmd_{name}_help"))

    def _install(self):
        self.toolhead = self.printer.lookup_object("toolhead")
        self.kin = self.toolhead.get_kinematics()
        try:
            self._open_shim()
            if getattr(self.kin, "dc_module", None) is not None:
                raise Refused("one set of tables cannot serve two carriages")
        except Refused as e:
            self.refused = str(e)
            return
        # Wrapped without tables too, which changes no step: others may be loaded later.
        try:
            self.tables, self.note = self._read(self.file)
        except Refused as e:
            self.refused = str(e)
        for stepper in self.kin.get_steppers():
            self._wrap(stepper)
        self.kin_calc_position, self.kin_set_position = self.kin.calc_position, self.kin.set_position
        self.kin.calc_position, self.kin.set_position = self._calc_position, self._set_position

    def _open_shim(self):
        self.ffi, self.host = chelper.get_ffi()
        crc = 0
        for name in HEADERS:
            with open(os.path.join(os.path.dirname(chelper.__file__), name), "rb") as header:
                crc = zlib.crc32(header.read(), crc)
        try:
            self.ffi.cdef(CDEF)
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
        # For the input shaper, which copies what it finds; the outermost gets its own when the machine is ready.
        self.shim.trueaxis_shim_active(wrap, XYZ)
        # Who asks for a rail's axis means the mechanics, not the correction.
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
        q = list(self.kin_calc_position(stepper_positions))
        if None in q[:3]:  # mainline Klipper, of an axis that has no motor
            return q
        return self._inverse(q) + q[3:]

    def _set_position(self, newpos, homing_axes=""):
        # All steppers are set anew, steps kept: what a probing move held may go.
        self.shim.trueaxis_shim_hold(self.machine, self.ffi.NULL)
        self.kin_set_position(newpos, homing_axes)

    def _reread(self, change):
        """Makes a change at standstill: motors keep their steps, the position is read anew."""
        self.switching = True
        try:
            self.toolhead.flush_step_generation()
            q = self.kin_calc_position({s.get_name(): s.get_commanded_position() for s in self.kin.get_steppers()})
            change()
            position = self.toolhead.get_position()
            q = [there if at is None else at for at, there in zip(q, position)]
            self.toolhead.set_position(self._inverse(q) + position[3:])
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

    # Homing and probing
    def _home_begin(self, homing_state, rails):
        if self.wraps:
            self.homing = True
            self._switch(False)

    def _home_end(self, homing_state, rails):
        if not self.wraps:
            return
        for rail in rails:
            if rail.get_steppers()[0].is_active_axis("z"):
                # A probe finds the tool, an endstop the drive.
                by_probe = any(hasattr(endstop, "get_position_endstop") for endstop, _ in rail.get_endstops())
                # The tool may have been lifted since.
                touched = self.toolhead.get_position()[:2] + [rail.get_homing_info().position_endstop]
                self.probed = touched if by_probe else None
        self.homing = False
        self._follow()

    def _hold(self, homing_move):
        if self.on:
            self.toolhead.flush_step_generation()
            self.shim.trueaxis_shim_hold(self.machine, self.toolhead.get_position()[:3])

    def _let_go(self, homing_move):
        if self.on:
            self._reread(lambda: self.shim.trueaxis_shim_hold(self.machine, self.ffi.NULL))

    def _motor_off(self, print_time):
        if self.wraps:
            self.homing = False
            self._switch(False)

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

    cmd_TRUEAXIS_STATUS_help = "Tell the tables and the correction where the tool stands"

    def cmd_TRUEAXIS_STATUS(self, gcmd):
        self._needed(gcmd, self.tables)
        status = self.get_status(None)
        gcmd.respond_info("trueaxis: %s, %s, correction %s mm" % (
            status["tables"], "on" if self.on else "off", " ".join("%.5f" % c for c in status["correction"])))

    def get_status(self, eventtime):
        if not self.tables:
            return {"on": False, "enabled": self.wanted, "refused": self.refused}
        c = self.ffi.new("double[3]")
        self.shim.trueaxis_shim_correction(self.machine, self.toolhead.get_position()[:3], c)
        return {"on": self.on, "enabled": self.wanted, "file": self.file, "tables": self._name(), "correction": list(c),
                "crc": "%08x" % self.shim.trueaxis_shim_crc(self.tables), "refused": None}


def load_config(config):
    return TrueAxis(config)
