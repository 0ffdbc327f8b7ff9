//! The lens model: from a thick lens with Seidel aberrations to the moments and the pupil of its PSFs.
//!
//! - [`ThickLens`] and [`SeidelAberrations`] give the five [`ReducedNumbers`] of one object distance.
//! - These give S1..S10 ([`MomentCoefficients`]), and S1..S10 the moments at any field position.
//! - [`DepthLaw`] interpolates S1..S10 over object distance.
//! - [`LocalPupil`] describes the same lens at one point by its [`Wavefront`] and stops. Effects act on it.
//!
//! ```
//! use seidel_optics::field::FieldPoint;
//! use seidel_optics::lens::{SeidelAberrations, ThickLens};
//!
//! // 50 mm f/2.5, lengths in mm, focused at 2 m; an object at 1 m.
//! let lens = ThickLens { focal_length: 50.0, principal_separation: 10.0, entrance_pupil: 4.0, pupil_radius: 10.0 };
//! let aberrations = SeidelAberrations { spherical: 3.5e-7, coma: 3.5e-6, ..SeidelAberrations::default() };
//! let conjugates = lens.conjugates(Some(2000.0), Some(1000.0))?;
//! let numbers = aberrations.reduced(&conjugates, lens.pupil_radius);
//! let moments = numbers.coefficients().moments(FieldPoint::new(12.0, 0.0)); // mm², mm³, 12 mm off axis
//! assert!(moments.mu20 > moments.mu02 && moments.mu11 == 0.0);
//! # Ok::<(), seidel_optics::Error>(())
//! ```

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
pub use pupil::{
    AperturePicture, LocalPupil, MAX_STOPS, PINHOLE_RADIUS, PictureMask, Shadow, Stop, Transmission,
};
pub use reduced::ReducedNumbers;
pub use seidel::SeidelAberrations;
pub use series::{VergencePoint, VergenceSeries};
pub use thick_lens::{Conjugates, ThickLens};
pub use wavefront::{DEGREE, TERMS, Wavefront, powers};
