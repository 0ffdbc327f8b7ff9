//! Conversion of a plate to another format: what becomes of its samples, and warnings about everything that is lost.

use std::path::Path;

use super::{PlateFile, Source};
use crate::error::Result;
use crate::format::{AlphaSupport, Capabilities, Format, GreySupport};
use crate::formats::Row;
use crate::input::Limits;
use crate::metadata::{CommonMetadata, TextAttributes, is_provenance};
use crate::new_image::NewImage;
use crate::samples::{Encoding, MAX_HALF, SampleFormat};
use crate::windows::{ImageWindows, crop_or_pad};

/// Largest number of lost channels that a warning names.
const MAX_NAMED_CHANNELS: usize = 12;

impl PlateFile {
    /// Writes the plate in the format of `row`, which is not its own. Returns warnings about everything that changes.
    ///
    /// # Errors
    /// A display window that is too large to be stored without a data window, and a target that cannot be written.
    pub(super) fn convert(&self, path: &Path, row: Row) -> Result<Vec<String>> {
        let (target, implementation) = row;
        let capabilities = target.capabilities;
        let mut warnings = self.lost_metadata(target, capabilities);
        let texts = self.new_texts(capabilities, &mut warnings);
        let mut image = NewImage {
            format: target,
            path: self.path().to_path_buf(),
            windows: self.windows,
            pixel_aspect: self.pixel_aspect(),
            names: self.names.clone(),
            colour: self.colour(),
            alpha: self.alpha(),
            premultiplied: self.is_premultiplied(),
            sample_format: self.sample_format(),
            encoding: None,
            icc_profile: None,
            texts,
            common: self.common(),
            colour_space: self.colour_space.clone(),
            compression: self.options.compression,
        };
        if !capabilities.data_window {
            self.fit_to_display_window(&mut image, target, &mut warnings)?;
        }
        image.convert_alpha(target, &mut warnings);
        image.convert_grey(target, &mut warnings);
        self.encode(&mut image, target, &mut warnings);
        warnings.extend(implementation.write_new(path, image)?);
        Ok(warnings)
    }

    /// Returns the common metadata.
    fn common(&self) -> CommonMetadata {
        match &self.source {
            Source::Exr {
                image, channels, ..
            } => image.common(channels.colour[0]),
            Source::Raster { image, .. } => image.metadata.common(),
        }
    }

    /// Returns warnings about channels and metadata that the target cannot store.
    fn lost_metadata(&self, target: Format, capabilities: Capabilities) -> Vec<String> {
        let mut warnings = Vec::new();
        let kept = if capabilities.common_metadata {
            self.common().names()
        } else {
            Vec::new()
        };
        match &self.source {
            Source::Exr { .. } if capabilities.layers => {}
            Source::Exr { image, .. } => {
                warnings.extend(self.lost_channels(target));
                if image.has_attributes_beside(&kept) {
                    let except = if kept.is_empty() {
                        String::new()
                    } else {
                        format!(" except {}", kept.join(", "))
                    };
                    warnings.push(format!("the attributes of the EXR are left out{except}"));
                }
            }
            Source::Raster { image, .. } => {
                let lost = image.metadata.conversion_loss(&kept);
                warnings.extend(lost.map(|lost| format!("{lost} are left out")));
                warnings.extend(image.lost_images());
            }
        }
        let aspect = self.pixel_aspect();
        if aspect != 1.0 && !capabilities.pixel_aspect {
            warnings.push(format!(
                "{target} cannot store the pixel aspect ratio, {aspect}"
            ));
        }
        warnings
    }

    /// Returns a warning about the channels of an EXR that are neither colour nor alpha.
    fn lost_channels(&self, target: Format) -> Option<String> {
        let Source::Exr {
            image, channels, ..
        } = &self.source
        else {
            return None;
        };
        let lost: Vec<String> = (image.channels().into_iter())
            .filter(|own| !channels.colour.contains(&own.id) && channels.alpha != Some(own.id))
            .map(|own| image.full_name(own))
            .collect();
        let named = lost[..lost.len().min(MAX_NAMED_CHANNELS)].join(", ");
        let more = match lost.len().saturating_sub(MAX_NAMED_CHANNELS) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        (!lost.is_empty())
            .then(|| format!("{target} stores a single image: channels {named}{more} are left out"))
    }

    /// Returns the texts that the target stores: provenance, and in some formats any.
    fn new_texts(&self, capabilities: Capabilities, warnings: &mut Vec<String>) -> TextAttributes {
        let all = match &self.source {
            Source::Exr {
                image, channels, ..
            } => image.provenance(channels.colour[0]),
            Source::Raster { image, .. } => image.texts.clone(),
        };
        let is_stored = |(name, _): &(String, String)| capabilities.texts || is_provenance(name);
        let (stored, lost): (TextAttributes, TextAttributes) = all.into_iter().partition(is_stored);
        let lost: Vec<String> = lost.into_iter().map(|(name, _)| name).collect();
        if !lost.is_empty() {
            warnings.push(format!("texts are left out: {}", lost.join(", ")));
        }
        stored
    }

    /// Crops the image to the display window, and pads it with black.
    fn fit_to_display_window(
        &self,
        image: &mut NewImage,
        target: Format,
        warnings: &mut Vec<String>,
    ) -> Result<()> {
        let ImageWindows { data, display } = image.windows;
        if data == display {
            return Ok(());
        }
        // Up to four planes of floats, and their copies.
        let bytes = display.width as u128 * display.height as u128 * 4 * 5;
        let field = "displayWindow";
        Limits::PLATE.check_size(self.path(), field, display.width, display.height)?;
        Limits::PLATE.check_bytes(self.path(), field, bytes, self.memory_bytes())?;
        if !display.encloses(data) {
            warnings.push(format!(
                "{target} has no data window: the plate is cropped to its display window, {display}"
            ));
        }
        if !data.encloses(display) {
            warnings.push(format!(
                "{target} has no data window: the plate is padded with black to its display window, {display}"
            ));
        }
        for plane in image.colour.iter_mut().chain(&mut image.alpha) {
            *plane = crop_or_pad(plane, data, display);
        }
        image.windows.data = display;
        Ok(())
    }

    /// Chooses the sample format, encodes the scene-linear samples, and decides whether the ICC profile stays valid.
    fn encode(&self, image: &mut NewImage, target: Format, warnings: &mut Vec<String>) {
        let source = self.sample_format();
        let is_managed = self.options.colour_managed;
        image.sample_format = (target.sample_format)(source, image.channels());
        if image.sample_format == SampleFormat::F16 && !image.fits_half() {
            image.sample_format = SampleFormat::F32;
        }
        let is_integer = image.sample_format.is_integer();
        // With colour management, samples are code values already.
        let encoding = if is_integer && !is_managed {
            self.options.encoding.unwrap_or(Encoding::Srgb)
        } else {
            Encoding::Linear
        };
        image.encoding = (!is_managed).then_some(encoding);
        let (source_encoding, icc_profile) = match &self.source {
            Source::Raster { image, encoding } => (*encoding, image.metadata.icc_profile()),
            Source::Exr { .. } => (Encoding::Linear, None),
        };
        if source != image.sample_format || source_encoding != encoding {
            let encoding = image
                .encoding
                .map_or_else(String::new, |encoding| format!(", {encoding}"));
            warnings.push(format!(
                "{source} samples are written as {}{encoding}",
                image.sample_format
            ));
        }
        for sample in image.colour.iter_mut().flatten() {
            *sample = encoding.encode(*sample);
        }
        // An ICC profile is valid for unchanged code values only.
        let is_valid = source_encoding == encoding && is_integer && !is_managed;
        if icc_profile.is_some() && !(is_valid && target.capabilities.icc_profile) {
            warnings.push("the ICC profile is left out".to_owned());
        } else {
            image.icc_profile = icc_profile.map(<[u8]>::to_vec);
        }
    }
}

impl NewImage {
    /// Returns whether all samples are within the range of half floats.
    fn fits_half(&self) -> bool {
        let samples = self.colour.iter().chain(&self.alpha).flatten();
        samples.into_iter().all(|v| v.abs() <= MAX_HALF)
    }

    /// Multiplies or divides colour by alpha as the target requires.
    fn convert_alpha(&mut self, target: Format, warnings: &mut Vec<String>) {
        match target.capabilities.alpha {
            AlphaSupport::Either => {}
            AlphaSupport::Premultiplied => self.premultiply(),
            AlphaSupport::Unpremultiplied => self.unpremultiply(target, warnings),
            AlphaSupport::None => {
                self.premultiply();
                if self.alpha.take().is_some() {
                    warnings.push(format!(
                        "{target} holds no alpha: it is left out, and colour stays multiplied by it"
                    ));
                }
            }
        }
    }

    /// Stores grey as equal R, G and B if the target requires it.
    fn convert_grey(&mut self, target: Format, warnings: &mut Vec<String>) {
        let is_stored = match target.capabilities.grey {
            GreySupport::Always => true,
            GreySupport::WithoutAlpha => self.alpha.is_none(),
            GreySupport::Never => false,
        };
        if self.names == ["Y"] && !is_stored {
            self.names = ["R", "G", "B"].map(str::to_owned).to_vec();
            self.colour = vec![self.colour[0].clone(); 3];
            warnings.push(format!(
                "Y is written as equal R, G and B, as {target} requires"
            ));
        }
    }

    fn premultiply(&mut self) {
        if let (Some(alpha), false) = (&self.alpha, self.premultiplied) {
            for plane in &mut self.colour {
                for (sample, alpha) in plane.iter_mut().zip(alpha) {
                    *sample *= alpha;
                }
            }
        }
        self.premultiplied = true;
    }

    fn unpremultiply(&mut self, target: Format, warnings: &mut Vec<String>) {
        let (Some(alpha), true) = (&self.alpha, self.premultiplied) else {
            return;
        };
        let is_lost = |i: usize| alpha[i] <= 0.0 && self.colour.iter().any(|p| p[i] != 0.0);
        let lost = (0..alpha.len()).filter(|&i| is_lost(i)).count();
        if lost > 0 {
            warnings.push(format!(
                "{target} holds colour that is not multiplied by alpha: {lost} pixels of colour without alpha are black"
            ));
        }
        for plane in &mut self.colour {
            for (sample, &alpha) in plane.iter_mut().zip(alpha) {
                *sample = if alpha > 0.0 { *sample / alpha } else { 0.0 };
            }
        }
        self.premultiplied = false;
    }
}
