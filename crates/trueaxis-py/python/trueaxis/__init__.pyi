from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path as _Path
from typing import Any, ClassVar, Literal, Protocol, TypedDict, final, type_check_only

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._propagate import Propagated as Propagated, propagate as propagate
from ._results import Figure as Figure, Result as Result, Section as Section
from ._types import *

__all__ = ["Error", "NeedsPerson", "Machine", "Path", "Program", "helicoid", "identify", "friction", "ballbar", "calibrate_plan", "calibrate_solve", "keep_plan", "keep_begin", "keep_check", "keep_apply", "keep_undo", "keep_history", "thermal_fit", "evaluate_probing", "evaluate_thermal", "evaluate_step_diagonal", "evaluate_r_test", "evaluate_points", "circle", "roundness", "probe_angles", "simulate", "accuracy", "thermal_compile", "learn", "predict", "import_table", "export_table", "trace_roundness", "__version__", "Figure", "Result", "Section", "Propagated", "propagate", "Circle", "Roundness", "ProbeAngles", "Accuracy", "Ballbar", "Identification", "Friction", "ThermalFit", "Calibration", "CalibrationPlan", "KeepPlan", "Reprobing", "Probing", "ThermalTest", "StepDiagonal", "RTest", "MeasuredPoints", "MeasuredPlane", "Uncertainty", "PredictedPart", "Helicoid", "Learned", "Transfer", "Run"]

__version__: str

class Error(ValueError):
    """Refused input: place, value found and value needed, in the words of the command line."""

class NeedsPerson(Error):
    """A term of a re-probing is out of its bounds: nothing is changed, and a person has to decide; exit code 3 of `trueaxis keep`."""

@type_check_only
class Frame(Protocol):
    """A data frame: columns by name, as of pandas or Polars."""

    @property
    def columns(self) -> Any: ...
    def __getitem__(self, name: Any, /) -> Any: ...

@type_check_only
class Readable(Protocol):
    """An open file, of text or bytes."""

    def read(self) -> str | bytes: ...

@type_check_only
class ContourError(TypedDict):
    """Columns of `trueaxis contour`; vector_um has the shape (n, 3) and is actual − foot."""

    segment: NDArray[np.uint32]
    u: NDArray[np.float64]
    error_um: NDArray[np.float64]
    vector_um: NDArray[np.float64]
    evaluations: NDArray[np.uint32]
    bracketed: NDArray[np.bool_]

@final
class Machine:
    """A machine with its tables, read and checked."""

    @staticmethod
    def load(path: str | PathLike[str]) -> Machine: ...
    @property
    def name(self) -> str: ...
    @property
    def chain(self) -> str: ...
    @property
    def model(self) -> str: ...
    @property
    def columns(self) -> list[str]: ...
    def table(self, axis: Literal["X", "Y", "Z", "A", "B", "C"]) -> dict[str, NDArray[np.float64]]: ...
    def with_table(self, axis: Literal["X", "Y", "Z", "A", "B", "C"], table: Mapping[str, ArrayLike] | Frame) -> Machine: ...
    def with_setting(self, key: str, value: float | bool | str | Sequence[float] | None) -> Machine: ...
    def save(self, folder: str | PathLike[str] | None = None) -> list[_Path]: ...
    def compile(self, *, rate_hz: float = 10000.0) -> bytes: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def error(
        self,
        positions: ArrayLike | Frame,
        *,
        model: Literal["nine", "volumetric", "exact"] | None = None,
        reverse: bool = False,
        in_order: bool = False,
        temperature_c: float | None = None,
    ) -> NDArray[np.float64]: ...
    def orientation_error(
        self,
        positions: ArrayLike | Frame,
        *,
        model: Literal["volumetric", "exact"] | None = None,
        reverse: bool = False,
        in_order: bool = False,
        temperature_c: float | None = None,
    ) -> NDArray[np.float64]: ...
    def correction(
        self,
        positions: ArrayLike | Frame,
        *,
        model: Literal["nine", "volumetric", "exact"] | None = None,
        reverse: bool = False,
        in_order: bool = False,
        temperature_c: float | None = None,
        inverse_passes: int | None = None,
        orientation: bool = False,
    ) -> NDArray[np.float64]: ...
    def forward(
        self, positions: ArrayLike | Frame, *, tool_mm: Sequence[float] | None = None
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]: ...
    def inverse(
        self,
        tip: ArrayLike,
        tool: ArrayLike,
        *,
        branch: Literal["nearest", "1", "2"] = "nearest",
        start: Sequence[float] | None = None,
        max_step_deg: float | None = None,
        tool_mm: Sequence[float] | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.uint8], NDArray[np.float64], NDArray[np.float64]]: ...
    def uncertainty(
        self,
        *,
        at: Sequence[float] | None = None,
        volume_mm: Sequence[Sequence[float] | None] | None = None,
        pose_deg: Mapping[str, float] | None = None,
        points: int = 9,
        confidence: float = 95.0,
        trials: int = 10_000,
        seed: int = 1,
    ) -> Uncertainty: ...

@final
class Path:
    """A programmed path of lines, arcs and NURBS."""

    @staticmethod
    def load(path: str | PathLike[str]) -> Path: ...
    @staticmethod
    def from_json(text: str) -> Path: ...
    @property
    def segments(self) -> int: ...
    def contour_error(
        self,
        segment: ArrayLike,
        u: ArrayLike,
        actual: ArrayLike | Frame,
        *,
        max_lag_mm: float = 1.0,
        method: Literal["guarded", "bisection"] = "guarded",
    ) -> ContourError: ...

@final
class Program:
    """A part program, read and checked."""

    SHIPPED: ClassVar[list[str]]
    @staticmethod
    def load(
        path: str | PathLike[str],
        *,
        tool_table: str | PathLike[str] | None = None,
        offsets: str | PathLike[str] | None = None,
        block_delete: bool = False,
    ) -> Program: ...
    @staticmethod
    def from_text(
        text: str,
        *,
        name: str = "program",
        tool_table: str | None = None,
        offsets: str | None = None,
        block_delete: bool = False,
    ) -> Program: ...
    @property
    def name(self) -> str: ...
    @property
    def moves(self) -> int: ...

def simulate(
    machine: Machine,
    program: Program,
    *,
    seed: int | None = None,
    rate_hz: float | None = None,
    temperature_c: float | None = None,
    origin_mm: Sequence[float] | None = None,
    scenario: str | None = None,
    settings: Mapping[str, float | list[float] | list[str]] | None = None,
    faults: Sequence[str] = ...,
    events: Sequence[str] = ...,
    exchanges: Mapping[str, Machine] = ...,
    on_trial: bool = False,
    model: Literal["nine", "volumetric"] | None = None,
    orientation: bool | None = None,
    learned: str | PathLike[str] | None = None,
    kinds: Sequence[Literal["uncompensated", "compensated", "servo_only", "full", "configured"]] | None = None,
    trace_every: int | None = None,
) -> Run: ...
def helicoid(*, gcode: bool = False, **request: Any) -> Helicoid: ...
def identify(
    readings: ArrayLike | Frame | str | PathLike[str] | Readable,
    *,
    axis: Literal["A", "B", "C"],
    machine: Machine | None = None,
    start_mm: Sequence[float] | None = None,
    free_offsets: bool = False,
    table: bool = False,
    residuals: bool = False,
) -> Identification: ...
def friction(
    record: ArrayLike | Frame | str | PathLike[str] | Readable,
    *,
    axes: str,
    machine: Machine | None = None,
    find_drive: bool = False,
    find_resonance: bool = False,
    read_after_us: float | None = None,
    residuals: bool = False,
    toml: bool = False,
) -> Friction: ...
def ballbar(
    record: ArrayLike | Frame | str | PathLike[str] | Readable,
    *,
    radius_mm: float,
    axes: str = "X,Y",
    pitch_x_mm: float | None = None,
    pitch_y_mm: float | None = None,
    pitch_z_mm: float | None = None,
    machine: Machine | None = None,
    compensated: bool = False,
    traces: bool = False,
) -> Ballbar: ...
def calibrate_plan(task: str | PathLike[str]) -> CalibrationPlan: ...
def calibrate_solve(
    task: str | PathLike[str],
    log: str | PathLike[str],
    *,
    files: bool = False,
    force: bool = False,
    residuals: bool = False,
) -> Calibration: ...
def keep_plan(task: str | PathLike[str]) -> KeepPlan: ...
def keep_begin(task: str | PathLike[str], log: str | PathLike[str], *, time: str | None = None, parts: int | None = None) -> Reprobing: ...
def keep_check(
    task: str | PathLike[str],
    log: str | PathLike[str],
    *,
    time: str | None = None,
    parts: int | None = None,
    accept: Sequence[str] = ...,
    by_hand: bool = False,
    files: bool = False,
) -> Reprobing: ...
def keep_apply(
    task: str | PathLike[str],
    log: str | PathLike[str],
    *,
    time: str | None = None,
    parts: int | None = None,
    accept: Sequence[str] = ...,
    by_hand: bool = False,
) -> Reprobing: ...
def keep_undo(task: str | PathLike[str], entry: int | None = None, *, time: str | None = None, by_hand: bool = False) -> dict[str, Any]: ...
def keep_history(task: str | PathLike[str]) -> list[dict[str, Any]]: ...
def thermal_fit(
    record: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable,
    *,
    machine: Machine | None = None,
    hold_out: Sequence[int] = ...,
    without: Sequence[str] = ...,
    rate_k_per_min: float | None = ...,
    residuals: bool = False,
    toml: bool = False,
) -> ThermalFit: ...
def thermal_compile(thermal: ThermalFit | str | PathLike[str], *, machine: Machine) -> bytes: ...
def learn(
    record: str | PathLike[str],
    *,
    table: str | PathLike[str] | None = None,
    gain: float = ...,
    forget: float = ...,
    cutoff_mm: float = ...,
) -> Learned: ...
def predict(
    machine: Machine,
    part: str | PathLike[str],
    program: str | PathLike[str] | None = None,
    *,
    at_mm: Sequence[float] | None = None,
    trials: int = 10_000,
    seed: int = 1,
    thermal: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable | None = None,
    start: float | None = None,
    at: str | None = None,
    servo: bool = False,
    rate_hz: float = 10_000.0,
    exact_drives: bool = False,
    advise: bool = False,
) -> PredictedPart: ...
def import_table(
    file: str | PathLike[str],
    folder: str | PathLike[str],
    *,
    format: str,
    axis: Literal["X", "Y", "Z", "A", "B", "C"] | None = None,
    comp_file_type: Literal[0, 1] | None = None,
    unit: Literal["mm", "um", "inch"] | None = None,
    columns: Mapping[str, str] | None = None,
    area_mm: Sequence[float] | None = None,
    mesh: str | None = None,
    new: bool = False,
) -> Transfer: ...
def export_table(
    machine: Machine,
    file: str | PathLike[str],
    *,
    format: str,
    axis: Literal["X", "Y", "Z", "A", "B", "C"] | None = None,
    comp_file_type: Literal[0, 1] | None = None,
    drop: bool = False,
    step: float | None = None,
) -> Transfer: ...
def evaluate_probing(
    record: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable,
    *,
    feature: Literal["ring", "sphere", "point"],
    diameter_mm: float | None = None,
) -> Probing: ...
def evaluate_thermal(
    record: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable,
    *,
    test: Literal["etve", "spindle", "axis"] = "spindle",
    period_min: float = 60.0,
    distance_mm: float | None = None,
) -> ThermalTest: ...
def evaluate_step_diagonal(
    record: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable,
    *,
    alignment_urad: float | None = None,
    machine: Machine | None = None,
) -> StepDiagonal: ...
def evaluate_r_test(
    record: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable,
    *,
    machine: Machine,
    tool_mm: Sequence[float] | None = None,
    without: Sequence[str] = ...,
    free_sensor: bool = False,
    residuals: bool = False,
) -> RTest: ...
def evaluate_points(
    record: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable,
    *,
    machine: Machine | None = None,
    nodes: Sequence[int] | None = None,
    without: Sequence[str] = ...,
    against: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable | None = None,
    residuals: bool = False,
) -> MeasuredPoints | MeasuredPlane: ...
def accuracy(
    record: Mapping[str, ArrayLike] | Frame | str | PathLike[str] | Readable,
    *,
    axis: Literal["X", "Y", "Z", "A", "B", "C"] | None = None,
    machine: Machine | None = None,
    instrument: Machine | None = None,
    tolerance_um: float | None = None,
    confidence: float = 95.0,
) -> Accuracy: ...
def circle(points: ArrayLike | Frame) -> Circle: ...
def trace_roundness(radius_mm: ArrayLike, *, theta_deg: ArrayLike | None = None, upr: int | None = None) -> Circle: ...
def roundness(
    readings: ArrayLike,
    *,
    n: int,
    harmonics: tuple[int, int] | None = None,
    p: int | None = None,
    q: int | None = None,
    phi2_deg: float | None = None,
    phi3_deg: float | None = None,
    arm: tuple[float, float, float] | None = None,
    upr: int | None = None,
    noise_gain_limit: float = ...,
    theta_deg: ArrayLike | None = None,
    angles_deg: Sequence[float] | None = None,
) -> Roundness: ...
def probe_angles(
    *,
    n: int,
    harmonics: tuple[int, int] | None = None,
    p: int | None = None,
    q: int | None = None,
    phi2_deg: float | None = None,
    phi3_deg: float | None = None,
    count: int = ...,
) -> ProbeAngles: ...
