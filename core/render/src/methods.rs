//! What a render was made of: which ways were chosen, for people who want to know.

use crate::{Plane, Renderer, Scene, VergencePass, Window};
use seidel_optics::error::Result;
use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The ways by which planes are rendered, over all renders of a plate: one, or several where depth is cut into
/// slices.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Methods {
    /// Renders: those of parts of a slice count apart.
    pub renders: usize,
    /// Renders by the exact scatter, a kernel a pixel.
    pub scattered: usize,
    /// The pyramid levels of renders by the fast gather, finest first.
    pub levels: Vec<LevelMethods>,
    /// Small lights taken off and scattered exactly, pixels.
    pub lights: usize,
}

/// What is done at one level of the fast gather's pyramid, tiles being those of one plane.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LevelMethods {
    /// Tiles gathered at this level.
    pub gathered: usize,
    /// Tiles made of those of the next coarser level.
    pub doubled: usize,
    /// Shortest and longest side of the tiles of all renders, pixels of the level.
    pub sides_px: (usize, usize),
}

impl Methods {
    /// One render, of these levels.
    pub(crate) fn gathered(levels: Vec<LevelMethods>, lights: usize) -> Self {
        Self {
            renders: 1,
            scattered: 0,
            levels,
            lights,
        }
    }

    /// One exact render.
    pub(crate) fn exact() -> Self {
        Self {
            renders: 1,
            scattered: 1,
            ..Self::default()
        }
    }

    fn add(&mut self, other: &Self) {
        self.renders += other.renders;
        self.scattered += other.scattered;
        self.lights += other.lights;
        for (index, level) in other.levels.iter().enumerate() {
            let Some(mine) = self.levels.get_mut(index) else {
                self.levels.push(*level);
                continue;
            };
            mine.gathered += level.gathered;
            mine.doubled += level.doubled;
            mine.sides_px.0 = mine.sides_px.0.min(level.sides_px.0);
            mine.sides_px.1 = mine.sides_px.1.max(level.sides_px.1);
        }
    }
}

/// A renderer that renders as `inner` does and notes how. Made inner to [`Layered`](crate::Layered) or
/// [`Extended`](crate::Extended) it notes every render that they ask for.
pub struct Noted<'r> {
    inner: &'r dyn Renderer,
    notes: Mutex<Notes>,
}

#[derive(Default)]
struct Notes {
    methods: Methods,
    /// Vergences of the renders, as bits.
    vergences: BTreeSet<u64>,
}

impl<'r> Noted<'r> {
    /// Notes what `inner` does.
    pub fn new(inner: &'r dyn Renderer) -> Self {
        Self {
            inner,
            notes: Mutex::default(),
        }
    }

    fn notes(&self) -> MutexGuard<'_, Notes> {
        // Whole also where another thread died.
        self.notes.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What was done so far.
    pub fn methods(&self) -> Methods {
        self.notes().methods.clone()
    }

    /// At how many distinct vergences renders of one vergence were: slices of a plate whose depth varies.
    pub fn slices(&self) -> usize {
        self.notes().vergences.len()
    }

    fn note(&self, scene: &Scene, planes: &[Plane]) -> Result<()> {
        let methods = self.inner.methods(scene, planes)?;
        let mut notes = self.notes();
        notes.methods.add(&methods);
        if let VergencePass::Constant(vergence) = scene.vergence {
            notes.vergences.insert(vergence.to_bits());
        }
        Ok(())
    }
}

impl Renderer for Noted<'_> {
    fn id(&self) -> &'static str {
        self.inner.id()
    }

    fn render(
        &self,
        scene: &Scene,
        planes: &[Plane],
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        self.note(scene, planes)?;
        self.inner.render(scene, planes, progress)
    }

    fn render_window(
        &self,
        scene: &Scene,
        planes: &[Plane],
        window: Window,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<Vec<f32>>> {
        self.note(scene, planes)?;
        self.inner.render_window(scene, planes, window, progress)
    }

    fn methods(&self, scene: &Scene, planes: &[Plane]) -> Result<Methods> {
        self.inner.methods(scene, planes)
    }
}
