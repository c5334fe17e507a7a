//! Builds tinybvh, where the feature asks for it, from the header that the crate tinybvh-rs brings.
//! The crate itself is not compiled: it asks for closest hits only.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    #[cfg(feature = "tinybvh")]
    tinybvh::build();
}

#[cfg(feature = "tinybvh")]
mod tinybvh {
    use std::path::{Path, PathBuf};
    use std::process::Command;

    pub fn build() {
        println!("cargo:rerun-if-changed=cpp/tinybvh.cpp");
        cc::Build::new()
            .cpp(true)
            .std("c++20")
            .opt_level(3)
            .flags(["-mavx2", "-mfma", "-mbmi", "-mbmi2", "-mlzcnt", "-mpopcnt"])
            .include(header_folder())
            .file("cpp/tinybvh.cpp")
            .warnings(false)
            .compile("tinybvh_peer");
    }

    /// Where cargo keeps the header.
    fn header_folder() -> PathBuf {
        let cargo = std::env::var_os("CARGO").expect("cargo runs this");
        let output = Command::new(cargo)
            .args(["metadata", "--format-version=1", "--locked"])
            .output()
            .expect("cargo tells where its packages are");
        let told: serde_json::Value =
            serde_json::from_slice(&output.stdout).expect("cargo answers in JSON");
        let packages = told["packages"].as_array().expect("a list of packages");
        let package = packages.iter().find(|package| package["name"] == "tinybvh-rs");
        let manifest = package.and_then(|package| package["manifest_path"].as_str());
        Path::new(manifest.expect("the package and its path")).with_file_name("ffi/tinybvh")
    }
}
