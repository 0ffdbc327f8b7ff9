//! Edge sets: `edges.json` in the folder that `seidel measure edges` writes.

use std::path::Path;

use seidel_optics::camera::Camera;
use seidel_optics::distance::ObjectDistance;
use seidel_optics::edges::{Edge, EdgeSet, ProfileBin};
use seidel_optics::field::{Frame, ImagePoint};
use serde::{Deserialize, Serialize};

use crate::error::{FileError, Result};
use crate::json::{present, read_json, write_json};

/// Name of the file in its folder.
pub const FILE: &str = "edges.json";

const FORMAT: &str = "seidel-edges";
const VERSION: u32 = 1;

#[derive(Serialize, Deserialize)]
struct Document {
    format: String,
    version: u32,
    image_size: [u32; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    optical_axis: Option<[f64; 2]>,
    channels: Vec<String>,
    edges: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    source: String,
    index: usize,
    channel: String,
    #[serde(
        default,
        skip_serializing_if = "Option::is_none",
        deserialize_with = "present"
    )]
    depth_m: Option<Option<f64>>,
    mid: [f64; 2],
    normal: [f64; 2],
    length: f64,
    levels: [f64; 2],
    variance: f64,
    variance_sigma: f64,
    third: f64,
    third_sigma: f64,
    profile: Bins,
}

/// The bins of a profile, one list a quantity.
#[derive(Serialize, Deserialize)]
struct Bins {
    t: Vec<f64>,
    level: Vec<f64>,
    sigma: Vec<f64>,
    spread: Vec<f64>,
}

/// Writes `set`. The axis is stated if `axis_is_known`.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, set: &EdgeSet, axis: Option<ImagePoint>) -> Result<()> {
    let document = Document {
        format: FORMAT.to_owned(),
        version: VERSION,
        image_size: [set.frame.width_px(), set.frame.height_px()],
        optical_axis: axis.map(|p| [p.x_px, p.y_px]),
        channels: set.channels.clone(),
        edges: set.edges.iter().map(|edge| entry(set, edge)).collect(),
    };
    write_json(path, &document)
}

fn entry(set: &EdgeSet, edge: &Edge) -> Entry {
    let rounded = |v: f64| (v * 1e6).round() / 1e6;
    let list = |of: fn(&ProfileBin) -> f64| edge.profile.iter().map(|b| rounded(of(b))).collect();
    Entry {
        source: edge.source.clone(),
        index: edge.index,
        channel: set.channels[edge.channel].clone(),
        depth_m: match edge.distance {
            ObjectDistance::Metres(metres) => Some(Some(metres)),
            ObjectDistance::Infinity => Some(None),
            ObjectDistance::Unknown => None,
        },
        mid: [edge.mid.x_px, edge.mid.y_px],
        normal: edge.normal,
        length: edge.length_px,
        levels: edge.levels,
        variance: edge.variance_px2,
        variance_sigma: edge.variance_sigma,
        third: edge.third_px3,
        third_sigma: edge.third_sigma,
        profile: Bins {
            t: list(|b| b.t_px),
            level: list(|b| b.level),
            sigma: edge.profile.iter().map(|b| b.sigma).collect(),
            spread: list(|b| b.spread_px2),
        },
    }
}

/// Reads the edge set in `folder`.
///
/// # Errors
/// A file that cannot be read, another format or version, and values that an edge set does not allow.
pub fn read(folder: &Path) -> Result<EdgeSet> {
    let path = folder.join(FILE);
    let document: Document = read_json(&path)?;
    if (document.format.as_str(), document.version) != (FORMAT, VERSION) {
        return Err(FileError::new(
            &path,
            "format, version",
            format!("are {} {}", document.format, document.version),
            format!("give {FORMAT} {VERSION}, as `seidel measure edges` writes it"),
        ));
    }
    let axis = document.optical_axis.map(|[x, y]| ImagePoint::new(x, y));
    let [width, height] = document.image_size;
    let of_core = |error| FileError::from_core(&path, error);
    let mut set = EdgeSet {
        frame: Frame::new(width, height, axis).map_err(of_core)?,
        channels: document.channels,
        pixel_pitch_um: None,
        camera: Camera::default(),
        edges: Vec::new(),
    };
    for (index, entry) in document.edges.into_iter().enumerate() {
        set.edges.push(edge(&path, index, entry, &set.channels)?);
    }
    set.check().map_err(of_core)?;
    Ok(set)
}

fn edge(path: &Path, index: usize, entry: Entry, channels: &[String]) -> Result<Edge> {
    let fault = |field: &str, problem: String, remedy: &str| {
        FileError::new(path, format!("edges[{index}].{field}"), problem, remedy)
    };
    let channel = channels.iter().position(|name| *name == entry.channel);
    let Some(channel) = channel else {
        let problem = format!("is {}, which the set does not have", entry.channel);
        return Err(fault("channel", problem, "name one of `channels`"));
    };
    let distance = match entry.depth_m {
        None => ObjectDistance::Unknown,
        Some(None) => ObjectDistance::Infinity,
        Some(Some(metres)) => ObjectDistance::metres(metres)
            .map_err(|error| fault("depth_m", error.to_string(), "give metres above zero"))?,
    };
    let Bins {
        t,
        level,
        sigma,
        spread,
    } = entry.profile;
    if [level.len(), sigma.len(), spread.len()] != [t.len(); 3] {
        let problem = "has lists of different lengths".to_owned();
        return Err(fault("profile", problem, "give one entry a bin in each"));
    }
    let profile = (0..t.len()).map(|k| ProfileBin {
        t_px: t[k],
        level: level[k],
        sigma: sigma[k],
        spread_px2: spread[k],
    });
    Ok(Edge {
        source: entry.source,
        index: entry.index,
        channel,
        distance,
        mid: ImagePoint::new(entry.mid[0], entry.mid[1]),
        normal: entry.normal,
        length_px: entry.length,
        levels: entry.levels,
        variance_px2: entry.variance,
        variance_sigma: entry.variance_sigma,
        third_px3: entry.third,
        third_sigma: entry.third_sigma,
        profile: profile.collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set() -> EdgeSet {
        let profile = |k: usize| ProfileBin {
            t_px: k as f64 - 5.0,
            level: 0.5,
            sigma: 0.01,
            spread_px2: 0.02,
        };
        let edge = |distance| Edge {
            source: "a.dng".to_owned(),
            index: 3,
            channel: 1,
            distance,
            mid: ImagePoint::new(10.25, 11.5),
            normal: [0.6, -0.8],
            length_px: 20.0,
            levels: [100.0, 900.0],
            variance_px2: 1.0,
            variance_sigma: 0.1,
            third_px3: -0.5,
            third_sigma: 0.1,
            profile: (0..11).map(profile).collect(),
        };
        EdgeSet {
            frame: Frame::new(100, 80, None).expect("valid"),
            channels: vec!["R".to_owned(), "G".to_owned()],
            pixel_pitch_um: None,
            camera: Camera::default(),
            edges: vec![
                edge(ObjectDistance::Metres(2.0)),
                edge(ObjectDistance::Infinity),
                edge(ObjectDistance::Unknown),
            ],
        }
    }

    #[test]
    fn edges_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let set = set();
        write(&folder.path().join(FILE), &set, None).expect("writable");
        assert_eq!(read(folder.path()).expect("valid"), set);
    }

    #[test]
    fn faults_name_the_file_and_the_edge() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(FILE);
        write(&path, &set(), None).expect("writable");
        let text = std::fs::read_to_string(&path).expect("written");
        let refusal = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            std::fs::write(&path, text.replacen(from, to, 1)).expect("writable");
            read(folder.path()).expect_err("invalid").to_string()
        };
        let channel = refusal("\"channel\": \"G\"", "\"channel\": \"B\"");
        assert!(channel.contains("edges[0].channel") && channel.contains(FILE));
        let version = refusal("\"version\": 1", "\"version\": 7");
        assert!(version.contains("seidel-edges 7"), "{version}");
        let normal = refusal("0.6", "0.9");
        assert!(normal.contains("edges[0].normal"), "{normal}");
    }
}
