#!/usr/bin/env python3
"""Writes python/trueaxis/_types.py, the types of results, from the Rust types of the documents.

    document_types.py            writes the file
    document_types.py --check    fails where it is not what the sources give

A field that is a document gets its own type; a field of any other type that is not simple becomes `Any`.
"""

import keyword
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

HERE = Path(__file__).resolve().parent
TARGET = HERE / "python/trueaxis/_types.py"
CRATES = HERE.parent
EVALUATION = "trueaxis-evaluation/src"
# Types of the package: name, function that returns it, Rust file and type, fields that only Python has.
WRITTEN = ("written", "tuple[Section, ...]", "Decision on every value found, if a machine is given: key, old, found, written, why.")
ARRAYS = [(name, "NDArray[np.float64]", f"{what}, µm: one row a revolution.")
          for name, what in (("profile_um", "Profile"), ("rx_um", "Error motion across probe 1"), ("ry_um", "Error motion along probe 1"))]
TRACES = [("angle_deg", "NDArray[np.float64]", "Angle of every reading, with `traces=True`."),
          ("direction", "NDArray[np.float64]", "1 counterclockwise, -1 clockwise, with `traces=True`."),
          ("centred_um", "NDArray[np.float64]", "Deviation about the circle's centre, with `traces=True`."),
          ("left_um", "NDArray[np.float64]", "Residual of the causes, with `traces=True`.")]
FILES = ("files", "Section", "Changed files of the machine as texts, by name, with `files=True`.")
TOML = ("toml", "str", "Text of the settings found, with `toml=True`.")
TRACE = [("theta_deg", "NDArray[np.float64]", "Angles of the trace, of `trace_roundness`."),
         ("radius_mm", "NDArray[np.float64]", "Radii of the trace as filtered, of `trace_roundness`.")]
RESIDUALS = ("residuals_um", "NDArray[np.float64]", "Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.")
PROGRAM = ("program_text", "str", "Text of the program.")
RESULTS = [
    ("Circle", "circle, trace_roundness", f"{EVALUATION}/circle/mod.rs", "CircleDocument", TRACE),
    ("Roundness", "roundness", f"{EVALUATION}/roundness/document.rs", "RoundnessDocument", ARRAYS),
    ("ProbeAngles", "probe_angles", f"{EVALUATION}/probe_angles.rs", "ProbeAnglesDocument", []),
    ("Accuracy", "accuracy", f"{EVALUATION}/accuracy/mod.rs", "AccuracyDocument", []),
    ("Ballbar", "ballbar", f"{EVALUATION}/ballbar/document.rs", "BallbarDocument", [WRITTEN, *TRACES]),
    ("Identification", "identify", f"{EVALUATION}/identify/document.rs", "IdentificationDocument",
     [WRITTEN, ("table", "str", "The axis' table as CSV text, with `table=True`."), RESIDUALS]),
    ("Friction", "friction", f"{EVALUATION}/friction/document.rs", "FrictionDocument",
     [WRITTEN, TOML, RESIDUALS, ("residuals_t_s", "NDArray[np.float64]", "Times of the residuals, with `residuals=True`.")]),
    ("ThermalFit", "thermal_fit", f"{EVALUATION}/thermal/document.rs", "ThermalDocument", [TOML, RESIDUALS]),
    ("Calibration", "calibrate_solve", f"{EVALUATION}/calibrate/document.rs", "CalibrationDocument", [WRITTEN, FILES, RESIDUALS]),
    ("CalibrationPlan", "calibrate_plan", f"{EVALUATION}/calibrate/foreseen.rs", "Foreseen", [PROGRAM]),
    ("KeepPlan", "keep_plan", f"{EVALUATION}/keep/foreseen.rs", "Foreseen", [PROGRAM]),
    ("Reprobing", "keep_begin, keep_check, keep_apply", f"{EVALUATION}/keep/document.rs", "ReprobingDocument",
     [("changes", "tuple[str, ...]", "A sentence on each change."), FILES]),
    ("Probing", "evaluate_probing", f"{EVALUATION}/probing/document.rs", "ProbingDocument", []),
    ("ThermalTest", "evaluate_thermal", f"{EVALUATION}/thermal_test/document.rs", "ThermalTestDocument", []),
    ("StepDiagonal", "evaluate_step_diagonal", f"{EVALUATION}/diagonal/document.rs", "DiagonalDocument", [WRITTEN]),
    ("RTest", "evaluate_r_test", f"{EVALUATION}/r_test/document.rs", "RTestDocument", [WRITTEN, RESIDUALS]),
    ("MeasuredPoints", "evaluate_points", f"{EVALUATION}/points/document.rs", "PointsDocument", [RESIDUALS]),
    ("MeasuredPlane", "evaluate_points", f"{EVALUATION}/points/plane/document.rs", "PlaneDocument", [RESIDUALS]),
    ("Uncertainty", "Machine.uncertainty", f"{EVALUATION}/uncertainty/document.rs", "UncertaintyDocument", []),
    ("PredictedPart", "predict", f"{EVALUATION}/predict/document.rs", "PredictDocument", []),
    ("Helicoid", "helicoid", f"{EVALUATION}/helicoid/document.rs", "HelicoidDocument",
     [("program", "str", "Text of the program, with `gcode=True`.")]),
    ("Learned", "learn", f"{EVALUATION}/learn/document.rs", "LearnDocument",
     [("table", "bytes", "Content of the .tlearn for the next part.")]),
    ("Transfer", "import_table, export_table", f"{EVALUATION}/transfer.rs", "TransferDocument", []),
    ("Run", "simulate", "trueaxis-sim/src/run/document.rs", "RunDocument",
     [("trace", "Section", "Columns of the traces by machine, with `trace_every`.")]),
]
# Bases of the types that have more than fields.
BASES = {"PredictedPart": "Budgeted"}
PLAIN = {"f64": "float", "f32": "float", "bool": "bool", "String": "str", "&'static str": "str", "Axis": "str", "char": "str", "PathBuf": "str"}
PLAIN |= {name: "int" for name in ("usize", "isize", "u8", "u16", "u32", "u64", "i8", "i16", "i32", "i64")}
HEAD = '''\
"""Types of the results. document_types.py writes this file from the documents of the command line."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._results import Budgeted, Result, Section
'''


@dataclass
class Field:
    name: str
    rust: str
    doc: str
    flat: bool = False


@dataclass
class Type:
    file: Path
    name: str
    doc: str
    fields: list = field(default_factory=list)
    words: bool = False


def types_of(file):
    """Serialised structs and enums of a Rust file, by name."""
    found, doc, serialised, lines = {}, [], False, iter(file.read_text().splitlines())
    for line in lines:
        if line.startswith("/// "):
            doc.append(line[4:])
        elif line.startswith("#["):
            serialised |= line.startswith("#[derive(") and "Serialize" in line
        else:
            declared = re.match(r"pub (struct|enum) (\w+)(?:<.*>)? \{$", line)
            if declared and serialised:
                body = []
                for inner in lines:
                    if inner == "}":
                        break
                    body.append(inner.strip())
                own = Type(file, declared[2], " ".join(doc))
                own.words = declared[1] == "enum" and all(re.match(r"(///|#|\w+,)", inner) for inner in body)
                if declared[1] == "struct":
                    own.fields = fields_of(body)
                found[own.name] = own
            doc, serialised = [], False
    return found


def fields_of(body):
    fields, doc, renamed, flat, skip = [], [], None, False, False
    for line in body:
        if line.startswith("/// "):
            doc.append(line[4:])
        elif line.startswith("#[serde("):
            renamed = (re.search(r'rename = "(\w+)"', line) or [None, None])[1] or renamed
            flat |= "flatten" in line
            skip |= re.search(r"\bskip\b[,)]", line) is not None
        elif declared := re.match(r"(?:pub )?(?:r#)?(\w+): (.*),$", line):
            if not skip:
                fields.append(Field(renamed or declared[1], declared[2], " ".join(doc), flat))
            doc, renamed, flat, skip = [], None, False, False
    return fields


class Sources:
    """All serialised types of the crates; a name is looked for in the file, then in its folder and those above, then everywhere."""

    def __init__(self):
        self.all = {}
        for crate in ("trueaxis-evaluation", "trueaxis-metrology", "trueaxis-sim", "trueaxis-tables"):
            for file in sorted((CRATES / crate / "src").rglob("*.rs")):
                for own in types_of(file).values():
                    self.all.setdefault(own.name, []).append(own)

    def find(self, name, beside):
        known = self.all.get(name, [])
        above = ([of for of in known if of.file.parent == folder] for folder in beside.parents)
        for near in ([of for of in known if of.file == beside], *above, known):
            if len(near) == 1:
                return near[0]
        return None


class Writer:
    def __init__(self):
        self.sources, self.text, self.named = Sources(), [], {}

    def python(self, rust, file, owner):
        """The Python type of a Rust type, and the type of the package that its sections have."""
        rust = rust.strip()
        if rust in PLAIN:
            return PLAIN[rust], None
        if of := re.fullmatch(r"Option<(.*)>", rust):
            inner, section = self.python(of[1], file, owner)
            return inner if inner == "Any" else f"{inner} | None", section
        if of := re.fullmatch(r"(?:Vec<(.*)>|\[(.*); \w+\])", rust):
            inner, section = self.python(of[1] or of[2], file, owner)
            if inner in ("float", "int"):
                return f"NDArray[np.{'float64' if inner == 'float' else 'int64'}]", None
            return f"tuple[{inner}, ...]", section
        # Settings are keys of a file, and need no types here.
        if re.match(r"(BTreeMap|HashMap|Map)<", rust) or rust in ("Pair", "Settings"):
            return "Section", None
        own = self.sources.find(rust.split("::")[-1], file) if re.fullmatch(r"[\w:]+", rust) else None
        if own is None:
            return "Any", None
        if own.words:
            return "str", None
        if not own.fields:
            return "Any", None
        name = self.section(own, owner)
        return name, name

    def section(self, own, owner):
        key = (own.file, own.name)
        if key not in self.named:
            name = own.name.removesuffix("Document")
            taken = set(self.named.values()) | {result[0] for result in RESULTS}
            self.named[key] = name if name not in taken else owner + name
            self.write(self.named[key], "Section", own, [], own.doc)
        return self.named[key]

    def rows(self, own, owner):
        for of in own.fields:
            inner = self.sources.find(of.rust.removeprefix("Option<").removesuffix(">"), own.file) if of.flat else None
            if inner:
                absent = " | None" if of.rust.startswith("Option<") else ""
                for name, kind, doc, section in self.rows(inner, owner):
                    yield name, kind if kind.endswith("None") else kind + absent, doc, section
            elif not of.flat:
                kind, section = self.python(of.rust, own.file, owner)
                yield of.name + "_" * keyword.iskeyword(of.name), kind, of.doc, section

    def write(self, name, base, own, more, doc):
        rows = [*self.rows(own, name), *((key, kind, text, None) for key, kind, text in more)]
        lines = ["", "", f"class {name}({base}):", f'    """{doc}', "", "    Attributes", "    ----------"]
        for key, kind, text, _ in rows:
            lines += [f"    {key} : {kind}", f"        {text}"]
        lines += ['    """', "", "    __slots__ = ()"]
        sections = {key: section for key, _, _, section in rows if section}
        lines += ["    _sections: ClassVar[dict[str, type[Section]]] = {" + ", ".join(f'"{key}": {of}' for key, of in sections.items()) + "}"]
        lines += [f"    {key}: {kind}" for key, kind, _, _ in rows]
        self.text.append("\n".join(lines) + "\n")

    def all(self):
        for name, function, file, rust, more in RESULTS:
            own = types_of(CRATES / file)[rust]
            of = ", ".join(f"`{one}`" for one in function.split(", "))
            self.write(name, BASES.get(name, "Result"), own, more, f"Result of {of}.")
        names = ", ".join(f'"{name}"' for name, *_ in RESULTS)
        return HEAD + "".join(self.text) + f"\n\n__all__ = [{names}]\n"


def main():
    needed = Writer().all()
    if sys.argv[1:] == ["--check"]:
        if TARGET.read_text() != needed:
            sys.exit(f"{TARGET}: found other types than the sources give, needed those of document_types.py")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        TARGET.write_text(needed)


main()
