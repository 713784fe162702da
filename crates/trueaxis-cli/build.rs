//! With the feature `desk`, compresses the page for `include_bytes!`.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(feature = "desk")]
    page::embed();
}

#[cfg(feature = "desk")]
mod page {
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;
    use std::path::PathBuf;
    use std::{env, fs, io};

    const VARIABLE: &str = "TRUEAXIS_DESK";

    pub(crate) fn embed() {
        println!("cargo::rerun-if-env-changed={VARIABLE}");
        let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
        let built = root.join("../../desk/dist/desk.html");
        let page = env::var_os(VARIABLE).map_or(built, PathBuf::from);
        println!("cargo::rerun-if-changed={}", page.display());
        if let Err(error) = compressed(&page) {
            println!(
                "cargo::error=feature desk: cannot read {} ({error}), needed the page: run desk/build.sh, or let {VARIABLE} name \
                 another file",
                page.display()
            );
        }
        // The tests compare the served page with this file.
        println!("cargo::rustc-env=TRUEAXIS_DESK_PAGE={}", page.display());
    }

    fn compressed(page: &PathBuf) -> io::Result<()> {
        let text = fs::read(page)?;
        let out = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("desk.html.gz");
        let mut encoder = GzEncoder::new(fs::File::create(out)?, Compression::best());
        encoder.write_all(&text)?;
        encoder.finish()?.sync_all()
    }
}
