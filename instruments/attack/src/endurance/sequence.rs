//! One run of the command over thousands of frames.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};

use seidel_core::Rectangle;
use seidel_image_io::formats::exr::{NewChannel, write_channels};
use seidel_image_io::windows::ImageWindows;

use super::Watch;
use crate::options::Options;
use crate::worker::program;

/// Columns and rows of the display window, and of the data window.
const DISPLAY: [usize; 2] = [4096, 2160];
const DATA: usize = 256;

/// Different plates; frames repeat them.
const PLATES: usize = 8;

/// Renders `frames` frames, and compares each output with the first one of the same plate.
pub(super) fn run(frames: usize, options: &Options, watch: &mut Watch) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|e| format!("a temporary folder: {e}"))?;
    let folder = folder.path();
    write_inputs(folder, frames)?;
    let words = program(options);
    let line = format!(
        "apply --lens lens.json --distance 4 --quality draft --provenance none --progress none --frames 1-{frames} \
         in.####.exr -o out.####.exr"
    );
    let stderr = File::create(folder.join("stderr")).map_err(|e| e.to_string())?;
    let mut child = Command::new(&words[0])
        .args(&words[1..])
        .args(line.split(' ').filter(|word| !word.is_empty()))
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(stderr)
        .spawn()
        .map_err(|e| format!("the command: {e}"))?;
    watch.begin(child.id());
    let status = child.wait().map_err(|e| e.to_string())?;
    if !status.success() {
        let words = fs::read_to_string(folder.join("stderr")).unwrap_or_default();
        return Err(format!("{status}: {words}"));
    }
    let read = |frame: usize| {
        let path = folder.join(format!("out.{frame:04}.exr"));
        fs::read(&path).map_err(|e| format!("{}: {e}", path.display()))
    };
    let first: Vec<Vec<u8>> = (1..=PLATES.min(frames))
        .map(read)
        .collect::<Result<_, _>>()?;
    for frame in 1..=frames {
        if read(frame)? != first[(frame - 1) % PLATES] {
            return Err(format!(
                "frame {frame} differs from the first of the same plate"
            ));
        }
    }
    Ok(())
}

/// Writes the lens and the plates, to which the names of all frames are linked.
fn write_inputs(folder: &Path, frames: usize) -> Result<(), String> {
    let [width, height] = DISPLAY;
    let lens = seidel::demo::lens::lens(width as u32, height as u32).map_err(|e| e.to_string())?;
    fs::write(folder.join("lens.json"), lens.to_json()).map_err(|e| e.to_string())?;
    let windows = ImageWindows {
        data: Rectangle {
            x: 3000,
            y: 1400,
            width: DATA,
            height: DATA,
        },
        ..ImageWindows::of_size(width, height)
    };
    for plate in 0..PLATES {
        let planes: Vec<Vec<f32>> = (0..3).map(|channel| plane(plate, channel)).collect();
        let channels: Vec<NewChannel> = (["R", "G", "B"].into_iter().zip(&planes))
            .map(|(name, samples)| NewChannel {
                name,
                samples,
                half: true,
            })
            .collect();
        let path = folder.join(format!("plate.{plate}.exr"));
        write_channels(&path, windows, &channels).map_err(|e| e.to_string())?;
    }
    for frame in 1..=frames {
        let plate = folder.join(format!("plate.{}.exr", (frame - 1) % PLATES));
        let path = folder.join(format!("in.{frame:04}.exr"));
        fs::hard_link(plate, &path).map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(())
}

/// Returns steps of grey with a few bright lights, which files store in little space.
fn plane(plate: usize, channel: usize) -> Vec<f32> {
    let pixels = (0..DATA * DATA).map(|k| (k % DATA, k / DATA));
    let sample = |(x, y): (usize, usize)| {
        if (x % 64, y % 48) == (5 * plate + 9, 11) {
            return 30.0;
        }
        0.1 * ((x / 32 + y / 64 + plate + channel) % 7) as f32
    };
    pixels.map(sample).collect()
}
