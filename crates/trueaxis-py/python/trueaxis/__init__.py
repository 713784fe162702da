"""Errors and corrections of machine tools over NumPy arrays: the figures that the command ``trueaxis`` prints.

Positions are in mm and degrees, errors in µm: actual − ideal, of the tool relative to the workpiece. Functions take
array-likes, data frames and files, and return results whose attributes are the fields of the command's JSON.
"""

from . import _native, _types
from ._native import *
from ._propagate import Propagated, propagate
from ._results import Figure, Result, Section
from ._types import *

__version__ = _native.__version__
__all__ = [*(name for name in _native.__all__ if not name.startswith("_")), "__version__", "Figure", "Result", "Section", "Propagated", "propagate", *_types.__all__]
