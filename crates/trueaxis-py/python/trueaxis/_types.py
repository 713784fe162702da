"""Types of the results. document_types.py writes this file from the documents of the command line."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ._results import Budgeted, Result, Section


class Plane(Section):
    """The plane of points in space, as written to the document.

    Attributes
    ----------
    normal : NDArray[np.float64]
        Unit normal.
    flatness_um : float
        Largest minus smallest distance of the points from the plane.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    normal: NDArray[np.float64]
    flatness_um: float


class CircleCircle(Section):
    """A reference circle.

    Attributes
    ----------
    centre_mm : NDArray[np.float64]
        Centre: two coordinates, or three for points in space.
    cx_mm : float | None
        x of the centre.
    cy_mm : float | None
        y of the centre.
    cz_mm : float | None
        z of the centre.
    radius_mm : float
        Radius: mean, inner or outer, depending on the circle.
    diameter_mm : float
        Twice the radius.
    inner_mm : float
        Smallest distance of a point from the centre.
    outer_mm : float
        Largest distance of a point from the centre.
    zone_mm : float
        Outer minus inner radius.
    zone_um : float
        `zone_mm` in µm.
    contacts : NDArray[np.int64]
        Points that determine the circle, from 0.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    centre_mm: NDArray[np.float64]
    cx_mm: float | None
    cy_mm: float | None
    cz_mm: float | None
    radius_mm: float
    diameter_mm: float
    inner_mm: float
    outer_mm: float
    zone_mm: float
    zone_um: float
    contacts: NDArray[np.int64]


class Circle(Result):
    """Result of `circle`, `trace_roundness`.

    Attributes
    ----------
    points : int
        Number of points.
    plane : Plane | None
        The plane fitted to points in space.
    lsc : CircleCircle | None
        Least squares.
    mzc : CircleCircle | None
        Minimum zone.
    mic : CircleCircle | None
        Maximum inscribed.
    mcc : CircleCircle | None
        Minimum circumscribed.
    refused : Section
        Why a circle is null.
    theta_deg : NDArray[np.float64]
        Angles of the trace, of `trace_roundness`.
    radius_mm : NDArray[np.float64]
        Radii of the trace as filtered, of `trace_roundness`.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"plane": Plane, "lsc": CircleCircle, "mzc": CircleCircle, "mic": CircleCircle, "mcc": CircleCircle}
    points: int
    plane: Plane | None
    lsc: CircleCircle | None
    mzc: CircleCircle | None
    mic: CircleCircle | None
    mcc: CircleCircle | None
    refused: Section
    theta_deg: NDArray[np.float64]
    radius_mm: NDArray[np.float64]


class InterpolationError(Section):
    """Difference between interpolation by six and by four readings: the error of the poorer one, which is not used.

    Attributes
    ----------
    max : float
        Largest.
    rms : float
        Root mean square.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    max: float
    rms: float


class Resampling(Section):
    """Result of resampling a trace.

    Attributes
    ----------
    rows : int
        Number of rows in the file.
    unused_rows : int
        Rows before or after the whole revolutions.
    largest_gap_deg : float
        Widest step between two rows.
    interpolation_error_um : InterpolationError
        Error that interpolation adds.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"interpolation_error_um": InterpolationError}
    rows: int
    unused_rows: int
    largest_gap_deg: float
    interpolation_error_um: InterpolationError


class Centres(Section):
    """Centres of the four reference circles.

    Attributes
    ----------
    lsc : NDArray[np.float64]
        Least squares, x and y.
    mzc : NDArray[np.float64]
        Minimum zone, x and y.
    mic : NDArray[np.float64]
        Maximum inscribed, x and y.
    mcc : NDArray[np.float64]
        Minimum circumscribed, x and y.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    lsc: NDArray[np.float64]
    mzc: NDArray[np.float64]
    mic: NDArray[np.float64]
    mcc: NDArray[np.float64]


class Revolution(Section):
    """One revolution.

    Attributes
    ----------
    revolution : int
        Number of the revolution, from 1.
    lsc_um : float
        Least squares.
    mzc_um : float
        Minimum zone.
    mic_um : float
        Maximum inscribed.
    mcc_um : float
        Minimum circumscribed.
    x_from_mean_um : float
        Largest distance in X of this revolution's error motion from the mean contour.
    y_from_mean_um : float
        Largest such distance in Y.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    revolution: int
    lsc_um: float
    mzc_um: float
    mic_um: float
    mcc_um: float
    x_from_mean_um: float
    y_from_mean_um: float


class HarmonicEntry(Section):
    """A harmonic, A cos(k θ + phase).

    Attributes
    ----------
    k : int
        Undulations per revolution.
    amplitude_um : float
        Amplitude A; 0 if suppressed.
    phase_deg : float
        Phase, −180 to 180.
    noise_gain : float
        Growth of the probes' noise.
    suppressed : bool
        Omitted because its noise gain exceeds the limit.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    k: int
    amplitude_um: float
    phase_deg: float
    noise_gain: float
    suppressed: bool


class SpindleDirection(Section):
    """Error motion in one direction.

    Attributes
    ----------
    synchronous_um : float
        Peak to valley of the mean contour without the once-per-revolution part.
    asynchronous_um : float | None
        Largest range over the revolutions at one angle; `None` for a single revolution.
    once_per_revolution_um : float
        Amplitude of the once-per-revolution part.
    once_per_revolution_phase_deg : float
        Phase of that part, −180 to 180.
    total_um : float
        Peak to valley of all revolutions without the once-per-revolution part.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    synchronous_um: float
    asynchronous_um: float | None
    once_per_revolution_um: float
    once_per_revolution_phase_deg: float
    total_um: float


class Spindle(Section):
    """Error motion of the spindle after ISO 230-7.

    Attributes
    ----------
    x : SpindleDirection
        Across the direction of probe 1.
    y : SpindleDirection
        Along the direction of probe 1.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"x": SpindleDirection, "y": SpindleDirection}
    x: SpindleDirection
    y: SpindleDirection


class ProbeEntry(Section):
    """A probe against the others.

    Attributes
    ----------
    angle_deg : float
        Stated angle from probe 1, in the sense of θ.
    residual_um : float
        Contradiction in its readings, root mean square.
    noise_without_um : float | None
        Noise that would explain the contradiction of the others; `None` with fewer than five probes.
    angle_error_deg : float | None
        True angle less the stated one; `None` for probe 1, the reference.
    angle_error_standard_error_deg : float | None
        Its standard error.
    sensitivity_error : float | None
        Sensitivity relative to that of probe 1, less 1.
    sensitivity_error_standard_error : float | None
        Its standard error.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    angle_deg: float
    residual_um: float
    noise_without_um: float | None
    angle_error_deg: float | None
    angle_error_standard_error_deg: float | None
    sensitivity_error: float | None
    sensitivity_error_standard_error: float | None


class AgreementEntry(Section):
    """Contradiction of four to six probes.

    Attributes
    ----------
    noise_um : float
        Standard deviation of a reading's noise that would explain the contradiction.
    disagreeing : int | None
        The probe, from 1, without which the others agree at least twice as well, if chance does not explain it.
    probes : tuple[ProbeEntry, ...]
        Each probe.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"probes": ProbeEntry}
    noise_um: float
    disagreeing: int | None
    probes: tuple[ProbeEntry, ...]


class Roundness(Result):
    """Result of `roundness`.

    Attributes
    ----------
    n : int
        Points per revolution N.
    revolutions : int
        Number of whole revolutions.
    upr : int | None
        Cut-off of the filter applied before the zones.
    resampling : Resampling | None
        Resampling of readings that have their own angles.
    lsc_um : float
        Least squares.
    mzc_um : float
        Minimum zone.
    mic_um : float
        Maximum inscribed.
    mcc_um : float
        Minimum circumscribed.
    centres_um : Centres
        Centres of the filtered mean profile.
    per_revolution : tuple[Revolution, ...]
        Each revolution separately.
    harmonics : tuple[HarmonicEntry, ...]
        Harmonics of the unfiltered mean profile.
    spindle : Spindle
        Error motion of the spindle.
    agreement : AgreementEntry | None
        How far four to six probes disagree.
    warnings : tuple[str, ...]
        Doubtful findings.
    profile_um : NDArray[np.float64]
        Profile, µm: one row a revolution.
    rx_um : NDArray[np.float64]
        Error motion across probe 1, µm: one row a revolution.
    ry_um : NDArray[np.float64]
        Error motion along probe 1, µm: one row a revolution.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"resampling": Resampling, "centres_um": Centres, "per_revolution": Revolution, "harmonics": HarmonicEntry, "spindle": Spindle, "agreement": AgreementEntry}
    n: int
    revolutions: int
    upr: int | None
    resampling: Resampling | None
    lsc_um: float
    mzc_um: float
    mic_um: float
    mcc_um: float
    centres_um: Centres
    per_revolution: tuple[Revolution, ...]
    harmonics: tuple[HarmonicEntry, ...]
    spindle: Spindle
    agreement: AgreementEntry | None
    warnings: tuple[str, ...]
    profile_um: NDArray[np.float64]
    rx_um: NDArray[np.float64]
    ry_um: NDArray[np.float64]


class NoiseGain(Section):
    """Noise gain of one harmonic.

    Attributes
    ----------
    k : int
        Undulations per revolution.
    noise_gain : float
        Growth of the probes' noise.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    k: int
    noise_gain: float


class GivenPair(Section):
    """The requested pair, compared with the best.

    Attributes
    ----------
    p : int | None
        Slots from probe 1 to probe 2; `None` for a pair given in degrees.
    q : int | None
        Slots from probe 2 to probe 3.
    phi2_deg : float
        Angle from probe 1 to probe 2.
    phi3_deg : float
        Angle from probe 2 to probe 3.
    worst_gain : float
        Smallest gain in the band, 0 (blind) to √3.
    worst_noise_gain : float
        Inverse of `worst_gain`: growth of the probes' noise in the worst harmonic.
    worst_harmonic : int
        The worst harmonic.
    share_of_best : float
        Worst gain relative to the best pair's.
    noise_gains : tuple[NoiseGain, ...]
        Noise gains over the band.
    singular : NDArray[np.int64]
        Harmonics outside the band, up to N/2 − 1, that the pair cannot see.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"noise_gains": NoiseGain}
    p: int | None
    q: int | None
    phi2_deg: float
    phi3_deg: float
    worst_gain: float
    worst_noise_gain: float
    worst_harmonic: int
    share_of_best: float
    noise_gains: tuple[NoiseGain, ...]
    singular: NDArray[np.int64]


class ProbeAngles(Result):
    """Result of `probe_angles`.

    Attributes
    ----------
    n : int
        Points per revolution N.
    harmonics : NDArray[np.int64]
        First and last harmonic.
    best : tuple[Section, ...]
        Best pairs first.
    pair : GivenPair | None
        The requested pair.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"pair": GivenPair}
    n: int
    harmonics: NDArray[np.int64]
    best: tuple[Section, ...]
    pair: GivenPair | None


class OneWayAtPosition(Section):
    """Result at one target position in one direction; µm (µrad).

    Attributes
    ----------
    mean : float
        Mean deviation x̄_i↑ or x̄_i↓.
    s : float
        Estimator of the repeatability s_i↑ or s_i↓.
    repeatability : float
        Repeatability R_i↑ = 4 s_i↑ (R_i↓).
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    mean: float
    s: float
    repeatability: float


class AtPosition(Section):
    """Result at one target position; µm (µrad).

    Attributes
    ----------
    position : float
        Target position, mm (degrees).
    up : OneWayAtPosition | None
        Approached in positive direction.
    down : OneWayAtPosition | None
        Approached in negative direction.
    mean : float | None
        Mean bidirectional deviation x̄_i.
    reversal : float | None
        Reversal error B_i.
    repeatability : float | None
        Bidirectional repeatability R_i.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"up": OneWayAtPosition, "down": OneWayAtPosition}
    position: float
    up: OneWayAtPosition | None
    down: OneWayAtPosition | None
    mean: float | None
    reversal: float | None
    repeatability: float | None


class OneWay(Section):
    """Result of the axis in one direction; µm (µrad).

    Attributes
    ----------
    accuracy : float
        Unidirectional accuracy A↑ or A↓.
    systematic : float
        Unidirectional systematic positioning error E↑ or E↓.
    repeatability : float
        Unidirectional repeatability R↑ or R↓.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    accuracy: float
    systematic: float
    repeatability: float


class BothWays(Section):
    """Result of the axis over both directions; µm (µrad).

    Attributes
    ----------
    accuracy : float
        Bidirectional accuracy A.
    systematic : float
        Bidirectional systematic positioning error E.
    repeatability : float
        Bidirectional repeatability R.
    mean_range : float
        Range of the mean bidirectional deviation M.
    reversal : float
        Reversal error B.
    mean_reversal : float
        Mean reversal error B̄, with sign.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    accuracy: float
    systematic: float
    repeatability: float
    mean_range: float
    reversal: float
    mean_reversal: float


class AccuracyAccuracy(Section):
    """Evaluation of one axis after ISO 230-2:2014.

    Attributes
    ----------
    axis : str
        Letter of the axis.
    unit : str
        Unit of all values except the positions: `um` or `urad`.
    runs : int
        Number of runs n (ISO 230-2 requires 5).
    positions : tuple[AtPosition, ...]
        One entry per target position, increasing.
    up : OneWay | None
        In positive direction, if measured.
    down : OneWay | None
        In negative direction, if measured.
    both : BothWays | None
        Over both directions, if both were measured.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"positions": AtPosition, "up": OneWay, "down": OneWay, "both": BothWays}
    axis: str
    unit: str
    runs: int
    positions: tuple[AtPosition, ...]
    up: OneWay | None
    down: OneWay | None
    both: BothWays | None


class Interval(Section):
    """An interval, ends included.

    Attributes
    ----------
    low : float
        Low end.
    high : float
        High end.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    low: float
    high: float


class Band(Section):
    """A figure with its uncertainty band.

    Attributes
    ----------
    figure : str
        Symbol in ISO 230-2: `A`, `A_up`, `A_down`, `E`, … `M`, `B`, `B_mean`.
    value : float
        As measured, µm (µrad).
    expanded : float
        Expanded uncertainty U: half of the interval.
    interval : Interval
        Interval that contains the figure with the given coverage.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"interval": Interval}
    figure: str
    value: float
    expanded: float
    interval: Interval


class Positioning(Section):
    """Bands of all figures of a measurement.

    Attributes
    ----------
    coverage : float
        Coverage, 0 … 1.
    trials : int
        Number of draws.
    figures : tuple[Band, ...]
        Bands of the figures that the measurement has.
    drowned : bool
        Whether the instrument dominates the scatter of the readings: the bands of A, R and B may then fall short of their coverage.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"figures": Band}
    coverage: float
    trials: int
    figures: tuple[Band, ...]
    drowned: bool


class Judgement(Section):
    """A verdict on the bidirectional accuracy A (for a measurement in one direction: A↑ or A↓), uncertainty included.

    Attributes
    ----------
    figure : str
        The figure.
    tolerance_um : float
        Largest permitted value, µm.
    verdict : str
        Pass or fail only if the tolerance is outside the band (ISO 14253-1).
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    figure: str
    tolerance_um: float
    verdict: str


class Accuracy(Result):
    """Result of `accuracy`.

    Attributes
    ----------
    measured : AccuracyAccuracy
        As measured.
    compensated : AccuracyAccuracy | None
        After subtracting the corrections of a machine's tables.
    uncertainty : Positioning | None
        Bands of the measured figures, if the instrument's uncertainty is known.
    verdict : Judgement | None
        Verdict against a tolerance.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"measured": AccuracyAccuracy, "compensated": AccuracyAccuracy, "uncertainty": Positioning, "verdict": Judgement}
    measured: AccuracyAccuracy
    compensated: AccuracyAccuracy | None
    uncertainty: Positioning | None
    verdict: Judgement | None


class Ways(Section):
    """A value for each direction; null if that direction was not recorded.

    Attributes
    ----------
    ccw : float | None
        Counterclockwise.
    cw : float | None
        Clockwise.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    ccw: float | None
    cw: float | None


class Covariance(Section):
    """Covariance of terms, in the order of a fit's document.

    Attributes
    ----------
    names : tuple[str, ...]
        Names of the terms.
    units : tuple[str, ...]
        Units of the terms; an entry of the matrix has the product of two.
    estimates : NDArray[np.float64]
        Estimates of the terms.
    matrix : tuple[NDArray[np.float64], ...]
        Variances and covariances, row by row.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    names: tuple[str, ...]
    units: tuple[str, ...]
    estimates: NDArray[np.float64]
    matrix: tuple[NDArray[np.float64], ...]


class Share(Section):
    """Share of a cause in the deviation.

    Attributes
    ----------
    cause : str
        Name of the cause.
    rms_um : float
        Root mean square of the deviation that the cause makes.
    share : float
        Fraction of the sum of squares of all causes, 0 … 1.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    cause: str
    rms_um: float
    share: float


class Ballbar(Result):
    """Result of `ballbar`.

    Attributes
    ----------
    readings : int
        Number of readings in the record.
    radius_mm : float
        Nominal radius.
    g_b_um : float | None
        G(b): bidirectional circular deviation (ISO 230-4), minimum zone.
    g_um : Ways
        G: circular deviation, minimum zone.
    f_um : Ways
        F: radial deviation of the largest magnitude, about the least-squares centre of its direction; null for an arc.
    f_max_um : Ways
        F max.
    f_min_um : Ways
        F min.
    h_um : float | None
        H: circular hysteresis.
    radius_deviation_um : float
        Mean deviation of the radius.
    centre_um : NDArray[np.float64]
        Offset of the circle's centre.
    plane : str
        The plane, such as `XY`.
    squareness_urad : float
        C0Y; A0Z in the plane of Y and Z, B0Z in that of X and Z.
    squareness : str
        Name of that squareness.
    scale_mismatch_ppm : float
        Scale of the first axis less that of the second.
    servo_mismatch_um : float | None
        Lag of the first axis less that of the second.
    backlash_um : Section
        Lost motion.
    reversal_um : Section
        Spikes after reversals, outwards.
    reversal_width_deg : float
        Width of the spikes.
    lateral_play_um : Section
        Lateral shift at reversals of an axis.
    straightness_um : Section
        Bow of an axis over the radius.
    cyclic_um : Section
        Amplitude of periodic errors; null if none is visible.
    pitch_mm : Section
        Pitches of the periodic errors.
    standard_errors : Section
        Standard errors under the names of the values.
    expanded_uncertainties : Section
        Half-widths of 95 % intervals: standard errors times Student's factor.
    covariance : Covariance
        Covariance of the values that have a standard error, by names as `backlash_um.x` and `centre_um[0]`; its diagonal are the squares of these. It is conditional on the pitches; spikes of a shape other than the fit's own are not in it.
    shares : tuple[Share, ...]
        Causes other than radius and centre, largest first.
    sigma_um : float
        Standard deviation of a reading, from the residuals.
    degrees_of_freedom : int
        Readings less parameters.
    condition : float
        Condition number of the fit.
    warnings : tuple[str, ...]
        Caveats on the result.
    written : tuple[Section, ...]
        Decision on every value found, if a machine is given: key, old, found, written, why.
    angle_deg : NDArray[np.float64]
        Angle of every reading, with `traces=True`.
    direction : NDArray[np.float64]
        1 counterclockwise, -1 clockwise, with `traces=True`.
    centred_um : NDArray[np.float64]
        Deviation about the circle's centre, with `traces=True`.
    left_um : NDArray[np.float64]
        Residual of the causes, with `traces=True`.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"g_um": Ways, "f_um": Ways, "f_max_um": Ways, "f_min_um": Ways, "covariance": Covariance, "shares": Share}
    readings: int
    radius_mm: float
    g_b_um: float | None
    g_um: Ways
    f_um: Ways
    f_max_um: Ways
    f_min_um: Ways
    h_um: float | None
    radius_deviation_um: float
    centre_um: NDArray[np.float64]
    plane: str
    squareness_urad: float
    squareness: str
    scale_mismatch_ppm: float
    servo_mismatch_um: float | None
    backlash_um: Section
    reversal_um: Section
    reversal_width_deg: float
    lateral_play_um: Section
    straightness_um: Section
    cyclic_um: Section
    pitch_mm: Section
    standard_errors: Section
    expanded_uncertainties: Section
    covariance: Covariance
    shares: tuple[Share, ...]
    sigma_um: float
    degrees_of_freedom: int
    condition: float
    warnings: tuple[str, ...]
    written: tuple[Section, ...]
    angle_deg: NDArray[np.float64]
    direction: NDArray[np.float64]
    centred_um: NDArray[np.float64]
    left_um: NDArray[np.float64]


class SetUp(Section):
    """Where a ball was set up.

    Attributes
    ----------
    l_mm : float
        Distance below the intersection of the rotary axes, mm.
    h_mm : float
        Distance beside the intersection, mm.
    offset_um : NDArray[np.float64] | None
        The offset found, if offsets are free.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    l_mm: float
    h_mm: float
    offset_um: NDArray[np.float64] | None


class Angle(Section):
    """Errors at an angle.

    Attributes
    ----------
    angle_deg : float
        Position of the axis.
    residual_um : float
        Root mean square of the readings' residuals.
    condition : float
        Condition number.
    rank : int
        Rank: 6 if all errors are determined.
    standard_errors : Section
        
    expanded_uncertainties : Section
        
    covariance : Covariance
        Covariance of the errors at this angle; its diagonal has the squares of their standard errors. Errors of different angles are independent if the offsets are known; free offsets correlate them too, which it does not show.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"covariance": Covariance}
    angle_deg: float
    residual_um: float
    condition: float
    rank: int
    standard_errors: Section
    expanded_uncertainties: Section
    covariance: Covariance


class Identification(Result):
    """Result of `identify`.

    Attributes
    ----------
    axis : str
        Letter of the axis.
    set_ups : tuple[SetUp, ...]
        Set-ups of the ball.
    angles : tuple[Angle, ...]
        Errors at every angle.
    sigma_um : float
        Standard deviation of one reading, from the residuals of all angles.
    standard_errors : Section
        Root mean square of the standard errors over the angles.
    expanded_uncertainties : Section
        Half-widths of 95 % intervals: standard errors times Student's factor.
    degrees_of_freedom : int
        Number of readings minus the unknowns that they determine.
    location : str
        Whether the errors include location errors: "inside" or "removed".
    null_space : int
        Number of combinations that no reading observes and that the convention of free offsets fixes; 0 without free offsets.
    warnings : tuple[str, ...]
        Remarks on the result, a sentence each.
    written : tuple[Section, ...]
        Decision on every value found, if a machine is given: key, old, found, written, why.
    table : str
        The axis' table as CSV text, with `table=True`.
    residuals_um : NDArray[np.float64]
        Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"set_ups": SetUp, "angles": Angle}
    axis: str
    set_ups: tuple[SetUp, ...]
    angles: tuple[Angle, ...]
    sigma_um: float
    standard_errors: Section
    expanded_uncertainties: Section
    degrees_of_freedom: int
    location: str
    null_space: int
    warnings: tuple[str, ...]
    written: tuple[Section, ...]
    table: str
    residuals_um: NDArray[np.float64]


class Errors(Section):
    """Standard errors; `None` for a figure that was fixed rather than fitted.

    Attributes
    ----------
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}


class Deviation(Section):
    """Size of a deviation, µm.

    Attributes
    ----------
    max : float
        Largest magnitude.
    rms : float
        Root mean square.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    max: float
    rms: float


class Glitch(Section):
    """Spikes at the reversals, µm.

    Attributes
    ----------
    before : Deviation
        Recorded spikes.
    predicted : Deviation
        Spikes that the model predicts.
    after : Deviation
        Spikes expected with the feed-forward.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"before": Deviation, "predicted": Deviation, "after": Deviation}
    before: Deviation
    predicted: Deviation
    after: Deviation


class ResonanceErrors(Section):
    """Errors of the figures of a resonance.

    Attributes
    ----------
    resonance_hz : float
        Standard uncertainty of the frequency, Hz.
    resonance_damping : float
        Standard uncertainty of the damping, share of critical.
    load_share : float
        Standard uncertainty of the load's share.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    resonance_hz: float
    resonance_damping: float
    load_share: float


class ResonanceFound(Section):
    """Resonance of an axis; first keys as in `machine.toml`.

    Attributes
    ----------
    resonance_hz : float
        Frequency with both masses free, Hz.
    resonance_damping : float
        Damping, share of critical.
    load_share : float
        Mass of the load over that of motor and load.
    on_load : bool | None
        Whether the readings are those of a scale on the load; null if an encoder on the motor explains them as well.
    damping_known : bool
        Whether the record determines the damping; only then are frequency and damping written into a machine.
    standard_errors : ResonanceErrors
        Standard errors of frequency, damping and share.
    expanded_uncertainties : ResonanceErrors
        Half-widths of 95 % intervals.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"standard_errors": ResonanceErrors, "expanded_uncertainties": ResonanceErrors}
    resonance_hz: float
    resonance_damping: float
    load_share: float
    on_load: bool | None
    damping_known: bool
    standard_errors: ResonanceErrors
    expanded_uncertainties: ResonanceErrors


class AxisFound(Section):
    """One axis.

    Attributes
    ----------
    axis : str
        Letter of the axis.
    friction : Any
        Friction of the axis.
    drive : Any
        Drive of the axis.
    drive_found : bool
        Whether the drive's figures come from the record; otherwise the machine states them.
    standard_errors : Errors
        Null for a figure that was fixed rather than fitted.
    expanded_uncertainties : Errors
        Half-widths of 95 % intervals: standard errors times Student's factor, counting each stretch round a reversal as one observation.
    reading_lag_s : float
        Delay of the reading beyond the drive's own lag, s.
    glitch_um : Glitch
        Spikes at the reversals, µm.
    explained : float
        Share of the spikes' mean square that the model explains.
    residual_um : float
        Root mean square of the residuals of the fit, µm.
    fitted : int
        Number of fitted parameters.
    condition : float
        Condition number of the fit.
    reversals : int
        Number of reversals in motion.
    resonance : ResonanceFound | None
        Resonance of motor and load against each other; null if the record shows none.
    resonance_not_found : str | None
        Why the record shows no resonance; null if it does, or if nobody has searched for it.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"standard_errors": Errors, "expanded_uncertainties": Errors, "glitch_um": Glitch, "resonance": ResonanceFound}
    axis: str
    friction: Any
    drive: Any
    drive_found: bool
    standard_errors: Errors
    expanded_uncertainties: Errors
    reading_lag_s: float
    glitch_um: Glitch
    explained: float
    residual_um: float
    fitted: int
    condition: float
    reversals: int
    resonance: ResonanceFound | None
    resonance_not_found: str | None


class Friction(Result):
    """Result of `friction`.

    Attributes
    ----------
    samples : int
        Samples of the record.
    period_s : float
        Sampling period, s.
    axes : tuple[AxisFound, ...]
        Both axes, in the requested order.
    covariance : Covariance
        Covariance of the figures fitted, by names as `X.coulomb_mm_per_s`; its diagonal has the squares of their standard errors. It is conditional on the figures that were fixed or stated; the axes are fitted separately, so that figures of one have none with those of the other. Figures of the resonance come from a second fit, and are not in it.
    warnings : tuple[str, ...]
        Figures that the record does not determine, and the values at which they are fixed.
    written : tuple[Section, ...]
        Decision on every value found, if a machine is given: key, old, found, written, why.
    toml : str
        Text of the settings found, with `toml=True`.
    residuals_um : NDArray[np.float64]
        Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.
    residuals_t_s : NDArray[np.float64]
        Times of the residuals, with `residuals=True`.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"axes": AxisFound, "covariance": Covariance}
    samples: int
    period_s: float
    axes: tuple[AxisFound, ...]
    covariance: Covariance
    warnings: tuple[str, ...]
    written: tuple[Section, ...]
    toml: str
    residuals_um: NDArray[np.float64]
    residuals_t_s: NDArray[np.float64]


class Sensor(Section):
    """A sensor.

    Attributes
    ----------
    name : str
        Name of the sensor.
    lag_s : float
        Lag of the sensor, s.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    lag_s: float


class Curve(Section):
    """A curve.

    Attributes
    ----------
    of : str
        Name of the sensor, or `spindle`.
    knots : NDArray[np.float64]
        Knots, °C or rpm.
    offset_um : NDArray[np.float64]
        Offset or growth at the knots, µm.
    offset_error_um : NDArray[np.float64]
        Standard errors of `offset_um`.
    slope : NDArray[np.float64]
        Slope at the knots, µm/m, or tilt, µrad.
    slope_error : NDArray[np.float64]
        Standard errors of `slope`.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    of: str
    knots: NDArray[np.float64]
    offset_um: NDArray[np.float64]
    offset_error_um: NDArray[np.float64]
    slope: NDArray[np.float64]
    slope_error: NDArray[np.float64]


class Axis(Section):
    """Curves of an axis.

    Attributes
    ----------
    axis : str
        Letter of the axis.
    curves : tuple[Curve, ...]
        Curves against each sensor and against the spindle's speed.
    rms_um : float
        Root mean square of the fit's residuals in its own cycles, µm.
    condition : float
        Condition number of the fit.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"curves": Curve}
    axis: str
    curves: tuple[Curve, ...]
    rms_um: float
    condition: float


class LeftOut(Section):
    """A sensor omitted from the model.

    Attributes
    ----------
    name : str
        Name of the sensor.
    range : float
        Range over which it moved, K or rpm.
    reason : str
        Reason for the omission.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    range: float
    reason: str


class Unconfirmed(Section):
    """A speed that occurs in only one fitted cycle, so that no other predicts it.

    Attributes
    ----------
    rpm : float
        The speed.
    cycle : int
        Number of the cycle.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    rpm: float
    cycle: int


class Missing(Section):
    """Rows missing in an evenly sampled record.

    Attributes
    ----------
    line : int
        Line of the first row at or after the time of the first missing one.
    cycle : int
        Number of the cycle.
    rows : int
        Number of missing rows at all measuring points together.
    found_s : float
        Longest time without a row of one measuring point, s.
    interval_s : float
        Interval between the point's rows elsewhere, s.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    line: int
    cycle: int
    rows: int
    found_s: float
    interval_s: float


class Cycle(Section):
    """Drift of an axis in a cycle.

    Attributes
    ----------
    axis : str
        Letter of the axis.
    cycle : int
        Number of the cycle.
    held_out : bool
        Whether the cycle was excluded from the fit.
    drift_um : float
        Largest drift since the cycle began, µm.
    left_um : float
        Largest residual, µm.
    drift_rms_um : float
        Root mean square of the drift.
    left_rms_um : float
        Root mean square of the residual.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    axis: str
    cycle: int
    held_out: bool
    drift_um: float
    left_um: float
    drift_rms_um: float
    left_rms_um: float


class Repeatability(Section):
    """Repeatability of an axis beside the residual of the held-out cycles; root mean squares, µm, each about the mean of its cycle.

    Attributes
    ----------
    axis : str
        Letter of the axis.
    drift_um : float
        Drift of the held-out cycles.
    left_um : float
        Residual of the held-out cycles.
    repeat_um : float | None
        Deviation of a cycle from another one in which all sensors agree, now and in the past: no model of these sensors predicts it; `None` if no two cycles come to the same temperatures.
    model_um : float | None
        Residual without that deviation: the most that another model could remove.
    rows : int
        Number of rows compared.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    axis: str
    drift_um: float
    left_um: float
    repeat_um: float | None
    model_um: float | None
    rows: int


class ThermalFit(Result):
    """Result of `thermal_fit`.

    Attributes
    ----------
    rows : int
        Number of rows in the record.
    reference_c : float
        Temperature at which the curves are zero, °C.
    sensors : tuple[Sensor, ...]
        Sensors of the model with their lags, s.
    spindle_lag_s : float | None
        Lag of the spindle's response, s; `None` if the model does not use the speed.
    axes : tuple[Axis, ...]
        Curves of each axis.
    covariance : Covariance
        Covariance of the curves of all axes, by names as `Z.nose.offset_um[0]`; its diagonal has the squares of their standard errors. Values without one are not in it. It is conditional on the sensors and bends chosen, and includes the lags.
    left_out : tuple[LeftOut, ...]
        Sensors that are not part of the model.
    unconfirmed : tuple[Unconfirmed, ...]
        Speeds that occur in only one fitted cycle.
    missing : tuple[Missing, ...]
        Rows missing from the record.
    predicted_um : NDArray[np.float64]
        Root mean square of the drift and of the residual, µm, when every fitted cycle is predicted from the others; parts that only one cycle determines are fitted in that prediction.
    cycles : tuple[Cycle, ...]
        Drift and residual of the held-out cycles and of the others.
    repeatability : tuple[Repeatability, ...]
        How much of each axis's drift any model of these sensors could predict, beside the residual.
    held_out_um : NDArray[np.float64]
        Largest drift of the held-out cycles, µm, and largest residual.
    toml : str
        Text of the settings found, with `toml=True`.
    residuals_um : NDArray[np.float64]
        Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"sensors": Sensor, "axes": Axis, "covariance": Covariance, "left_out": LeftOut, "unconfirmed": Unconfirmed, "missing": Missing, "cycles": Cycle, "repeatability": Repeatability}
    rows: int
    reference_c: float
    sensors: tuple[Sensor, ...]
    spindle_lag_s: float | None
    axes: tuple[Axis, ...]
    covariance: Covariance
    left_out: tuple[LeftOut, ...]
    unconfirmed: tuple[Unconfirmed, ...]
    missing: tuple[Missing, ...]
    predicted_um: NDArray[np.float64]
    cycles: tuple[Cycle, ...]
    repeatability: tuple[Repeatability, ...]
    held_out_um: NDArray[np.float64]
    toml: str
    residuals_um: NDArray[np.float64]


class SolvedTerm(Section):
    """A term with its value.

    Attributes
    ----------
    name : str
        Name of the term.
    value : float
        Value of the term.
    standard_error : float
        Standard error of the value.
    unit : str
        Unit of both.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    value: float
    standard_error: float
    unit: str


class Size(Section):
    """Size of an artefact.

    Attributes
    ----------
    name : str
        Name of the artefact, or of one of its several sizes.
    stated : float
        Size that the task states: mm, for an angle degrees.
    found : float
        Size that the network finds.
    standard_error : float
        Standard error, µm; for an angle, µrad.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    stated: float
    found: float
    standard_error: float


class Drift(Section):
    """Displacement of the reference at a visit.

    Attributes
    ----------
    time_s : float
        Time without pauses, s.
    um : NDArray[np.float64]
        Displacement since the first visit, µm, in workpiece coordinates.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    time_s: float
    um: NDArray[np.float64]


class Calibration(Result):
    """Result of `calibrate_solve`.

    Attributes
    ----------
    machine : str
        The machine's name.
    compensated : bool
        Whether the machine was compensated during probing.
    touches : int
        Number of touches.
    rank : int
        Number of unknowns, all distinguishable.
    condition : float
        Condition number of the scaled columns.
    degrees_of_freedom : int
        Touches less unknowns, as far as the touches determine these: the basis of `sigma_um`.
    sigma_um : float
        Standard deviation of a touch, from the residuals.
    repeatability_um : float
        Standard deviation of a touch, as stated.
    signal_um : float
        Root mean square of the touch displacements that the terms cause.
    terms : tuple[SolvedTerm, ...]
        Every term, and the tilts of the spindle.
    covariance : Covariance
        Covariance of the terms; its diagonal has the squares of their standard errors.
    location : Section
        Location errors found, `C0Y_urad`, `EX0C_um`.
    axes : Section
        For every linear axis `scale_ppm`, `backlash_um`, and the range (maximum less minimum) of its curves without the scale, `EXX_um`, `EAX_urad`.
    standard_errors : Section
        Standard errors under the same names, by `location` and by axis; for curves, the root mean square over the touched range.
    tip_radius_mm : float
        Effective radius of the tip; 0 with dials.
    tip_radius_standard_error_um : float
        Standard error of the radius.
    artefacts : tuple[Size, ...]
        Sizes of the artefacts.
    drift : tuple[Drift, ...]
        Drift at the visits to the reference.
    warnings : tuple[str, ...]
        Caveats on the result.
    written : tuple[Section, ...]
        Decision on every value found, if a machine is given: key, old, found, written, why.
    files : Section
        Changed files of the machine as texts, by name, with `files=True`.
    residuals_um : NDArray[np.float64]
        Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"terms": SolvedTerm, "covariance": Covariance, "artefacts": Size, "drift": Drift}
    machine: str
    compensated: bool
    touches: int
    rank: int
    condition: float
    degrees_of_freedom: int
    sigma_um: float
    repeatability_um: float
    signal_um: float
    terms: tuple[SolvedTerm, ...]
    covariance: Covariance
    location: Section
    axes: Section
    standard_errors: Section
    tip_radius_mm: float
    tip_radius_standard_error_um: float
    artefacts: tuple[Size, ...]
    drift: tuple[Drift, ...]
    warnings: tuple[str, ...]
    written: tuple[Section, ...]
    files: Section
    residuals_um: NDArray[np.float64]


class Expected(Section):
    """A term with the standard error expected from the stated repeatability.

    Attributes
    ----------
    name : str
        Name of the term.
    standard_error : float
        The standard error.
    unit : str
        Unit of the standard error.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    standard_error: float
    unit: str


class CalibrationPlan(Result):
    """Result of `calibrate_plan`.

    Attributes
    ----------
    machine : str
        The machine's name.
    program : str
        Program number that the log states, eight hexadecimal digits.
    touches : int
        Number of touches.
    minutes : float
        Time without set-ups, minutes.
    terms : tuple[Expected, ...]
        Every term.
    rank : int
        Number of unknowns, all distinguishable.
    condition : float
        Condition number of the scaled columns.
    warnings : tuple[str, ...]
        Conditions that may spoil the result, one sentence each.
    program_text : str
        Text of the program.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"terms": Expected}
    machine: str
    program: str
    touches: int
    minutes: float
    terms: tuple[Expected, ...]
    rank: int
    condition: float
    warnings: tuple[str, ...]
    program_text: str


class KeepPlanExpected(Section):
    """A term with the standard error expected of a probing, and its bounds; all in `unit`.

    Attributes
    ----------
    name : str
        Name in the task.
    standard_error : float
        Standard error from the stated repeatability.
    unit : str
        Unit of all values.
    largest_update : float
        Largest single update.
    largest_total : float
        Largest sum of updates since the beginning.
    significance : float
        Number of standard errors beyond which the term has moved.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    standard_error: float
    unit: str
    largest_update: float
    largest_total: float
    significance: float


class KeepPlan(Result):
    """Result of `keep_plan`.

    Attributes
    ----------
    machine : str
        The machine's name.
    program : str
        Program number that the log states, eight hexadecimal digits.
    touches : int
        Number of touches.
    minutes : float
        Duration of a probing, minutes.
    every_parts : int
        Number of parts between two probings.
    terms : tuple[KeepPlanExpected, ...]
        Every term.
    program_text : str
        Text of the program.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"terms": KeepPlanExpected}
    machine: str
    program: str
    touches: int
    minutes: float
    every_parts: int
    terms: tuple[KeepPlanExpected, ...]
    program_text: str


class Term(Section):
    """A term.

    Attributes
    ----------
    name : str
        Name in the task.
    unit : str
        Unit of all values.
    value : float
        Residual that the tables leave.
    standard_error : float
        Standard error of the value.
    from_ : float
        Sum of the updates since the beginning.
    to : float
        That sum if this probing's update is applied.
    verdict : str
        `keep`, `update` or `refused`.
    reason : str | None
        Why it is refused.
    largest_update : float
        Largest single update.
    largest_total : float
        Largest sum of updates.
    significance : float
        Number of standard errors beyond which the term has moved.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    unit: str
    value: float
    standard_error: float
    from_: float
    to: float
    verdict: str
    reason: str | None
    largest_update: float
    largest_total: float
    significance: float


class BallPlace(Section):
    """Position of a ball in workpiece coordinates.

    Attributes
    ----------
    name : str
        Name of the ball.
    centre_mm : NDArray[np.float64]
        Centre of the ball, mm.
    standard_error_um : NDArray[np.float64]
        Standard errors, µm.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    centre_mm: NDArray[np.float64]
    standard_error_um: NDArray[np.float64]


class Known(Section):
    """A value and its uncertainty, in the unit of its key.

    Attributes
    ----------
    value : float
        The value.
    uncertainty : float | None
        Standard uncertainty (k = 1); `None`: not known.
    degrees_of_freedom : float | None
        Degrees of freedom of the uncertainty; `None`: well known.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    value: float
    uncertainty: float | None
    degrees_of_freedom: float | None


class Decision(Section):
    """Decision on a finding; in JSON `why` is a sentence.

    Attributes
    ----------
    key : str
        Full name of the key.
    old : Known | None
        The value that the machine states, `old` in JSON; `None`: nothing.
    found : Known
        The found value in total.
    written : Known | None
        The value written; `None`: the stated value stays.
    why : Any
        Reason.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"old": Known, "found": Known, "written": Known}
    key: str
    old: Known | None
    found: Known
    written: Known | None
    why: Any


class Reprobing(Result):
    """Result of `keep_begin`, `keep_check`, `keep_apply`.

    Attributes
    ----------
    machine : str
        The machine's name.
    entry : int
        Number that the probing's entry has or would have.
    touches : int
        Number of touches.
    sigma_um : float
        Standard deviation of a touch, from the residuals.
    terms : tuple[Term, ...]
        Every term.
    balls : tuple[BallPlace, ...]
        Every ball.
    updates : int
        Number of terms changed.
    refused : int
        Number of terms out of their bounds.
    applied : bool
        Whether the files were changed.
    written : tuple[Decision, ...]
        Decisions on every moved term that has its own figure; empty if a term is refused.
    notes : tuple[str, ...]
        Caveats on the result.
    changes : tuple[str, ...]
        A sentence on each change.
    files : Section
        Changed files of the machine as texts, by name, with `files=True`.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"terms": Term, "balls": BallPlace, "written": Decision}
    machine: str
    entry: int
    touches: int
    sigma_um: float
    terms: tuple[Term, ...]
    balls: tuple[BallPlace, ...]
    updates: int
    refused: int
    applied: bool
    written: tuple[Decision, ...]
    notes: tuple[str, ...]
    changes: tuple[str, ...]
    files: Section


class ProbingRun(Section):
    """A run.

    Attributes
    ----------
    run : int
        Number of the run.
    points : int
        Number of points.
    spindle_deg : float | None
        Orientation of the spindle; null if not recorded.
    centre_mm : NDArray[np.float64]
        Centre, or mean of the points.
    diameter_mm : float | None
        Diameter of the least-squares circle or sphere through the tip's centres.
    form_um : float | None
        P_FTU,2D for a ring, P_FTU,3D for a sphere.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    run: int
    points: int
    spindle_deg: float | None
    centre_mm: NDArray[np.float64]
    diameter_mm: float | None
    form_um: float | None


class Spread(Section):
    """Scatter of places along X, Y, Z.

    Attributes
    ----------
    count : int
        Number of places.
    range_um : NDArray[np.float64]
        Largest minus smallest.
    standard_deviation_um : NDArray[np.float64] | None
        Standard deviation; null for a single place.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    count: int
    range_um: NDArray[np.float64]
    standard_deviation_um: NDArray[np.float64] | None


class Value(Section):
    """A value with its standard error.

    Attributes
    ----------
    value : float
        The value.
    standard_error : float
        Standard error, same unit.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    value: float
    standard_error: float


class Offset(Section):
    """Offset of the stylus tip from the spindle's axis.

    Attributes
    ----------
    x_um : Value
        Along X at spindle orientation 0.
    y_um : Value
        Along Y at spindle orientation 0.
    length_um : float
        Length of the offset.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"x_um": Value, "y_um": Value}
    x_um: Value
    y_um: Value
    length_um: float


class Probing(Result):
    """Result of `evaluate_probing`.

    Attributes
    ----------
    feature : str
        "ring", "sphere" or "point".
    runs : tuple[ProbingRun, ...]
        Results by run.
    p_ftu_um : float | None
        Largest P_FTU over the runs; null for points.
    p_ftu_name : str | None
        `P_FTU,2D` or `P_FTU,3D`.
    point_repeatability : Spread | None
        Repeatability of a single point, over all points of a feature `point`.
    location_repeatability : Spread | None
        Repeatability of a location: the runs' centres, corrected for spindle orientation.
    tip_offset : Offset | None
        Offset of the stylus tip; null without orientations.
    effective_tip_diameter_mm : float | None
        Effective diameter of the tip from the calibrated diameter; null without one.
    diameter_range_um : float | None
        Range of the diameters over the runs.
    notes : tuple[str, ...]
        Remarks on the figures.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"runs": ProbingRun, "point_repeatability": Spread, "location_repeatability": Spread, "tip_offset": Offset}
    feature: str
    runs: tuple[ProbingRun, ...]
    p_ftu_um: float | None
    p_ftu_name: str | None
    point_repeatability: Spread | None
    location_repeatability: Spread | None
    tip_offset: Offset | None
    effective_tip_diameter_mm: float | None
    diameter_range_um: float | None
    notes: tuple[str, ...]


class Channel(Section):
    """Drift of one displacement or tilt.

    Attributes
    ----------
    name : str
        X1, Y1, Z, X2, Y2, A, B.
    unit : str
        `um` or `urad`.
    range : float
        Range over the whole test.
    first_period : float
        Range within the first period.
    worst_period : float
        Largest range within any period.
    worst_from_min : float
        Start of that period.
    end : float
        Last minus first reading.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    unit: str
    range: float
    first_period: float
    worst_period: float
    worst_from_min: float
    end: float


class Place(Section):
    """Results at one position of the moving axis.

    Attributes
    ----------
    position : int
        Number of the position; 0 if the record names none.
    readings : int
        Number of readings.
    channels : tuple[Channel, ...]
        Displacements and tilts.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"channels": Channel}
    position: int
    readings: int
    channels: tuple[Channel, ...]


class Temperature(Section):
    """A temperature.

    Attributes
    ----------
    name : str
        `ambient`, `spindle`, `machine`.
    range_c : NDArray[np.float64]
        Smallest and largest temperature, °C.
    worst_period_k : float
        Largest range within any period, K.
    end_k : float
        Last minus first, K.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    range_c: NDArray[np.float64]
    worst_period_k: float
    end_k: float


class ThermalTest(Result):
    """Result of `evaluate_thermal`.

    Attributes
    ----------
    test : str
        "etve", "spindle" or "axis".
    duration_min : float
        Length of the record.
    period_min : float
        The period.
    positions : tuple[Place, ...]
        Results by position.
    temperatures : tuple[Temperature, ...]
        Temperatures recorded.
    notes : tuple[str, ...]
        Remarks on the figures.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"positions": Place, "temperatures": Temperature}
    test: str
    duration_min: float
    period_min: float
    positions: tuple[Place, ...]
    temperatures: tuple[Temperature, ...]
    notes: tuple[str, ...]


class DiagonalFigures(Section):
    """Figures of one diagonal according to ISO 230-6.

    Attributes
    ----------
    diagonal : int
        Number of the diagonal.
    unit : NDArray[np.float64]
        Unit vector from the first to the last target.
    length_mm : float
        Length of the diagonal.
    targets : int
        Number of targets on it.
    e_um : float
        E(D): systematic deviation of positioning.
    b_um : float | None
        B(D): reversal value; null with one direction.
    m_um : float
        M(D): range of the mean deviation.
    r_um : float | None
        R(D): repeatability; null with one run.
    slope_ppm : Value
        Slope of the deviation.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"slope_ppm": Value}
    diagonal: int
    unit: NDArray[np.float64]
    length_mm: float
    targets: int
    e_um: float
    b_um: float | None
    m_um: float
    r_um: float | None
    slope_ppm: Value


class Point(Section):
    """Errors of an axis at a position, slopes removed.

    Attributes
    ----------
    position_mm : float
        Position of the axis.
    error_um : NDArray[np.float64]
        Errors along X, Y, Z.
    standard_error_um : NDArray[np.float64]
        Standard errors of these.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    position_mm: float
    error_um: NDArray[np.float64]
    standard_error_um: NDArray[np.float64]


class Shape(Section):
    """Shape of an axis' errors.

    Attributes
    ----------
    axis : str
        The axis that moves.
    points : tuple[Point, ...]
        Errors by position.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"points": Point}
    axis: str
    points: tuple[Point, ...]


class Steps(Section):
    """Results that the vector method adds.

    Attributes
    ----------
    scales_if_aligned_ppm : NDArray[np.float64]
        Scales of X, Y, Z if the mirror was exactly square.
    scales_ppm : tuple[Value, ...] | None
        Scales with the stated uncertainty of the alignment; null if none is stated.
    scale_per_10_urad_ppm : NDArray[np.float64]
        Change of a scale for a mirror 10 µrad off on every diagonal.
    shapes : tuple[Shape, ...]
        EXX, EYX, EZX and so on, slopes removed.
    sigma_um : float
        Standard deviation of a step, from the redundant equation of each step.
    degrees_of_freedom : int
        Number of redundant equations.
    condition : float
        Condition number of the equations of a step.
    beside_mm : float
        Largest distance of a target from its diagonal.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"scales_ppm": Value, "shapes": Shape}
    scales_if_aligned_ppm: NDArray[np.float64]
    scales_ppm: tuple[Value, ...] | None
    scale_per_10_urad_ppm: NDArray[np.float64]
    shapes: tuple[Shape, ...]
    sigma_um: float
    degrees_of_freedom: int
    condition: float
    beside_mm: float


class StepDiagonal(Result):
    """Result of `evaluate_step_diagonal`.

    Attributes
    ----------
    readings : int
        Number of readings in the record.
    test : str
        "diagonal" or "step-diagonal".
    diagonals : tuple[DiagonalFigures, ...]
        Figures of every diagonal.
    e_d_um : float
        E_d: largest E(D).
    b_d_um : float | None
        B_d: largest B(D).
    m_d_um : float
        M_d: largest M(D).
    r_d_um : float | None
        R_d: largest R(D).
    a0z_urad : Value
        A0Z.
    b0z_urad : Value
        B0Z.
    c0y_urad : Value
        C0Y.
    diagonal_scale_ppm : Value
        Scale along a diagonal: Σ u_i² s_i.
    rank : int
        Rank of the four slopes.
    condition : float
        Condition number of the four equations.
    sigma_um : float | None
        Standard deviation of a reading, from repeats; null without repeats.
    steps : Steps | None
        Results of the steps; null without steps.
    limits : tuple[str, ...]
        Limits of the method, one sentence each.
    written : tuple[Section, ...]
        Decision on every value found, if a machine is given: key, old, found, written, why.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"diagonals": DiagonalFigures, "a0z_urad": Value, "b0z_urad": Value, "c0y_urad": Value, "diagonal_scale_ppm": Value, "steps": Steps}
    readings: int
    test: str
    diagonals: tuple[DiagonalFigures, ...]
    e_d_um: float
    b_d_um: float | None
    m_d_um: float
    r_d_um: float | None
    a0z_urad: Value
    b0z_urad: Value
    c0y_urad: Value
    diagonal_scale_ppm: Value
    rank: int
    condition: float
    sigma_um: float | None
    steps: Steps | None
    limits: tuple[str, ...]
    written: tuple[Section, ...]


class RTestTerm(Section):
    """A location error.

    Attributes
    ----------
    name : str
        Name, such as `EX0C`.
    unit : str
        `um` or `urad`.
    value : float
        Value of the error.
    standard_error : float
        Standard error of the value.
    before : float
        Value in the machine before the test.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    unit: str
    value: float
    standard_error: float
    before: float


class RTest(Result):
    """Result of `evaluate_r_test`.

    Attributes
    ----------
    readings : int
        Number of readings in the record.
    balls : int
        Number of balls.
    range_um : NDArray[np.float64]
        Range of the displacements along X, Y, Z over all readings (ISO 10791-6, tests BK).
    terms : tuple[RTestTerm, ...]
        Location errors found.
    covariance : Covariance
        Covariance of the location errors; its diagonal has the squares of their standard errors.
    balls_um : tuple[NDArray[np.float64], ...]
        Offsets of the balls from their commanded places, workpiece's frame.
    sensor_um : NDArray[np.float64] | None
        Zero of the nest, tool's frame; null if the nest was calibrated.
    rms_um : float
        Root mean square of the readings, without the balls' places.
    left_rms_um : float
        Root mean square of the residuals.
    left_max_um : float
        Largest residual.
    left_max_line : int
        Line of the largest residual.
    sigma_um : float
        Standard deviation of a coordinate.
    degrees_of_freedom : int
        Coordinates minus unknowns.
    rank : int
        Rank: all unknowns.
    condition : float
        Condition number of the scaled columns.
    notes : tuple[str, ...]
        Remarks on the result.
    written : tuple[Section, ...]
        Decision on every value found, if a machine is given: key, old, found, written, why.
    residuals_um : NDArray[np.float64]
        Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"terms": RTestTerm, "covariance": Covariance}
    readings: int
    balls: int
    range_um: NDArray[np.float64]
    terms: tuple[RTestTerm, ...]
    covariance: Covariance
    balls_um: tuple[NDArray[np.float64], ...]
    sensor_um: NDArray[np.float64] | None
    rms_um: float
    left_rms_um: float
    left_max_um: float
    left_max_line: int
    sigma_um: float
    degrees_of_freedom: int
    rank: int
    condition: float
    notes: tuple[str, ...]
    written: tuple[Section, ...]
    residuals_um: NDArray[np.float64]


class Function(Section):
    """One of the 21 errors.

    Attributes
    ----------
    name : str
        Name, such as `EXX`.
    unit : str
        `um` or `urad`.
    range : NDArray[np.float64]
        Smallest and largest value.
    standard_error : float
        Root mean square of the standard errors of the nodes.
    worst_standard_error : float
        Largest standard error of a node.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    unit: str
    range: NDArray[np.float64]
    standard_error: float
    worst_standard_error: float


class Squareness(Section):
    """Squarenesses.

    Attributes
    ----------
    a0z_urad : Value
        A0Z.
    b0z_urad : Value
        B0Z.
    c0y_urad : Value
        C0Y.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"a0z_urad": Value, "b0z_urad": Value, "c0y_urad": Value}
    a0z_urad: Value
    b0z_urad: Value
    c0y_urad: Value


class Left(Section):
    """Lengths of vectors over points.

    Attributes
    ----------
    points : int
        Number of points.
    max_um : float
        Largest.
    rms_um : float
        Root mean square.
    line : int
        Line of the largest length.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    points: int
    max_um: float
    rms_um: float
    line: int


class MeasuredPoints(Result):
    """Result of `evaluate_points`.

    Attributes
    ----------
    points : int
        Number of points in the file.
    nodes : NDArray[np.int64]
        Number of nodes of X, Y, Z.
    functions : tuple[Function, ...]
        Errors that the tables contain.
    squareness : Squareness
        Squareness.
    covariance : Covariance
        Covariance of the squarenesses; its diagonal has the squares of their standard errors. The errors of the axes have too many nodes for a matrix.
    unseen : tuple[str, ...]
        Angular errors that the points do not determine, left at zero.
    before : Left
        Deviation of the points, without the instrument's placement.
    left : Left
        Residual of all points with the errors in the machine, by its own model.
    held_out : Left | None
        Residual of every tenth point in a fit without them; null with fewer than 60 points.
    shift_mm : NDArray[np.float64]
        Shift of the instrument, mm.
    turn_urad : NDArray[np.float64]
        Rotation of the instrument, µrad.
    offsets_um : tuple[NDArray[np.float64], ...]
        Errors of the reflectors' offsets, from the second reflector on.
    sigma_um : float
        Standard deviation of a coordinate (with mean stated uncertainty), from the residuals.
    sigma_over_stated : float | None
        Ratio of the residuals to the stated uncertainties; null if none are stated.
    degrees_of_freedom : int
        Coordinates minus unknowns.
    unknowns : int
        Number of unknowns.
    conventions : int
        Number of conditions that fix the quantities which no point determines.
    rank : int
        Rank of points and conditions.
    condition : float
        Condition number of the scaled columns.
    smoothing : float
        Weight of second differences of the tables relative to a reading.
    notes : tuple[str, ...]
        Remarks on the result.
    residuals_um : NDArray[np.float64]
        Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"functions": Function, "squareness": Squareness, "covariance": Covariance, "before": Left, "left": Left, "held_out": Left}
    points: int
    nodes: NDArray[np.int64]
    functions: tuple[Function, ...]
    squareness: Squareness
    covariance: Covariance
    unseen: tuple[str, ...]
    before: Left
    left: Left
    held_out: Left | None
    shift_mm: NDArray[np.float64]
    turn_urad: NDArray[np.float64]
    offsets_um: tuple[NDArray[np.float64], ...]
    sigma_um: float
    sigma_over_stated: float | None
    degrees_of_freedom: int
    unknowns: int
    conventions: int
    rank: int
    condition: float
    smoothing: float
    notes: tuple[str, ...]
    residuals_um: NDArray[np.float64]


class Candidate(Section):
    """A model that was compared.

    Attributes
    ----------
    model : str
        Name of the model.
    unknowns : int
        Number of unknowns.
    rank : int
        Number of unknowns that the points determine.
    held_out_um : float | None
        Root mean square of the predictions' errors at held-out points, µm; null if the points do not determine the model.
    left_um : float
        Root mean square of the residuals of all points, µm.
    degrees_of_freedom : int
        Coordinates minus rank.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    model: str
    unknowns: int
    rank: int
    held_out_um: float | None
    left_um: float
    degrees_of_freedom: int


class PlaneTerm(Section):
    """A scale or squareness.

    Attributes
    ----------
    name : str
        `scale X`, `C0Y` and the like.
    unit : str
        `ppm` or `urad`.
    value : float
        The value.
    standard_error : float
        Standard error, same unit.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    unit: str
    value: float
    standard_error: float


class MeasuredPlaneTransfer(Section):
    """Result of the test.

    Attributes
    ----------
    record : str
        Name of the other record.
    points : int
        Number of its points.
    before_um : float
        Its deviations after a rigid alignment, root mean square, µm.
    after_um : float
        The same after the terms are subtracted, µm.
    own_um : float | None
        Held-out residual of the same model fitted to this record itself, µm; null if the record does not determine it.
    areas : int
        Number of areas.
    p : float
        Probability of so large a reduction if the terms do nothing.
    level : float
        Largest p at which the terms count as transferable.
    transfers : bool
        Whether the terms transfer.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    record: str
    points: int
    before_um: float
    after_um: float
    own_um: float | None
    areas: int
    p: float
    level: float
    transfers: bool


class MeasuredPlane(Result):
    """Result of `evaluate_points`.

    Attributes
    ----------
    points : int
        Number of points in the file.
    shape : str
        `plane`: of two axes; `line`: along an axis; `inclined plane`.
    plane : tuple[str, ...]
        Letters of the axes of the plane; of a line's axis and the axis across it; for an inclined plane, of the axes next to its two directions.
    model : str
        Name of the chosen model.
    models : tuple[Candidate, ...]
        All models that were compared.
    before : Left
        Deviations of the points in the plane, without the plate's placement.
    left : Left
        Residuals of all points.
    held_out : Left
        Residuals of the points in fits that each lack a tenth of them, among these the point.
    sigma_um : float
        Standard deviation of a coordinate, from the residuals: noise and what the model does not describe.
    sigma_over_stated : float | None
        Ratio of the residuals to the stated uncertainties; null if none are stated.
    degrees_of_freedom : int
        Coordinates minus rank.
    unknowns : int
        Number of unknowns of the chosen model.
    rank : int
        Number of them that the points determine.
    terms : tuple[PlaneTerm, ...]
        Scales and squareness; empty for a map.
    functions : tuple[Function, ...]
        Errors that the tables contain; empty for a map.
    map_um : NDArray[np.float64] | None
        Largest errors of the map along both axes, µm; null for tables.
    nodes : NDArray[np.int64]
        Nodes of the tables or of the grid along both axes.
    grid_off_um : float | None
        Largest difference between grid and map at the points, µm; null for tables.
    shift_mm : NDArray[np.float64]
        Shift of the plate, mm.
    turn_urad : float
        Rotation of the plate from the first axis toward the second, µrad.
    not_determined : tuple[str, ...]
        Terms that points which lie like these do not determine, and the combinations of them that they do.
    left_alone : tuple[str, ...]
        Errors and axes that the points do not show.
    transfer : MeasuredPlaneTransfer | None
        Test on another record; null without one.
    notes : tuple[str, ...]
        Remarks on the result.
    residuals_um : NDArray[np.float64]
        Residuals of the fit, µm, with `residuals=True`: one a touch, or one row a reading, a measured point or a sample.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"models": Candidate, "before": Left, "left": Left, "held_out": Left, "terms": PlaneTerm, "functions": Function, "transfer": MeasuredPlaneTransfer}
    points: int
    shape: str
    plane: tuple[str, ...]
    model: str
    models: tuple[Candidate, ...]
    before: Left
    left: Left
    held_out: Left
    sigma_um: float
    sigma_over_stated: float | None
    degrees_of_freedom: int
    unknowns: int
    rank: int
    terms: tuple[PlaneTerm, ...]
    functions: tuple[Function, ...]
    map_um: NDArray[np.float64] | None
    nodes: NDArray[np.int64]
    grid_off_um: float | None
    shift_mm: NDArray[np.float64]
    turn_urad: float
    not_determined: tuple[str, ...]
    left_alone: tuple[str, ...]
    transfer: MeasuredPlaneTransfer | None
    notes: tuple[str, ...]
    residuals_um: NDArray[np.float64]


class AtPointSpread(Section):
    """Spread of the position along X, Y, Z in machine directions.

    Attributes
    ----------
    standard_um : NDArray[np.float64]
        Standard uncertainties.
    factor : NDArray[np.float64] | None
        Coverage factors; null for the machines drawn.
    degrees_of_freedom : tuple[float | None, ...] | None
        Effective degrees of freedom; null if infinite.
    expanded_um : NDArray[np.float64]
        Expanded uncertainties: half-widths of intervals of the requested coverage.
    radius_um : float
        Radius of the sphere that contains the position with that coverage.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    standard_um: NDArray[np.float64]
    factor: NDArray[np.float64] | None
    degrees_of_freedom: tuple[float | None, ...] | None
    expanded_um: NDArray[np.float64]
    radius_um: float


class AtPoint(Section):
    """Uncertainty of the corrected position at a point, by both methods.

    Attributes
    ----------
    at : Section
        Position by letter, mm and degrees.
    jacobian : AtPointSpread
        First-order result, from the derivatives.
    monte_carlo : AtPointSpread
        Result from the machines drawn.
    difference : float
        Radius from the machines drawn over the first-order radius, minus 1.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"jacobian": AtPointSpread, "monte_carlo": AtPointSpread}
    at: Section
    jacobian: AtPointSpread
    monte_carlo: AtPointSpread
    difference: float


class UncertaintyShare(Section):
    """Contribution of a quantity.

    Attributes
    ----------
    term : str
        Name of the quantity.
    rms_um : float
        Root mean square over the working volume of its contribution to the standard uncertainty, by itself.
    share : float
        Share of the variance over the working volume: of a correlated quantity with half of what it has in common with each other one, which may be negative. All shares add up to 1.
    worst_um : float
        Contribution at the worst point, by itself.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    term: str
    rms_um: float
    share: float
    worst_um: float


class Uncertainty(Result):
    """Result of `Machine.uncertainty`.

    Attributes
    ----------
    machine : str
        Name of the machine.
    confidence_percent : float
        Requested coverage.
    tool_mm : NDArray[np.float64]
        Tip from the last tool-side frame.
    volume_mm : Section
        Ends of the working volume by letter.
    pose_deg : Section
        Positions of the rotary axes over the working volume.
    points : int
        Number of grid points over the working volume.
    standard_rms_um : float
        Root mean square over the grid of the standard uncertainty of the position, √tr Σ.
    worst : AtPoint
        The point with the largest radius.
    at : AtPoint | None
        The requested position.
    contributions : tuple[UncertaintyShare, ...]
        Contributions, largest share first.
    not_stated : tuple[str, ...]
        Keys that are not stated and count as zero.
    trials : int
        Number of machines drawn for the check.
    seed : int
        Seed of the draws.
    warnings : tuple[str, ...]
        Remarks on the result.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"worst": AtPoint, "at": AtPoint, "contributions": UncertaintyShare}
    machine: str
    confidence_percent: float
    tool_mm: NDArray[np.float64]
    volume_mm: Section
    pose_deg: Section
    points: int
    standard_rms_um: float
    worst: AtPoint
    at: AtPoint | None
    contributions: tuple[UncertaintyShare, ...]
    not_stated: tuple[str, ...]
    trials: int
    seed: int
    warnings: tuple[str, ...]


class Contribution(Section):
    """Contribution of a term of the machine.

    Attributes
    ----------
    term : str
        Name of the term: of its errors those of ISO 230-1.
    standard_um : float
        Contribution to the standard uncertainty; their squares add up to its square, those of negative ones subtracted.
    share : float
        Share of the variance after the squares of the effects of each quantity alone, of a correlated one with half of what it has in common with each other one: negative where that makes the whole smaller. All shares add up to 1.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    term: str
    standard_um: float
    share: float


class Predicted(Section):
    """A toleranced characteristic of a feature.

    Attributes
    ----------
    feature : str
        Name of the feature.
    kind : str
        The characteristic.
    association : str | None
        How a form is associated with its points: `least squares` or `minimum zone`.
    datums : tuple[str, ...]
        Names of the datums; of a distance: the other feature.
    uncorrected_um : float
        Predicted value without correction.
    corrected_um : float
        Predicted value with the machine's correction.
    everything_um : float | None
        Predicted value with the servo and all that the machine configures against its error; absent without a run.
    limits_um : tuple[float | None, ...]
        Least and greatest value that the tolerance permits; a zone has no least.
    expanded_um : float | None
        Expanded uncertainty: half of the interval.
    interval_um : Interval | None
        Interval that contains the true value.
    conformance : float | None
        Probability that the true value is within the limits, 0 … 1.
    verdict : str | None
        `conforms`, `does not conform` or `undecided`, after ISO 14253-1.
    parts_cut : int | None
        Drawn parts cut by exact transforms that gave the interval; `null` if the derivatives did.
    budget : tuple[Contribution, ...] | None
        Contributions, largest first.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"interval_um": Interval, "budget": Contribution}
    feature: str
    kind: str
    association: str | None
    datums: tuple[str, ...]
    uncorrected_um: float
    corrected_um: float
    everything_um: float | None
    limits_um: tuple[float | None, ...]
    expanded_um: float | None
    interval_um: Interval | None
    conformance: float | None
    verdict: str | None
    parts_cut: int | None
    budget: tuple[Contribution, ...] | None


class SetupStart(Section):
    """When a further set-up starts in a record.

    Attributes
    ----------
    name : str
        Its name.
    start_s : float
        Start of its program after the record's first row.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    start_s: float


class SensorTemperature(Section):
    """Temperatures of a sensor.

    Attributes
    ----------
    name : str
        Its name; `machine` if the temperature is constant.
    celsius : NDArray[np.float64]
        At the first and last cut.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    celsius: NDArray[np.float64]


class AxisGrowth(Section):
    """Growth of an axis where the part is.

    Attributes
    ----------
    axis : str
        Letter of the axis.
    unit : str
        `um` or `urad`.
    growth : NDArray[np.float64]
        At the first and last cut.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    axis: str
    unit: str
    growth: NDArray[np.float64]


class PredictedPartTemperature(Section):
    """Temperatures while a part is cut.

    Attributes
    ----------
    record : str | None
        The record; absent at a constant temperature.
    start_s : float | None
        Start of the program after the record's first row.
    setups : tuple[SetupStart, ...]
        Starts of the further set-ups after the record's first row; none at a constant temperature.
    cut_s : NDArray[np.float64] | None
        First and last cut of a feature after the start of the program.
    sensors : tuple[SensorTemperature, ...]
        Temperatures of the machine at the first and last cut; none if only the part's counts.
    growth : tuple[AxisGrowth, ...]
        Growth of the machine at the first and last cut.
    part_c : float | None
        Temperature of the part.
    part_expansion_um_per_m_k : float | None
        Expansion of the part.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"setups": SetupStart, "sensors": SensorTemperature, "growth": AxisGrowth}
    record: str | None
    start_s: float | None
    setups: tuple[SetupStart, ...]
    cut_s: NDArray[np.float64] | None
    sensors: tuple[SensorTemperature, ...]
    growth: tuple[AxisGrowth, ...]
    part_c: float | None
    part_expansion_um_per_m_k: float | None


class Servo(Section):
    """How the servo was simulated.

    Attributes
    ----------
    rate_hz : float
        Servo rate.
    machines : tuple[str, ...]
        Simulated machines, by how they are driven.
    simulated_s : float
        Simulated time of each machine.
    moves : NDArray[np.int64]
        Moves simulated, and moves of the programs.
    plants : int
        Further machines with everything on, whose drives differ from the stated figures.
    figures : tuple[str, ...]
        Uncertain figures of the drives.
    departure : float | None
        How far parts cut with all figures drawn at once are from the sum of their single effects: root mean square as a share of the scatter, the largest of all characteristics; absent without uncertain figures.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    rate_hz: float
    machines: tuple[str, ...]
    simulated_s: float
    moves: NDArray[np.int64]
    plants: int
    figures: tuple[str, ...]
    departure: float | None


class Measurement(Section):
    """A measurement.

    Attributes
    ----------
    name : str
        Instrument, and where or along which axis it is used.
    minutes : float
        Time.
    in_task : bool
        Whether it is part of the task of `calibrate plan`.
    file : str | None
        The owner's own task of `calibrate plan`, if it is one.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    name: str
    minutes: float
    in_task: bool
    file: str | None


class AdvisedLeft(Section):
    """A term that keeps a feature uncertain after the measurements.

    Attributes
    ----------
    term : str
        Name of the term.
    share : float
        Share of the variance that is left, 0 … 1.
    is_measured : bool
        Whether one of the measurements depends on it.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    term: str
    share: float
    is_measured: bool


class Advised(Section):
    """A characteristic before and after the measurements.

    Attributes
    ----------
    feature : str
        Name of the feature.
    kind : str
        The characteristic.
    before_um : float
        Expanded uncertainty before the measurements.
    after_um : float
        Expanded uncertainty after them.
    least_um : float
        Expanded uncertainty after every measurement that is possible.
    interval_um : Interval
        Interval expected after the measurements, if they confirm the predicted value.
    verdict_before : str
        Verdict before.
    verdict_after : str
        Verdict expected after.
    left : tuple[AdvisedLeft, ...]
        What keeps an undecided feature uncertain.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"interval_um": Interval, "left": AdvisedLeft}
    feature: str
    kind: str
    before_um: float
    after_um: float
    least_um: float
    interval_um: Interval
    verdict_before: str
    verdict_after: str
    left: tuple[AdvisedLeft, ...]


class Placed(Section):
    """A place of the part.

    Attributes
    ----------
    at_mm : NDArray[np.float64]
        Program zero in machine coordinates.
    conform : NDArray[np.int64]
        Characteristics that conform where the part is, and at this place.
    here : float
        Largest end of an interval as a share of the tolerance, where the part is.
    there : float
        The same at this place.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    at_mm: NDArray[np.float64]
    conform: NDArray[np.int64]
    here: float
    there: float


class Directed(Section):
    """A feature cut in the other direction.

    Attributes
    ----------
    feature : str
        The feature.
    kind : str
        The characteristic that improves most.
    here : float
        Its largest end as a share of the tolerance, as programmed.
    there : float
        The same in the other direction.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    feature: str
    kind: str
    here: float
    there: float


class Advice(Section):
    """What to do about a predicted part.

    Attributes
    ----------
    measurements : tuple[Measurement, ...]
        A short set of measurements with which most characteristics get a verdict, in the order of the part's file.
    exact : bool
        Whether it is the shortest of all sets: every set was compared.
    minutes : float
        Time of all of them.
    features : tuple[Advised, ...]
        Every toleranced characteristic before and after them, in the order of the part.
    compared : tuple[str, ...]
        Measurements that are possible and were compared.
    left_out : tuple[str, ...]
        Measurements that are not possible, and why.
    independent : tuple[str, ...]
        Lasers that are used along several axes: what is common to these uses, such as the wavelength, is taken as independent.
    place : Placed | None
        Where on the table the part is better, before the measurements.
    places_compared : int | None
        Number of places compared.
    places_refused : int | None
        Number of places refused: the part or its correction leaves the travel there.
    directions : tuple[Directed, ...] | None
        Features that are better cut in the other direction.
    without_servo : bool | None
        Whether the prediction has the servo, without which all of them are compared.
    corrected : tuple[str, ...]
        Characteristics to which the correction gives another verdict, in words.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"measurements": Measurement, "features": Advised, "place": Placed, "directions": Directed}
    measurements: tuple[Measurement, ...]
    exact: bool
    minutes: float
    features: tuple[Advised, ...]
    compared: tuple[str, ...]
    left_out: tuple[str, ...]
    independent: tuple[str, ...]
    place: Placed | None
    places_compared: int | None
    places_refused: int | None
    directions: tuple[Directed, ...] | None
    without_servo: bool | None
    corrected: tuple[str, ...]


class PredictedPart(Budgeted):
    """Result of `predict`.

    Attributes
    ----------
    part : str
        Name of the part.
    program : str
        Name of the program.
    machine : str
        Name of the machine.
    at_mm : NDArray[np.float64]
        Program zero in machine coordinates.
    confidence_percent : float
        Coverage of the intervals.
    trials : int
        Number of machines drawn.
    seed : int
        Seed of the draws.
    features : tuple[Predicted, ...]
        A toleranced characteristic each, in the order of the part.
    temperature : PredictedPartTemperature | None
        Temperatures while the part is cut, where they are known.
    servo : Servo | None
        The runs of the servo; `uncorrected_um` and `corrected_um` include its error then.
    not_stated : tuple[str, ...]
        Keys of the machine that are not stated; their uncertainty counts as zero.
    warnings : tuple[str, ...]
        Remarks: on the machine's uncertainties, and on limits that reduce its correction.
    advice : Advice | None
        What to do about it, where asked for.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"features": Predicted, "temperature": PredictedPartTemperature, "servo": Servo, "advice": Advice}
    part: str
    program: str
    machine: str
    at_mm: NDArray[np.float64]
    confidence_percent: float
    trials: int
    seed: int
    features: tuple[Predicted, ...]
    temperature: PredictedPartTemperature | None
    servo: Servo | None
    not_stated: tuple[str, ...]
    warnings: tuple[str, ...]
    advice: Advice | None


class HelicoidPoint(Section):
    """One row of the result.

    Attributes
    ----------
    u_rad : float
        Roll angle u, rad.
    theta_rad : float
        Angle θ, rad.
    x_mm : float
        X, mm.
    y_mm : float
        Y, mm.
    z_mm : float
        Z, mm.
    a_deg : float
        A, degrees.
    c_deg : float
        C, degrees; continuous over full turns.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    u_rad: float
    theta_rad: float
    x_mm: float
    y_mm: float
    z_mm: float
    a_deg: float
    c_deg: float


class Helicoid(Result):
    """Result of `helicoid`.

    Attributes
    ----------
    inputs : Any
        The request.
    surface : Any
        The flank.
    gear : Any
        Null if the request states the base cylinder.
    points : tuple[HelicoidPoint, ...]
        Points of the grid, with u varying slowest.
    program : str
        Text of the program, with `gcode=True`.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"points": HelicoidPoint}
    inputs: Any
    surface: Any
    gear: Any
    points: tuple[HelicoidPoint, ...]
    program: str


class LearnedSize(Section):
    """Magnitudes of an error.

    Attributes
    ----------
    max_um : float
        Largest.
    rms_um : float
        Root mean square.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    max_um: float
    rms_um: float


class Learned(Result):
    """Result of `learn`.

    Attributes
    ----------
    program_id : str
        Identifier of the path, hexadecimal.
    machine_id : str
        Identifier of the machine, hexadecimal.
    length_mm : float
        Length of the path.
    parts : int
        Parts learned from.
    nodes : int
        Number of nodes of the correction.
    spacing_mm : float
        Distance of the nodes.
    gain : float
        Gain L of the law.
    forget : float
        Forgetting f of the law.
    cutoff_mm : float
        Cut-off of the low-pass Q along the path.
    before : LearnedSize
        Contour error of the recorded part.
    predicted : LearnedSize
        Contour error with the new correction, if a correction moves the tip by its full amount.
    correction_um : float
        Largest component of the new correction.
    unmeasured : float
        Share of the path without a measured error.
    table : bytes
        Content of the .tlearn for the next part.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"before": LearnedSize, "predicted": LearnedSize}
    program_id: str
    machine_id: str
    length_mm: float
    parts: int
    nodes: int
    spacing_mm: float
    gain: float
    forget: float
    cutoff_mm: float
    before: LearnedSize
    predicted: LearnedSize
    correction_um: float
    unmeasured: float
    table: bytes


class Transfer(Result):
    """Result of `import_table`, `export_table`.

    Attributes
    ----------
    format : str
        Name of the format.
    meaning : str
        Sign and unit of the values in the format.
    written : tuple[str, ...]
        The files written.
    left_out : tuple[str, ...]
        Settings that the format cannot store and that were left out.
    notes : tuple[str, ...]
        Notes on what was read, set or changed.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    format: str
    meaning: str
    written: tuple[str, ...]
    left_out: tuple[str, ...]
    notes: tuple[str, ...]


class ReportedFault(Section):
    """A fault that a machine reported over consecutive cycles.

    Attributes
    ----------
    time_s : float
        Time, s from the start of the program.
    fault : str
        Name of the fault.
    code : int
        Code of the fault.
    axis : str
        Faulty axis.
    line : int
        Program line.
    cycles : int
        Number of cycles.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    time_s: float
    fault: str
    code: int
    axis: str
    line: int
    cycles: int


class Note(Section):
    """A kind of word that was accepted although it does not change the path.

    Attributes
    ----------
    word : str
        The word, without its value if that does not matter.
    count : int
        Number of times it occurs.
    line : int
        Line in which it first occurs, from 1.
    why : str
        Reason why it has no effect, or the effect it has instead; empty if that is obvious.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {}
    word: str
    count: int
    line: int
    why: str


class Run(Result):
    """Result of `simulate`.

    Attributes
    ----------
    machine : str
        Name of the machine.
    program : str
        Name of the program.
    settings : Section
        All settings.
    cycles : int
        Cycles of the program.
    servo_rate_hz : float
        Servo rate, Hz.
    contour_error_um : Any
        True contour error of the tool tip while cutting, µm.
    orientation_error_urad : Any
        True angle between the tool and the programmed direction, µrad; programs with rotary axes only.
    estimated_contour_error_um : Any
        Contour error as the step itself reports it, µm; programs with rotary axes only. Omitted for the perfect machine, for which the step would report errors that its tables have and that machine does not.
    estimated_orientation_error_urad : Any
        Orientation error as the step reports it, µrad; also without the perfect machine.
    faults : tuple[ReportedFault, ...]
        Faults of the compensated machine or, in a run without it, of the first machine whose plugin is enabled.
    stopped : bool
        Whether that machine was stopped by a stop request.
    limited_cycles : int
        Cycles of that machine in which an axis' correction was limited.
    friction_factors : Any
        Factors of the axes whose friction adapts, in the last cycle; machines that compensate friction only.
    digest : Any
        Digest of all outputs of the step while the program ran, without settling: two runs with equal digests gave equal bits, except with a probability of one in 2³². Eight hexadecimal digits.
    simulated_s : float
        Time of the program, s.
    wall_s : float | None
        Time that the host needed, s.
    notes : tuple[str, ...]
        Remarks on the run.
    noted : tuple[Note, ...]
        Words of the program without effect.
    trace : Section
        Columns of the traces by machine, with `trace_every`.
    """

    __slots__ = ()
    _sections: ClassVar[dict[str, type[Section]]] = {"faults": ReportedFault, "noted": Note}
    machine: str
    program: str
    settings: Section
    cycles: int
    servo_rate_hz: float
    contour_error_um: Any
    orientation_error_urad: Any
    estimated_contour_error_um: Any
    estimated_orientation_error_urad: Any
    faults: tuple[ReportedFault, ...]
    stopped: bool
    limited_cycles: int
    friction_factors: Any
    digest: Any
    simulated_s: float
    wall_s: float | None
    notes: tuple[str, ...]
    noted: tuple[Note, ...]
    trace: Section


__all__ = ["Circle", "Roundness", "ProbeAngles", "Accuracy", "Ballbar", "Identification", "Friction", "ThermalFit", "Calibration", "CalibrationPlan", "KeepPlan", "Reprobing", "Probing", "ThermalTest", "StepDiagonal", "RTest", "MeasuredPoints", "MeasuredPlane", "Uncertainty", "PredictedPart", "Helicoid", "Learned", "Transfer", "Run"]
