"""Files that the wheel contains beside the module."""

from importlib.metadata import files


def test_the_wheel_carries_the_licences_of_what_is_inside():
    [third_party] = [file for file in files("trueaxis") if file.name == "THIRD-PARTY.txt"]
    text = third_party.read_text()
    for part in ("The trueaxis developers", "pyo3 ", "Permission is hereby granted", "TERMS AND CONDITIONS"):
        assert part in text, part
    assert {"LICENSE-MIT", "LICENSE-APACHE"} <= {file.name for file in files("trueaxis")}
