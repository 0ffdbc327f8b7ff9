//! Edges and lights of a plate as equations for the lens.

use std::collections::BTreeMap;

use seidel_optics::edges::EdgeSet;
use seidel_optics::field::{FieldPoint, Frame};

use super::PlateLight;
use super::scene_blur::Sample;
use crate::fit::edges::variance_row;

/// An edge or a light in all channels.
#[derive(Debug, Clone)]
pub(super) struct PlateSample {
    /// Its variance by channel; `None` where it was not measured.
    pub(super) second: Vec<Option<Sample>>,
    /// Indices of its edges in the set; none for a light.
    pub(super) edges: Vec<usize>,
}

/// Returns the equations of all edges and lights.
pub(super) fn all(set: &EdgeSet, lights: &[PlateLight], frame: &Frame) -> Vec<PlateSample> {
    let empty = || PlateSample {
        second: vec![None; set.channels.len()],
        edges: Vec::new(),
    };
    let mut by_edge: BTreeMap<(&str, usize), PlateSample> = BTreeMap::new();
    for (index, edge) in set.edges.iter().enumerate() {
        let sample = by_edge
            .entry((&edge.source, edge.index))
            .or_insert_with(empty);
        sample.edges.push(index);
        sample.second[edge.channel] = Some(Sample {
            row: variance_row(frame.field_point(edge.mid), edge.normal),
            value: edge.variance_px2,
            sigma: edge.variance_sigma,
        });
    }
    let of_lights = lights.iter().map(|light| {
        let row = all_directions(frame.field_point(light.at));
        let second = light
            .variances
            .iter()
            .map(|variance| variance.map(|[value, sigma]| Sample { row, value, sigma }));
        PlateSample {
            second: second.collect(),
            edges: Vec::new(),
        }
    });
    by_edge.into_values().chain(of_lights).collect()
}

/// Returns the derivatives of the variance, mean of all directions.
pub(super) fn all_directions(at: FieldPoint) -> [f64; 5] {
    let across = [[1.0, 0.0], [0.0, 1.0]].map(|normal| variance_row(at, normal));
    std::array::from_fn(|k| (across[0][k] + across[1][k]) / 2.0)
}

/// Returns the equations of `channel`.
pub(super) fn of_channel(samples: &[PlateSample], channel: usize) -> Vec<Sample> {
    samples.iter().filter_map(|s| s.second[channel]).collect()
}
