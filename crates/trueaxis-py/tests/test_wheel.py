"""What the wheel contains beside the module, and what it says of itself."""

from importlib.metadata import files, metadata, version

import trueaxis


def test_the_wheel_carries_the_licences_of_what_is_inside():
    [third_party] = [file for file in files("trueaxis") if file.name == "THIRD-PARTY.txt"]
    text = third_party.read_text()
    for part in ("The trueaxis developers", "pyo3 ", "Permission is hereby granted", "TERMS AND CONDITIONS"):
        assert part in text, part
    assert {"LICENSE-MIT", "LICENSE-APACHE"} <= {file.name for file in files("trueaxis")}


def test_the_wheel_describes_the_module():
    """The project file lies in the root, and names the README and the version of the crate."""
    own = metadata("trueaxis")
    assert own["Name"] == "trueaxis" and version("trueaxis") == trueaxis.__version__
    assert own["Description"].startswith("# trueaxis for Python") and own["Requires-Python"] == ">=3.9"
    assert {file.parts[0] for file in files("trueaxis")} == {"trueaxis", f"trueaxis-{trueaxis.__version__}.dist-info"}
