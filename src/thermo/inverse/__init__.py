"""From recordings to fields, and from fields to predictions."""

from thermo.inverse._addition import (
    AbstractHeatAddition,
    AbstractReadingAddition,
    Addition,
    read_at_rest,
)
from thermo.inverse._bands import NORMAL, Band, bands
from thermo.inverse._body import SCANNED_CONDUCTIVITIES, Meshing
from thermo.inverse._case import Case, one_run
from thermo.inverse._checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from thermo.inverse._conditions import Conditions
from thermo.inverse._defect import (
    DEFECT_LEFT,
    DEFECT_SPREAD,
    defect_sizes,
    finer_readings,
    finer_temperatures,
    with_defects,
    with_remainders,
)
from thermo.inverse._estimate import (
    Estimate,
    RecoveredField,
    RunFit,
    load_estimate,
    recovered,
    save_estimate,
    saved_effects,
    summary,
    surface_values,
    weighted_quantile,
)
from thermo.inverse._field_choice import (
    AbstractFieldChoice,
    AbstractStagedChoice,
    Network,
    OnControlPoints,
    Patchwise,
    TwoMaterials,
    Uniform,
)
from thermo.inverse._field_loss import FieldLoss
from thermo.inverse._field_posterior import FieldPosterior, Smoothness
from thermo.inverse._field_scores import FieldScores, field_scores
from thermo.inverse._first_order import Adam, LimitedMemoryBfgs
from thermo.inverse._forward import Prediction, Scores, score
from thermo.inverse._invert import UNEXPLAINED, invert
from thermo.inverse._least_squares import GaussNewtonKrylov, LevenbergMarquardt
from thermo.inverse._log_model import LogModel, log_model
from thermo.inverse._objective import (
    Objective,
    Parameters,
    case_model,
    case_temperatures,
    penalty,
    residual,
    start,
    with_fields,
)
from thermo.inverse._optimiser import AbstractOptimiser
from thermo.inverse._posterior import CONTROLS, posterior
from thermo.inverse._predict import PREDICTION_NODES, predict, simulate
from thermo.inverse._properties import law_of
from thermo.inverse._reading_errors import whiten
from thermo.inverse._residual_noise import residual_noises, with_noise
from thermo.inverse._scale import SCALES, Scale
from thermo.inverse._scale_effect import ScaleEffect
from thermo.inverse._sensitivity import Sensitivity, sensitivity, unfitted
from thermo.inverse._side_by_side import at_once
from thermo.inverse._smoothing import ALL_BUT_UNIFORM
from thermo.inverse._stages import coarse_tangents, make_objective
from thermo.inverse._staying import left_open, staying
from thermo.inverse._stepping import Stepping
from thermo.inverse._task import FINER, Prior, Ready, Task, lay_out, mesh_for, stand_in
from thermo.inverse._transfer import carry_over

__all__ = [
    "ALL_BUT_UNIFORM",
    "CONTROLS",
    "DEFECT_LEFT",
    "DEFECT_SPREAD",
    "FINER",
    "NORMAL",
    "PREDICTION_NODES",
    "SCALES",
    "SCANNED_CONDUCTIVITIES",
    "UNEXPLAINED",
    "AbstractFieldChoice",
    "AbstractHeatAddition",
    "AbstractOptimiser",
    "AbstractReadingAddition",
    "AbstractStagedChoice",
    "Adam",
    "Addition",
    "Band",
    "Case",
    "Checkpoint",
    "Conditions",
    "Estimate",
    "FieldLoss",
    "FieldPosterior",
    "FieldScores",
    "GaussNewtonKrylov",
    "LevenbergMarquardt",
    "LimitedMemoryBfgs",
    "LogModel",
    "Meshing",
    "Network",
    "Objective",
    "OnControlPoints",
    "Parameters",
    "Patchwise",
    "Prediction",
    "Prior",
    "Ready",
    "RecoveredField",
    "RunFit",
    "Scale",
    "ScaleEffect",
    "Scores",
    "Sensitivity",
    "Smoothness",
    "Stepping",
    "Task",
    "TwoMaterials",
    "Uniform",
    "at_once",
    "bands",
    "carry_over",
    "case_model",
    "case_temperatures",
    "coarse_tangents",
    "defect_sizes",
    "field_scores",
    "finer_readings",
    "finer_temperatures",
    "invert",
    "law_of",
    "lay_out",
    "left_open",
    "load_checkpoint",
    "load_estimate",
    "log_model",
    "make_objective",
    "mesh_for",
    "one_run",
    "penalty",
    "posterior",
    "predict",
    "read_at_rest",
    "recovered",
    "residual",
    "save_checkpoint",
    "save_estimate",
    "saved_effects",
    "score",
    "sensitivity",
    "simulate",
    "stand_in",
    "start",
    "staying",
    "residual_noises",
    "summary",
    "surface_values",
    "unfitted",
    "with_noise",
    "weighted_quantile",
    "whiten",
    "with_defects",
    "with_remainders",
    "with_fields",
]
