//! Diagnoses a lens whose sensor has moved by 30 µm since it was measured:
//! `cargo run --release -p seidel-core --example diagnose_gap -- seidel-demo/lens.json`.

mod support;

use seidel_core::{Controls, DiagnosisSettings, Lens, diagnose, no_progress};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1);
    let path = path.ok_or("give a lens profile, such as seidel-demo/lens.json")?;
    let lens = Lens::from_json(&std::fs::read_to_string(path)?)?;
    let moved = lens.with_controls(&Controls {
        sensor_shift_um: Some(30.0),
        ..Controls::default()
    })?;
    let measured = support::measure(&moved, 6, 4)?;

    let library = ["defocus_offset", "decentre", "vignetting"];
    let settings = DiagnosisSettings {
        library: library.map(str::to_owned).to_vec(),
        ..DiagnosisSettings::default()
    };
    let diagnosis = diagnose(&lens, &measured, &settings, &no_progress)?;
    println!(
        "verdict {:?}, added {:?}",
        diagnosis.verdict, diagnosis.added
    );
    println!(
        "gap {:.4} before, {:.4} after",
        diagnosis.gap.before, diagnosis.gap.after
    );
    for cause in &diagnosis.causes {
        println!("{}: probability {:.2}", cause.effect, cause.probability);
    }
    Ok(())
}
