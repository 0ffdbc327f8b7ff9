//! The edges of a photograph over its frame: kept ones with the width of their blur, others framed by reason.

use image::RgbImage;
use seidel_measure::MeasuredEdges;
use seidel_optics::edges::Edge;

use super::photograph_panel::{KEPT, Panel, colour, stack};

/// Half the side of the frame of an edge that was left out, px.
const HALF_FRAME_PX: f64 = 4.0;

/// Draws the edges of every photograph, one below the other.
pub fn edge_sheet(measured: &MeasuredEdges) -> RgbImage {
    stack(&measured.photographs, |photograph, panel| {
        let photo = &measured.photographs[photograph];
        let reference = photo.reference_channel();
        let edges: Vec<&Edge> = (measured.set.edges.iter())
            .filter(|e| e.source == photo.name && e.channel == reference)
            .collect();
        let left_out = || {
            let all = measured.left_out.iter();
            all.filter(move |l| l.photograph == photograph)
        };
        panel.legend(&photo.name, edges.len(), left_out().map(|l| l.why));
        let brightest = edges.iter().map(|e| e.levels[1]).fold(1e-9, f64::max);
        panel.photograph(photo, 1.2 * brightest);
        for edge in edges {
            draw_edge(panel, edge);
        }
        for edge in left_out() {
            let corner = [edge.x - HALF_FRAME_PX, edge.y - HALF_FRAME_PX];
            panel.outline(corner, [2.0 * HALF_FRAME_PX; 2], colour(edge.why));
        }
    })
}

/// Draws the part of the edge that was used, and a bar from dark to bright across it: two standard deviations to each side.
fn draw_edge(panel: &mut Panel, edge: &Edge) {
    let [nx, ny] = edge.normal;
    let at = |along: f64, across: f64| {
        [
            edge.mid.x_px - along * ny + across * nx,
            edge.mid.y_px + along * nx + across * ny,
        ]
    };
    let half = edge.length_px / 2.0;
    panel.line(at(-half, 0.0), at(half, 0.0), KEPT);
    let reach = 2.0 * edge.variance_px2.max(0.0).sqrt();
    panel.line(at(0.0, -reach), at(0.0, reach), KEPT);
}
