"""Docstrings: every public name has one in numpydoc's form, and its examples run."""

import doctest
import inspect

import numpy as np
import pytest
from numpydoc.validate import validate

import trueaxis
from test_command_line import ROOT

# Not asked for: an extended summary, a section See Also, examples everywhere; a summary on the first line, and no blank
# lines at the ends, as the compiler puts docstrings.
LEFT_OUT = {"ES01", "SA01", "EX01", "GL01", "GL02", "GL03", "GL08", "RT03", "YD01"}


def public():
    """Public names with a docstring of their own: functions, classes, and the methods of classes."""
    for name in trueaxis.__all__:
        of = getattr(trueaxis, name)
        if not callable(of):
            continue
        yield f"trueaxis.{name}"
        if inspect.isclass(of) and not issubclass(of, (Exception, trueaxis.Section)):
            for method in vars(of):
                if not method.startswith("_") and callable(getattr(of, method)):
                    yield f"trueaxis.{name}.{method}"


@pytest.mark.parametrize("name", public())
def test_a_public_name_has_a_docstring_in_numpydocs_form(name):
    found = validate(name)
    assert found["docstring"], name
    # Only functions of the package make results and figures.
    left_out = LEFT_OUT | ({"PR01"} if inspect.isclass(eval(name, {"trueaxis": trueaxis})) else set())
    assert not [error for error in found["errors"] if error[0] not in left_out], name


@pytest.mark.parametrize("name", public())
def test_the_examples_of_a_docstring_run(name, monkeypatch):
    monkeypatch.chdir(ROOT)
    of = eval(name, {"trueaxis": trueaxis})
    with np.printoptions(precision=4, suppress=True):
        for test in doctest.DocTestFinder(recurse=False).find(of, name, globs={"trueaxis": trueaxis, "np": np}):
            result = doctest.DocTestRunner().run(test)
            assert result.failed == 0, name
