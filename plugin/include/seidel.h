/* Seidel's C ABI: real lens blur, learned from measured point-spread functions.
 *
 * Generated from plugin/src by `cargo xtask header`; do not edit.
 *
 * Open a lens with seidel_lens_open, fill a SeidelSettings with seidel_settings_init, describe the images of a plate in
 * a SeidelPlate, and call seidel_apply, seidel_remove, seidel_match_colours or seidel_relens. plugin/examples/apply.c is a
 * complete program.
 *
 * Errors: functions that can fail return a SeidelStatus; seidel_last_error describes the last failure on the calling
 * thread. No panic leaves the library, and it prints nothing but Rust's own panic message on stderr.
 * Threads: all functions may be called from any number of threads at once.
 * Memory: buffers belong to the caller, and the library keeps no pointer to them after a call.
 * Versions: structs begin with their size, which the caller sets, so that later versions can add members.
 * Units: positions are plate pixels, x to the right, y down. Samples are scene-linear. Distances are metres along the
 * optical axis from the entrance pupil; vergence is 1 / distance. */

#ifndef SEIDEL_H
#define SEIDEL_H

#include <stddef.h>
#include <stdint.h>

/**
 * Version of the ABI that this header describes. It grows when functions, structs or members are added; existing
 * ones do not change, so that a program runs with any library of its own ABI version or a later one.
 */
#define SEIDEL_ABI_VERSION 1

/**
 * The profile describes moments of PSFs. Focus, f-number and sensor shift cannot be set.
 */
#define SEIDEL_LENS_MOMENTS 0

/**
 * The profile describes the lens ray by ray. Focus, f-number and sensor shift can be set.
 */
#define SEIDEL_LENS_RAYS 1

/**
 * Blur only: each kernel has its centroid on its source pixel.
 */
#define SEIDEL_GEOMETRY_NONE 0

/**
 * Blur and lateral colour: channels are displaced against each other, without distortion. The default.
 */
#define SEIDEL_GEOMETRY_LATERAL 1

/**
 * Blur, lateral colour and distortion.
 */
#define SEIDEL_GEOMETRY_FULL 2

/**
 * The mirrored plate lies beyond the plate, so that no light is lost.
 */
#define SEIDEL_EDGES_MIRROR 0

/**
 * Black lies beyond the plate: light that leaves it is lost.
 */
#define SEIDEL_EDGES_BLACK 1

/**
 * The nearest pixel of the plate lies beyond it, with its depth and blur.
 */
#define SEIDEL_EDGES_EXTEND 2

/**
 * An earlier name of SEIDEL_EDGES_EXTEND.
 */
#define SEIDEL_EDGES_NEAREST SEIDEL_EDGES_EXTEND

/**
 * The edges are chosen by the alpha along the border: mirrored for full frames, black for elements over nothing,
 * extended for elements that the border cuts. The default.
 */
#define SEIDEL_EDGES_AUTO 3

/**
 * For previews: 45 dB peak signal-to-noise ratio against SEIDEL_QUALITY_EXACT.
 */
#define SEIDEL_QUALITY_DRAFT 0

/**
 * For delivery: 60 dB, 75 dB where no blur is above 6 px, 50 dB for a lens drawn ray by ray. The default.
 */
#define SEIDEL_QUALITY_FINAL 1

/**
 * Exact: every source pixel is scattered with its own kernel. Slow.
 */
#define SEIDEL_QUALITY_EXACT 2

/**
 * Colour is multiplied by alpha (associated alpha). The default.
 */
#define SEIDEL_ALPHA_PREMULTIPLIED 0

/**
 * Colour is not multiplied by alpha (straight alpha).
 */
#define SEIDEL_ALPHA_UNPREMULTIPLIED 1

/**
 * Depth is the distance along the optical axis, in units of `depth_unit` metres. The default.
 */
#define SEIDEL_DEPTH_DISTANCE 0

/**
 * Depth is 1 / distance, with the distance in units of `depth_unit` metres; 0 is infinity.
 */
#define SEIDEL_DEPTH_INVERSE 1

/**
 * Depth is 0 at `depth_near` and 1 at `depth_far`, linear in distance.
 */
#define SEIDEL_DEPTH_FAR_ONE 2

/**
 * Depth is 1 at `depth_near` and 0 at `depth_far`, linear in distance.
 */
#define SEIDEL_DEPTH_FAR_ZERO 3

/**
 * The clip level of each colour is estimated from the plate. The default.
 */
#define SEIDEL_CLIP_AUTO 0

/**
 * No sample counts as clipped.
 */
#define SEIDEL_CLIP_NONE 1

/**
 * Samples at or above `clip_level` count as clipped.
 */
#define SEIDEL_CLIP_LEVEL 2

/**
 * The sharp image gets the plate's own grain. The default.
 */
#define SEIDEL_GRAIN_KEEP 0

/**
 * The sharp image is the solution as it is, nearly without grain.
 */
#define SEIDEL_GRAIN_SOLVED 1

/**
 * The iris blades of the lens.
 */
#define SEIDEL_BLADES_OF_LENS UINT32_MAX

/**
 * 16-bit samples: IEEE 754 half precision.
 */
#define SEIDEL_HALF 1

/**
 * 32-bit samples: IEEE 754 single precision.
 */
#define SEIDEL_FLOAT 2

/**
 * The result of a call. After any status but SEIDEL_STATUS_OK, `seidel_last_error` describes the failure, and images
 * are as they were before the call. Any function may return SEIDEL_STATUS_ARGUMENT for a NULL pointer that it does
 * not allow and for values out of range, SEIDEL_STATUS_UNSUPPORTED for a struct of a later version, and
 * SEIDEL_STATUS_PANICKED.
 */
typedef enum SeidelStatus {
  /**
   * The call succeeded.
   */
  SEIDEL_STATUS_OK = 0,
  /**
   * An argument is not valid: a NULL pointer, a value out of range, a released handle, a sample that is not
   * finite.
   */
  SEIDEL_STATUS_ARGUMENT = 1,
  /**
   * The lens profile cannot be read or is not valid.
   */
  SEIDEL_STATUS_LENS = 2,
  /**
   * This lens or this version of the library cannot do what the call asks for.
   */
  SEIDEL_STATUS_UNSUPPORTED = 3,
  /**
   * Memory ran out, or the call needs more than `memory` of the settings allows.
   */
  SEIDEL_STATUS_MEMORY = 4,
  /**
   * The progress callback stopped the call.
   */
  SEIDEL_STATUS_ABORTED = 5,
  /**
   * An internal error of the library. Handles remain valid, and the process can go on calling it.
   */
  SEIDEL_STATUS_PANICKED = 6,
  /**
   * A buffer is too small. The size needed was written.
   */
  SEIDEL_STATUS_TOO_SMALL = 7,
} SeidelStatus;

/**
 * Handle of a lens. Any number of threads may use it at the same time.
 */
typedef struct SeidelLens SeidelLens;

/**
 * Description of a lens as measured. Unknown numbers are NaN.
 */
typedef struct SeidelLensInfo {
  /**
   * sizeof(SeidelLensInfo); set it before the call.
   */
  uint64_t size;
  /**
   * SEIDEL_LENS_MOMENTS or SEIDEL_LENS_RAYS.
   */
  uint32_t kind;
  /**
   * Number of colour channels; seidel_lens_channel returns their names.
   */
  uint32_t channels;
  /**
   * Number of PSF models that can draw the lens; seidel_lens_model returns their names.
   */
  uint32_t models;
  /**
   * 1 if the blur depends on distance, else 0.
   */
  uint32_t knows_depth;
  /**
   * Width of the frame, pixels.
   */
  uint32_t frame_width;
  /**
   * Height of the frame, pixels.
   */
  uint32_t frame_height;
  /**
   * Optical axis, pixels to the right of the frame's left edge.
   */
  double axis_x;
  /**
   * Optical axis, pixels below the frame's top edge.
   */
  double axis_y;
  /**
   * Pixel pitch, micrometres.
   */
  double pixel_pitch_um;
  /**
   * Focal length, millimetres.
   */
  double focal_length_mm;
  /**
   * F-number at which the lens was measured.
   */
  double f_number;
  /**
   * Focus distance at which the lens was measured, metres; may be INFINITY.
   */
  double focus_distance;
  /**
   * Smallest object distance that was measured, metres.
   */
  double nearest;
  /**
   * Largest object distance that was measured, metres; may be INFINITY.
   */
  double farthest;
} SeidelLensInfo;

/**
 * Lens and plate settings. Fill it by seidel_settings_init, then change members. Members whose comment states a
 * meaning of NaN may be NaN. Switches are 0 or 1. The options of the `seidel` command have the same names. The members from
 * `blades` to `bloom_radius` are the look of the lens as f-number and focus distance set it, in seidel_apply, seidel_kernel,
 * seidel_region_of_interest and for the new lens of seidel_relens.
 */
typedef struct SeidelSettings {
  /**
   * sizeof(SeidelSettings).
   */
  uint64_t size;
  /**
   * Strength of the lens's blur and displacement: 0 leaves the plate unchanged, 1 is as measured (0 to 16). Default
   * 1.
   */
  double amount;
  /**
   * Strength of the blur of each lens channel, in the order of the lens, on top of `amount`: above 0, up to 16.
   * NULL: 1 for all.
   */
  const double *channel_scales;
  /**
   * Length of `channel_scales`: the number of lens channels, or 0.
   */
  uint32_t channel_scale_count;
  /**
   * Displacement of light by the lens: SEIDEL_GEOMETRY_...
   */
  uint32_t geometry;
  /**
   * Offset of the optical axis to the right, plate pixels.
   */
  double axis_offset_x;
  /**
   * Offset of the optical axis downwards, plate pixels.
   */
  double axis_offset_y;
  /**
   * Name of the PSF model, UTF-8. NULL or "": the default of the lens. See seidel_lens_model.
   */
  const char *psf_model;
  /**
   * Distance to focus the lens on (metres or inf; as measured if NaN). For lenses of rays: those of the library, and
   * those fitted by the model reduced or extended.
   */
  double focus_distance;
  /**
   * F-number to stop the lens down to (as measured if NaN). Below the measured one the blur is extrapolated. For
   * lenses of rays.
   */
  double f_number;
  /**
   * Shift of the sensor away from the lens; negative towards it (micrometres; as measured if NaN). For lenses of
   * rays.
   */
  double sensor_shift_um;
  /**
   * Depth of the range that is as sharp as the focus plane, half of it on each side (metres). Default 0. Beyond the
   * range, depth is measured from its nearer end.
   */
  double depth_of_field;
  /**
   * Factor on the distance from focus, in vergence, in front of the focus plane: blur grows as many times as fast (0
   * to 16). Default 1.
   */
  double front_multiplier;
  /**
   * Factor on the distance from focus, in vergence, behind the focus plane (0 to 16). Default 1.
   */
  double back_multiplier;
  /**
   * Radius of the largest kernel in the frame: that of a uniform disc (plate pixels; none if NaN). For other kernels
   * it is two standard deviations. A larger kernel is replaced by that of the distance at which it has this radius.
   */
  double maximum_size;
  /**
   * Accuracy of the render, as PSNR against the exact renderer: SEIDEL_QUALITY_... (seidel_apply)
   */
  uint32_t quality;
  /**
   * Light beyond the edges of the plate: SEIDEL_EDGES_... (seidel_apply)
   */
  uint32_t edges;
  /**
   * Switch: Near surfaces occlude far ones where depth varies; otherwise the light of all depths is added. Default
   * 1. (seidel_apply)
   */
  uint32_t occlusion;
  /**
   * Switch: Background that a blurred foreground uncovers is filled from the background beside it, rather than with
   * the foreground's own light. Default 1. (seidel_apply)
   */
  uint32_t fill_foreground;
  /**
   * Switch: A blurred foreground becomes transparent inside its own outline too, as in a camera; otherwise it only
   * blurs outwards. Default 1. (seidel_apply)
   */
  uint32_t blur_inside;
  /**
   * SEIDEL_ALPHA_...
   */
  uint32_t alpha;
  /**
   * Switch: each colour has an alpha of its own, blurred like the colour and written to `alphas`. Default 0.
   */
  uint32_t alpha_per_channel;
  /**
   * Switch: samples that are not finite count as zero; otherwise the call fails. Default 0.
   */
  uint32_t scrub;
  /**
   * Scale of the lens's frame on the plate, along y (plate pixels per pixel of the lens's frame; from the display
   * window if NaN).
   */
  double lens_scale;
  /**
   * Width of a plate pixel over its height in the scene, 1/16 to 16: 2 for a plate of a 2x anamorphic lens before it is
   * desqueezed. Default 1.
   */
  double pixel_aspect;
  /**
   * Object distance of a plate without a depth image, metres; may be INFINITY. NaN: unknown.
   */
  double distance;
  /**
   * Metres per unit of depth; negative if depth is negative. Default 1.
   */
  double depth_unit;
  /**
   * Nearest distance of a normalised depth, metres.
   */
  double depth_near;
  /**
   * Farthest distance of a normalised depth, metres.
   */
  double depth_far;
  /**
   * Focal length in widths of a plate pixel, if depth is measured along the ray from the camera. NaN: along the
   * axis.
   */
  double along_ray;
  /**
   * SEIDEL_DEPTH_...
   */
  uint32_t depth_kind;
  /**
   * Level from which samples are clipped: they and the pixels that their light reaches keep their blur:
   * SEIDEL_CLIP_... (blur removal)
   */
  uint32_t clip;
  /**
   * Level from which samples are clipped, where clipping is by level (scene-linear). Default 1. (blur removal)
   */
  double clip_level;
  /**
   * Standard deviation of the noise of each colour, scene-linear. NaN in the first entry: estimated from the
   * plate; in another entry: that of the first. The fourth entry is not used. (blur removal)
   */
  double noise[4];
  /**
   * Weight of the sharp image against the plate: 0 leaves the plate unchanged (0 to 1). Default 1. (seidel_remove)
   */
  double strength;
  /**
   * Grain of the sharp image: SEIDEL_GRAIN_... (seidel_remove)
   */
  uint32_t grain;
  /**
   * Most threads of a call, up to 1024; 0: one for each core. Results do not depend on it.
   */
  uint32_t threads;
  /**
   * Most memory that a call may need by seidel_memory_needed, bytes; 0: no limit.
   */
  uint64_t memory;
  /**
   * Iris blades: 3 to 13, 0 for a round iris, SEIDEL_BLADES_OF_LENS. The default is that of the lens. All looks but bloom
   * need a lens of the kind SEIDEL_LENS_RAYS.
   */
  uint32_t blades;
  /**
   * Width of the picture of the aperture, pixels.
   */
  uint32_t aperture_width;
  /**
   * Picture of the aperture, 0 to 1, white where light passes: rows of `aperture_width` values from the top. Background
   * discs show it; its shorter side is the width of the pupil. NULL: none.
   */
  const float *aperture;
  /**
   * Length of `aperture`: whole rows, at most 8192 of at most 8192 values.
   */
  uint64_t aperture_count;
  /**
   * Curvature of the iris blades: 0 straight, 1 one circle (0 to 1). Default 0.
   */
  double roundness;
  /**
   * Direction of one corner of discs before the focus, from right towards down (-180 to 180 degrees). Default 0.
   * Discs behind the focus are turned by 180 degrees.
   */
  double rotation;
  /**
   * Height of discs over their width, times that of the lens: 2 for the ovals of a 2x anamorphic lens (0.4 to 2.5).
   * Default 1.
   */
  double squeeze;
  /**
   * Radius of the dark middle of discs over theirs, as of a mirror lens; 0 as the lens (0 to 0.9). Default 0.
   */
  double obstruction;
  /**
   * Cat's eyes towards the corners: -1 round discs, 0 as the lens, 1 strong ones (-1 to 1). Default 0.
   */
  double cats_eye;
  /**
   * Spherical aberration added: -1 soft discs behind the focus, 1 bubbles with bright rims (-1 to 1). Default 0.
   * Before the focus it is the other way round.
   */
  double spherical;
  /**
   * Factor on the difference of focus between channels: 0 none, 1 as the lens (-4 to 4). Default 1.
   */
  double axial_colour;
  /**
   * Factor on the difference of magnification between channels: 0 none, 1 as the lens (-4 to 4). Default 1. Without
   * lateral colour in the geometry it has no effect.
   */
  double lateral_colour;
  /**
   * Share of the light above the bloom level that spreads around highlights; any lens (0 to 1). Default 0.
   */
  double bloom;
  /**
   * Value above which light spreads (scene-linear). Default 1.
   */
  double bloom_level;
  /**
   * Radius that holds half of the spread light (0.05 to 20 per cent of the width of the lens's frame). Default 1.
   */
  double bloom_radius;
  /**
   * Focal length to scale the lens and its frame to; f-number and focus distance stay (millimetres; as measured if
   * NaN). Blur is that of a lens of this focal length with the measured one's aberrations. For lenses of rays: those
   * of the library, and those fitted by the model reduced or extended.
   */
  double focal_length_mm;
  /**
   * Width of the sensor that the display window shows (film back), instead of the lens scale: a smaller sensor crops
   * the lens's frame (millimetres; by the lens scale if NaN). Common widths: 36 for full frame, 24.9 for Super 35,
   * 12.5 for Super 16. The lens profile must have a pixel pitch. Beyond the frame of the lens its blur is
   * extrapolated.
   */
  double film_back_mm;
  /**
   * Focal length of the lens that the plate was taken with (millimetres; that of both lenses if NaN).
   * (seidel_relens)
   */
  double from_focal_length_mm;
  /**
   * F-number of the lens that the plate was taken with (that of both lenses if NaN). (seidel_relens)
   */
  double from_f_number;
  /**
   * Shift of the sensor of the lens that the plate was taken with (micrometres; that of both lenses if NaN).
   * (seidel_relens)
   */
  double from_sensor_shift_um;
  /**
   * Focus distance of the lens that the plate was taken with (metres or inf; that of both lenses if NaN).
   * (seidel_relens)
   */
  double from_focus_distance;
  /**
   * Focal length of the lens whose blur the plate gets (millimetres; that of both lenses if NaN). (seidel_relens)
   */
  double to_focal_length_mm;
  /**
   * F-number of the lens whose blur the plate gets (that of both lenses if NaN). (seidel_relens)
   */
  double to_f_number;
  /**
   * Shift of the sensor of the lens whose blur the plate gets (micrometres; that of both lenses if NaN).
   * (seidel_relens)
   */
  double to_sensor_shift_um;
  /**
   * Focus distance of the lens whose blur the plate gets (metres or inf; that of both lenses if NaN).
   * (seidel_relens)
   */
  double to_focus_distance;
  /**
   * Weight of the blurred plate against its own pixels, times that of the mask (0 to 1). Default 1. (seidel_apply)
   */
  double mix;
  /**
   * Switch: The lens's axial and lateral colour alone, without the blur that all colours share. Default 0. At each
   * place and distance the sharpest colour stays sharp, and the others blur by as much as their variance exceeds its
   * own. (seidel_apply)
   */
  uint32_t only_chroma;
  /**
   * What the mask scales: SEIDEL_MASK_SCALES_... The blur is scaled before it is rendered, so a part that a mask
   * keeps sharp has no blurred copy of itself around it. (seidel_apply)
   */
  uint32_t mask_scales;
  /**
   * Tilt of the lens, as of a tilt-shift lens: the plane of focus turns by Scheimpflug's rule (-30 to 30 degrees).
   * Default 0. Needs a lens of known focal length and f-number.
   */
  double tilt;
  /**
   * Direction in the picture along which the tilted plane of focus comes nearer, from right towards down: 90 lays it
   * along the ground (-180 to 180 degrees). Default 90. At -90 one strip of the ground is sharp, as in photographs
   * of small models.
   */
  double tilt_direction;
  /**
   * Width over which depth is averaged at edges, by a filter or by motion over the shutter, plate pixels, up to 256: edges
   * up to that wide are divided between their two sides. Default 0: none.
   */
  double depth_filter;
} SeidelSettings;

/**
 * A rectangle of plate pixels: x grows to the right, y downwards. In arguments, width and height must be at least 1
 * and no member above 16777216 in magnitude.
 */
typedef struct SeidelRect {
  /**
   * First column.
   */
  int32_t left;
  /**
   * First row.
   */
  int32_t top;
  /**
   * Number of columns.
   */
  int32_t width;
  /**
   * Number of rows.
   */
  int32_t height;
} SeidelRect;

/**
 * An image in the caller's memory, which the library reads or writes in place. It may have any alignment and any
 * padding between pixels and rows; the library touches its samples only.
 */
typedef struct SeidelImage {
  /**
   * sizeof(SeidelImage).
   */
  uint64_t size;
  /**
   * First sample of the pixel at (rect.left, rect.top), the top-left one.
   */
  void *data;
  /**
   * Bytes from a pixel to the pixel below it; negative if rows are stored from the bottom up.
   */
  int64_t row_bytes;
  /**
   * Bytes from a pixel to the pixel on its right; 0 if pixels are packed. With `data` it selects some channels of
   * many.
   */
  uint32_t pixel_bytes;
  /**
   * Samples per pixel, 1 to 4. Of a plate: 1 is Y; 2 are Y, A; 3 are R, G, B; 4 are R, G, B, A.
   */
  uint32_t channels;
  /**
   * SEIDEL_HALF or SEIDEL_FLOAT.
   */
  uint32_t sample;
  /**
   * Unused; set it to 0.
   */
  uint32_t reserved;
  /**
   * The pixels of the plate that the image holds.
   */
  struct SeidelRect rect;
} SeidelImage;

/**
 * A plate. Its images may hold more or less than the extent. Pixels of the extent that `source` or `alphas` lacks
 * are black and transparent; where a depth image or matte has no pixel, its nearest one counts.
 */
typedef struct SeidelPlate {
  /**
   * sizeof(SeidelPlate).
   */
  uint64_t size;
  /**
   * Display window: the picture without overscan. It lies centre on centre with the frame of the lens.
   */
  struct SeidelRect format;
  /**
   * Data window: all pixels that exist, overscan or crop included. Beyond it lies what `edges` of the settings
   * states.
   */
  struct SeidelRect extent;
  /**
   * Scene-linear samples.
   */
  const struct SeidelImage *source;
  /**
   * Depth image, of which the first channel is read. NULL: everything is at `distance` of the settings.
   */
  const struct SeidelImage *depth;
  /**
   * Holdout matte, 0 to 1, of something that will be composited in front; its first channel is read. NULL: none.
   * Only seidel_apply reads it.
   */
  const struct SeidelImage *matte;
  /**
   * Depth of the matte, with the conventions of `depth`: only light from behind it is held out. NULL: all light
   * is.
   */
  const struct SeidelImage *matte_depth;
  /**
   * Alpha of each colour, one channel a colour, if `alpha_per_channel` is set. NULL: each is the alpha of
   * `source`.
   */
  const struct SeidelImage *alphas;
  /**
   * Mask of seidel_apply, 0 to 1; its first channel is read. By `mask_scales` of the settings it is the weight of the blurred plate
   * against its own pixels, times `mix`, or a factor of the blur. NULL: 1 everywhere.
   */
  const struct SeidelImage *mask;
} SeidelPlate;

/**
 * Progress callback. It gets `user` of SeidelCallbacks and the share of the work done, from 0 to 1 and never
 * decreasing. The library calls it at the start, about every 10 ms and at the end, always on the thread that made
 * the call. Return 0 to go on. Any other value before the end stops the work: the call then returns
 * SEIDEL_STATUS_ABORTED within 100 ms. The callback may call the library. It must return normally: no exception and
 * no longjmp.
 */
typedef int32_t (*SeidelProgress)(void *user, double share);

/**
 * Callbacks of a call.
 */
typedef struct SeidelCallbacks {
  /**
   * sizeof(SeidelCallbacks).
   */
  uint64_t size;
  /**
   * Passed to `progress` unchanged.
   */
  void *user;
  /**
   * May be NULL.
   */
  SeidelProgress progress;
} SeidelCallbacks;

/**
 * Results of seidel_remove beside the image. The caller sets `size` and the two images; the library writes the other
 * members. Arrays have one entry for each colour, in the order of the source.
 */
typedef struct SeidelFindings {
  /**
   * sizeof(SeidelFindings).
   */
  uint64_t size;
  /**
   * Gets the share of each pixel's detail that the plate determines, 0 to 1, one channel a colour; 0 where blur is
   * kept. NULL: not wanted.
   */
  const struct SeidelImage *confidence;
  /**
   * Gets the noise of the sharp image over that of the plate, one channel a colour. NULL: not wanted. It doubles
   * the time of the call.
   */
  const struct SeidelImage *noise_gain;
  /**
   * All pixels that were estimated: the plate's extent and a margin around it.
   */
  struct SeidelRect found;
  /**
   * Standard deviation of the noise, scene-linear, as set or as estimated from the plate.
   */
  double noise[3];
  /**
   * Root mean square of the residual over that expected from the noise. Well above 1.5, the lens does not explain
   * the plate.
   */
  double misfit[3];
  /**
   * Level at which samples are clipped; NaN if none are.
   */
  double clip_level[3];
  /**
   * Number of clipped samples.
   */
  uint64_t clipped[3];
} SeidelFindings;

/**
 * A kernel: the distribution of the light of one source pixel over plate pixels. The caller sets `size`, `weights`
 * and `capacity`; the library writes the other members.
 */
typedef struct SeidelKernel {
  /**
   * sizeof(SeidelKernel).
   */
  uint64_t size;
  /**
   * Gets `width` * `height` weights, row by row from the top; their sum is one. NULL: only the size is wanted.
   */
  float *weights;
  /**
   * Number of weights that `weights` has room for.
   */
  uint64_t capacity;
  /**
   * First column, relative to the source pixel.
   */
  int32_t left;
  /**
   * First row, relative to the source pixel.
   */
  int32_t top;
  /**
   * Number of columns.
   */
  uint32_t width;
  /**
   * Number of rows.
   */
  uint32_t height;
} SeidelKernel;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Returns the ABI version of the loaded library. If it is less than SEIDEL_ABI_VERSION, functions of this header may
 * be missing.
 */
uint32_t seidel_abi_version(void);

/**
 * Returns the version of the library, such as "0.1.0". The string belongs to the library and is valid while it is
 * loaded.
 */
const char *seidel_version(void);

/**
 * Copies a description of the last failure on the calling thread to `buffer`, in UTF-8 with a terminating zero, cut
 * between characters to `capacity` bytes. It names the argument, file or pixel, the problem and the remedy. Returns
 * the size of the whole text in bytes with its zero, at most 2049; 1, an empty text, if the last call succeeded.
 * `buffer` may be NULL to get the size.
 *
 * Pointers:
 * `buffer`: NULL, or `capacity` writable bytes.
 */
size_t seidel_last_error(char *buffer,
                         size_t capacity);

/**
 * Opens the lens profile in the file `path`, a string in UTF-8, and writes its handle to `*lens`. The caller owns
 * the handle and releases it with seidel_lens_release. After a failure `*lens` is unchanged.
 *
 * `path` may also name a lens of the library as library:NAME; `seidel lens list` prints the names. A file of that name
 * comes first.
 *
 * Errors: SEIDEL_STATUS_LENS for a file that cannot be read or is not a lens profile.
 *
 * Pointers:
 * `path`: a string with a terminating zero. `lens`: a writable place for a handle.
 */
enum SeidelStatus seidel_lens_open(const char *path,
                                   struct SeidelLens **lens);

/**
 * Opens a lens profile like seidel_lens_open, from `length` bytes of JSON text in memory. The text need not end with
 * a zero and is not used after the call.
 *
 * Errors: SEIDEL_STATUS_LENS for text that is not a lens profile.
 *
 * Pointers:
 * `json`: `length` readable bytes. `lens`: a writable place for a handle.
 */
enum SeidelStatus seidel_lens_read(const char *json,
                                   size_t length,
                                   struct SeidelLens **lens);

/**
 * Adds a reference to a handle: it then needs one more seidel_lens_release.
 *
 * Errors: SEIDEL_STATUS_ARGUMENT for a released handle. No memory is read through `lens`, so any value is safe.
 */
enum SeidelStatus seidel_lens_retain(const struct SeidelLens *lens);

/**
 * Removes a reference from a handle; NULL is allowed. The last release frees the lens as soon as no call uses it.
 * When no lens is left, the library's threads finish their work and end, and this call waits for them.
 *
 * Errors: SEIDEL_STATUS_ARGUMENT for a released handle. No memory is read through `lens`, so any value is safe.
 */
enum SeidelStatus seidel_lens_release(const struct SeidelLens *lens);

/**
 * Writes a description of a lens to `*info`, whose `size` the caller has set.
 *
 * Pointers:
 * `info`: as many writable bytes as its `size` states.
 */
enum SeidelStatus seidel_lens_info(const struct SeidelLens *lens, struct SeidelLensInfo *info);

/**
 * Copies the name of colour channel `index`, counted from 0, to `buffer`: for example "R", in UTF-8 with a
 * terminating zero. `*needed` gets the size of the whole name in bytes with its zero.
 *
 * Errors: SEIDEL_STATUS_ARGUMENT for an index that the lens does not have; SEIDEL_STATUS_TOO_SMALL if `buffer` is
 * NULL or `capacity` is less than `*needed`, in which case the copy is cut.
 *
 * Pointers:
 * `buffer`: NULL, or `capacity` writable bytes. `needed`: NULL, or a writable place for a number.
 */
enum SeidelStatus seidel_lens_channel(const struct SeidelLens *lens,
                                      uint32_t index,
                                      char *buffer,
                                      size_t capacity,
                                      size_t *needed);

/**
 * Copies the name of PSF model `index`, counted from 0, as seidel_lens_channel does. These are the models that can
 * draw the lens; the first is the default, the most faithful one.
 *
 * Errors: those of seidel_lens_channel.
 *
 * Pointers:
 * As for seidel_lens_channel.
 */
enum SeidelStatus seidel_lens_model(const struct SeidelLens *lens,
                                    uint32_t index,
                                    char *buffer,
                                    size_t capacity,
                                    size_t *needed);

/**
 * Fills `*settings` with the defaults. The caller has set its `size` to sizeof(SeidelSettings).
 *
 * Pointers:
 * `settings`: as many writable bytes as its `size` states.
 */
enum SeidelStatus seidel_settings_init(struct SeidelSettings *settings);

/**
 * Applies the blur of a lens to a plate and writes the pixels of `output.rect`, which must lie in the extent of the
 * plate. `output` has as many channels as the source and may be the memory of the source. If the source covers
 * seidel_region_of_interest, the result is bit-identical to that part of a render of the whole plate. `alphas` gets
 * the alpha of each colour over `output.rect` if `alpha_per_channel` is set, and is NULL otherwise. `settings` may
 * be NULL for the defaults, `callbacks` NULL for none.
 *
 * Errors: SEIDEL_STATUS_ARGUMENT for invalid arguments and settings, and for a sample that is not finite;
 * SEIDEL_STATUS_UNSUPPORTED for settings that the lens does not support; SEIDEL_STATUS_MEMORY;
 * SEIDEL_STATUS_ABORTED.
 *
 * Pointers:
 * Each pointer: NULL, or valid until the call returns. No other thread may use the outputs meanwhile.
 */
enum SeidelStatus seidel_apply(const struct SeidelLens *lens,
                               const struct SeidelSettings *settings,
                               const struct SeidelPlate *plate,
                               const struct SeidelImage *output,
                               const struct SeidelImage *alphas,
                               const struct SeidelCallbacks *callbacks);

/**
 * Removes the blur of the lens that a plate was taken with. The source must cover the extent: missing pixels count
 * as black. The depth image is that of the sharp image. `output.rect` may reach beyond the extent, where light that
 * landed on the plate was estimated; pixels beyond `found` of the findings are black. `alphas` is as for
 * seidel_apply. `findings`, `settings` and `callbacks` may be NULL. With `amount` or `strength` 0 the plate is
 * copied and the maps are 1.
 *
 * Errors: those of seidel_apply.
 *
 * Pointers:
 * As for seidel_apply; images of `*findings` are outputs.
 */
enum SeidelStatus seidel_remove(const struct SeidelLens *lens,
                                const struct SeidelSettings *settings,
                                const struct SeidelPlate *plate,
                                const struct SeidelImage *output,
                                const struct SeidelImage *alphas,
                                struct SeidelFindings *findings,
                                const struct SeidelCallbacks *callbacks);

/**
 * Removes the blur of the lens `from` from a plate and applies that of `to`. The plate keeps its grain. The settings
 * hold for both lenses, but `from_...` and `to_...` for one of them; `strength` and `grain` are not used. `output.rect` must lie in the extent. All else, errors
 * included, is as for seidel_remove.
 *
 * Pointers:
 * As for seidel_apply.
 */
enum SeidelStatus seidel_relens(const struct SeidelLens *from,
                                const struct SeidelLens *to,
                                const struct SeidelSettings *settings,
                                const struct SeidelPlate *plate,
                                const struct SeidelImage *output,
                                const struct SeidelImage *alphas,
                                const struct SeidelCallbacks *callbacks);

/**
 * Writes to `*blur_share` the blur that a plate shows as a share of the blur of a lens: 1 if nothing speaks against
 * the lens. To do as `seidel remove` does, multiply `amount` by a share below 1 before the removal, since removing
 * too much blur causes ringing, and only warn about a share above 1. A plate of less than 96 pixels either way, or
 * without detail above its noise, gives 1. `settings` and `callbacks` may be NULL as for seidel_apply; `amount` must
 * not be 0.
 *
 * Errors: those of seidel_remove.
 *
 * Pointers:
 * Each pointer: NULL, or valid until the call returns.
 */
enum SeidelStatus seidel_check_lens(const struct SeidelLens *lens,
                                    const struct SeidelSettings *settings,
                                    const struct SeidelPlate *plate,
                                    double *blur_share,
                                    const struct SeidelCallbacks *callbacks);

/**
 * Draws the kernel of lens channel `channel`, counted from 0, at the point (`x`, `y`) of a plate, for an object at
 * `distance`. `x` and `y` are in plate pixels; the centre of pixel (0, 0) is (0.5, 0.5). `distance` is in metres and
 * may be INFINITY, or NaN if the blur of the lens does not depend on it. Of the plate, only `format` and `extent`
 * are used. `settings` may be NULL for the defaults.
 *
 * Errors: SEIDEL_STATUS_TOO_SMALL if `weights` is NULL or has too little room; the other members of `*kernel` are
 * then written. Otherwise as for seidel_apply.
 *
 * Pointers:
 * Each pointer: NULL, or valid until the call returns. `kernel->weights`: NULL, or room for `kernel->capacity`
 * numbers.
 */
enum SeidelStatus seidel_kernel(const struct SeidelLens *lens,
                                const struct SeidelSettings *settings,
                                const struct SeidelPlate *plate,
                                uint32_t channel,
                                double x,
                                double y,
                                double distance,
                                struct SeidelKernel *kernel);

/**
 * Writes to `*region` the pixels of the source that seidel_apply needs for a bit-identical result in `window`. With
 * SEIDEL_QUALITY_EXACT, edges that are not SEIDEL_EDGES_AUTO, one distance and a PSF model that needs no rays, these are `window` and the reach of the
 * kernels about it. Otherwise they are the whole extent: the fast renderer chooses its highlights, and occlusion its
 * depth layers, from the whole plate. seidel_remove, seidel_relens and seidel_check_lens always need the whole
 * extent. Of the plate, `format`, `extent` and the presence of `depth` matter. `settings` may be NULL for the
 * defaults.
 *
 * Errors: those of seidel_apply.
 *
 * Pointers:
 * Each pointer: NULL, or valid until the call returns.
 */
enum SeidelStatus seidel_region_of_interest(const struct SeidelLens *lens,
                                            const struct SeidelSettings *settings,
                                            const struct SeidelPlate *plate,
                                            const struct SeidelRect *window,
                                            struct SeidelRect *region);

/**
 * Takes the lateral and axial colour of a lens off a plate of R, G and B, and sharpens nothing else: every colour gets the
 * blur, and the place, of the colour whose blur is of middle size. Alpha does not change. `grain` of the settings is not
 * used. `output.rect` must lie in the extent. All else, errors included, is as for seidel_remove.
 *
 * Pointers:
 * As for seidel_apply.
 */
enum SeidelStatus seidel_match_colours(const struct SeidelLens *lens,
                                       const struct SeidelSettings *settings,
                                       const struct SeidelPlate *plate,
                                       const struct SeidelImage *output,
                                       const struct SeidelImage *alphas,
                                       const struct SeidelCallbacks *callbacks);

/**
 * Writes to `*bytes` the most memory that a call takes for a plate, in bytes, beside the caller's own images: with
 * `removal` 0 for seidel_apply, with 1 for seidel_remove, seidel_relens and seidel_check_lens. Of the plate,
 * `extent`, the channels of `source` and whether there is a `depth` matter; `source` may be NULL, which counts as 4 channels.
 * `settings` may be NULL for the defaults.
 *
 * Pointers:
 * Each pointer: NULL, or valid until the call returns.
 */
enum SeidelStatus seidel_memory_needed(const struct SeidelSettings *settings,
                                       const struct SeidelPlate *plate,
                                       uint32_t removal,
                                       uint64_t *bytes);

/**
 * Writes to `*distance` the object distance at the pixel (`x`, `y`) of the plate, in metres along the optical axis: the
 * median of the depth image over a disc of 3 pixels' radius, so that noise and fine gaps do not count. It may be INFINITY. As
 * `focus_distance` of the settings it focuses on what the pixel shows, as the option --focus-at of the command does.
 * `settings` may be NULL for the defaults.
 *
 * Errors: a pixel outside the extent, a plate without distance there, and those of seidel_apply about the depth image.
 *
 * Pointers:
 * Each pointer: NULL, or valid until the call returns.
 */
enum SeidelStatus seidel_distance_at(const struct SeidelLens *lens,
                                     const struct SeidelSettings *settings,
                                     const struct SeidelPlate *plate,
                                     int32_t x,
                                     int32_t y,
                                     double *distance);

/**
 * Copies what speaks against the depth image of a plate to `buffer`, in UTF-8 with a terminating zero: one finding a line, those
 * that are nearly certain first. Such lines begin with `is doubtful: `, those about what is only unusual with `may be intended: `;
 * the words are those of the command. The text is empty if nothing does, or the plate has no depth image. `*needed` gets the size
 * of the whole text in bytes with its zero, 1 if it is empty. seidel_apply renders such plates without a word, so ask once a shot.
 * `settings` may be NULL for the defaults.
 *
 * Errors: those of seidel_apply about the plate; SEIDEL_STATUS_TOO_SMALL if `buffer` is NULL or `capacity` is less than `*needed`,
 * in which case the copy is cut.
 *
 * Pointers:
 * `buffer`: NULL, or `capacity` writable bytes. `needed`: NULL, or a writable place for a number. Other pointers: NULL, or valid
 * until the call returns.
 */
enum SeidelStatus seidel_depth_findings(const struct SeidelLens *lens,
                                        const struct SeidelSettings *settings,
                                        const struct SeidelPlate *plate,
                                        char *buffer,
                                        size_t capacity,
                                        size_t *needed);

/**
 * Ends all threads of the library and waits for the work that they are doing. Call it before the library is
 * unloaded. It also happens when the last lens is released. The library remains usable: the next call starts threads
 * again.
 */
enum SeidelStatus seidel_shutdown(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SEIDEL_H */
