//! Expansion of a plate by the reach of its blur, so that an element keeps its blurred rim.

use seidel_optics::error::Result;

use crate::margins::Margins;
use crate::prepared::PreparedPlate;
use crate::settings::Expand;
use seidel_optics::Rectangle;
use seidel_render::RenderWindow;

/// Samples below this share of the brightest light are not worth a larger data window: less than half floats resolve beside it.
const NEGLIGIBLE_SHARE: f32 = 1e-6;

/// A side of a plate.
#[derive(Clone, Copy)]
enum Side {
    Left,
    Top,
    Right,
    Bottom,
}

impl PreparedPlate {
    /// Returns the margins by which [`Settings::expand`](crate::Settings::expand) expands the plate: the reach of its
    /// lit pixels beyond each side that is expanded.
    ///
    /// With [`Expand::Auto`] these are the sides where the plate is transparent: those of a plate with alpha whose
    /// border is transparent or that lie within the display window, and those of a plate without alpha for which both
    /// hold. A full frame is not expanded.
    ///
    /// # Errors
    /// Focus settings that cannot be followed.
    pub fn expansion(&self) -> Result<Margins> {
        let settings = self.session().settings();
        if settings.expand == Expand::Never || self.session().is_neutral() {
            return Ok(Margins::default());
        }
        let Some(lit) = self.lit_window() else {
            return Ok(Margins::default());
        };
        let (x, y) = self.reach_of_light()?;
        let longest = self.placement().width.max(self.placement().height);
        let cells = |px: f64| (px.ceil() as usize).min(longest);
        let margin = |side: Side, reach: usize, distance: usize| {
            if settings.expand == Expand::Always || self.ends_at(side) {
                reach.saturating_sub(distance)
            } else {
                0
            }
        };
        let (x, y) = (cells(x), cells(y));
        let placement = self.placement();
        let after = |size: usize, first: i32, count: usize| size - first as usize - count;
        Ok(Margins {
            left: margin(Side::Left, x, lit.x as usize),
            top: margin(Side::Top, y, lit.y as usize),
            right: margin(Side::Right, x, after(placement.width, lit.x, lit.width)),
            bottom: margin(Side::Bottom, y, after(placement.height, lit.y, lit.height)),
        })
    }

    /// Returns the part of the data window that holds the plate's own pixels and every pixel of `planes` with light, both
    /// over the data window. Elsewhere nothing is lost by a crop.
    pub fn trimmed(&self, planes: &[Vec<f32>], own: Rectangle) -> Rectangle {
        let data = self.geometry().data;
        let peak = self.planes().iter().flatten();
        let peak = peak.fold(0.0_f32, |most, v| most.max(v.abs()));
        let Some(lit) = lit_window(planes, data.width, NEGLIGIBLE_SHARE * peak) else {
            return own;
        };
        let (left, top) = ((data.x + lit.x).min(own.x), (data.y + lit.y).min(own.y));
        let right = (data.x + lit.x + lit.width as i32).max(own.x + own.width as i32);
        let bottom = (data.y + lit.y + lit.height as i32).max(own.y + own.height as i32);
        Rectangle {
            x: left,
            y: top,
            width: (right - left) as usize,
            height: (bottom - top) as usize,
        }
    }

    /// The smallest window with all light of the plate, in plate pixels.
    fn lit_window(&self) -> Option<Rectangle> {
        lit_window(self.planes(), self.placement().width, 0.0)
    }

    /// Returns whether nothing is known to be beyond a side of the plate; see [`Self::expansion`].
    fn ends_at(&self, side: Side) -> bool {
        let (display, data) = (self.geometry().display, self.geometry().data);
        let is_within_display = match side {
            Side::Left => data.x > display.x,
            Side::Top => data.y > display.y,
            Side::Right => data.columns().end < display.columns().end,
            Side::Bottom => data.rows().end < display.rows().end,
        };
        let is_empty = || {
            let planes = self.planes().iter();
            let (width, height) = (data.width, data.height);
            planes.into_iter().all(|plane| match side {
                Side::Left => plane.iter().step_by(width).all(|v| *v == 0.0),
                Side::Right => plane[width - 1..].iter().step_by(width).all(|v| *v == 0.0),
                Side::Top => plane[..width].iter().all(|v| *v == 0.0),
                Side::Bottom => plane[(height - 1) * width..].iter().all(|v| *v == 0.0),
            })
        };
        if self.alpha().is_some() {
            is_within_display || is_empty()
        } else {
            is_within_display && is_empty()
        }
    }
}

/// Returns the smallest window with all samples of `planes`, `width` columns wide, whose magnitude is above `limit`.
fn lit_window(planes: &[Vec<f32>], width: usize, limit: f32) -> Option<Rectangle> {
    let planes = planes.iter().map(Vec::as_slice);
    RenderWindow::of_light(planes, width, limit).map(|lit| Rectangle {
        x: lit.column as i32,
        y: lit.row as i32,
        width: lit.width,
        height: lit.height,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lit_window_holds_all_light() {
        let mut plane = vec![0.0; 5 * 4];
        assert_eq!(lit_window(&[plane.clone()], 5, 0.0), None);
        plane[5 + 3] = 1.0;
        let mut other = vec![0.0; 5 * 4];
        other[2 * 5 + 1] = -2.0;
        other[3 * 5 + 4] = 1e-7;
        let lit = lit_window(&[plane, other], 5, 1e-6).expect("light");
        assert_eq!((lit.x, lit.y, lit.width, lit.height), (1, 1, 3, 2));
    }
}
