"""Writes a crate with a source under planted defects: every proof of it must fail."""

import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent


def write(folder, proof, source, defects, head, signature):
    """Writes the crate from the manifest of PROOF and prints the names of its functions.

    `defects`: name to function, original text, planted text; `signature`: function and name to parameters and body.
    """
    path = HERE / "../../crates/trueaxis/src" / source
    text = path.read_text().replace("#[cfg(test)]\nmod tests", "#[cfg(any())]\nmod tests")
    (folder / "src").mkdir(parents=True, exist_ok=True)
    manifest = (HERE / proof / "Cargo.toml").read_text().replace("../../../crates", str((HERE / "../../crates").resolve()))
    (folder / "Cargo.toml").write_text(manifest.replace(f"trueaxis-{proof}-ir", f"trueaxis-{proof}-controls"))
    # The source names modules of its own crate; `real` is not public there.
    lines = ["#![no_std]", "#![allow(warnings)]", "mod real { pub use trueaxis::Real; }", *head]
    for name, (function, right, wrong) in defects.items():
        if text.count(right) != 1:
            sys.exit(f"defects.py: found {text.count(right)} times in {source}, needed once: {right}")
        (folder / f"src/{name}.rs").write_text(text.replace(right, wrong))
        lines.append(f"mod {name};")
        lines.append(f"#[unsafe(no_mangle)] #[inline(never)] pub extern \"C\" fn {function}_f32_{name}({signature(function, name)}")
        print(f"{function}_f32_{name}")
    (folder / "src/lib.rs").write_text("\n".join(lines) + "\n")
