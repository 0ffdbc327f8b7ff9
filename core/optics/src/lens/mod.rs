//! The lens model: from a physical camera, or five reduced numbers, to the moments of its PSFs.
//!
//! [`ThickLens`] and [`SeidelAberrations`] give [`ReducedNumbers`]; these give
//! [`MomentCoefficients`] S1..S10, and those the moments anywhere in the field. [`LocalPupil`] is the
//! same lens ray by ray at one point: a [`Wavefront`] and what clips it, open to effects.
//! [`DepthLaw`] carries S1..S10 across depth.

mod coefficients;
mod conjugate_shift;
mod depth_law;
mod fourth_order;
mod pupil;
mod reduced;
mod seidel;
mod series;
mod thick_lens;
mod wavefront;

pub use coefficients::{BASIS_DEGREE, MOMENT_ORDER, MomentCoefficients};
pub use conjugate_shift::ConjugateShift;
pub use depth_law::{DEGREE_IN_VERGENCE, DepthLaw, DepthPlane};
pub use fourth_order::FourthCoefficients;
pub use pupil::{LocalPupil, MAX_STOPS, PINHOLE_RADIUS, Stop, Transmission};
pub use reduced::ReducedNumbers;
pub use seidel::SeidelAberrations;
pub use series::{VergencePoint, VergenceSeries};
pub use thick_lens::{Conjugates, ThickLens};
pub use wavefront::{DEGREE, TERMS, Wavefront, powers};
