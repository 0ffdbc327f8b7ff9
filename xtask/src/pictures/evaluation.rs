//! Pictures and plots of the evaluation sets, which the project does not ship.

use std::path::PathBuf;

use super::programs::Programs;

/// Evaluation sets, and what their fits need besides.
const SETS: [(&str, &str); 5] = [
    ("zemax-dgauss28", ""),
    ("optiland-us8879901", ""),
    ("dash-stars", "--axis free"),
    ("prime50-decentred", ""),
    ("ana-front-31", ""),
];

/// The sets whose sparse-fit plots the page shows.
const PLOTTED: [&str; 3] = ["zemax-dgauss28", "optiland-us8879901", "dash-stars"];

/// Draws the shapes and the sparse-fit plots; does nothing where `SEIDEL_DATA` names no folder.
pub(super) fn draw(programs: &Programs) -> Result<(), String> {
    let Some(data) = std::env::var_os("SEIDEL_DATA").map(PathBuf::from) else {
        eprintln!(
            "pictures: SEIDEL_DATA is not set: those of the evaluation sets are left as they are"
        );
        return Ok(());
    };
    let image = data.join("plates").join("camera-512.exr");
    for (name, axis) in SETS {
        let set = data.join("psf").join(name);
        let (set, image) = (set.display(), image.display());
        programs.seidel(&format!("fit {set} -o {name}.json --model extended {axis}"))?;
        programs.seidel(&format!(
            "eval --lens {name}.json {set} --image {image} --shapes shapes-{name}.png"
        ))?;
        install(programs, "pictures", &format!("shapes-{name}.png"))?;
        if !PLOTTED.contains(&name) {
            continue;
        }
        programs.seidel(&format!(
            "fit {set} -o {name}-moments.json --model moments {axis}"
        ))?;
        programs.seidel(&format!(
            "eval --lens {name}-moments.json {set} --image {image} --plot sparse-{name}.svg"
        ))?;
        install(programs, "figures", &format!("sparse-{name}.svg"))?;
    }
    Ok(())
}

fn install(programs: &Programs, folder: &str, file: &str) -> Result<(), String> {
    programs.install_in(folder, &programs.work().join(file), file)
}
